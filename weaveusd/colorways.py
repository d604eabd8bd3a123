"""What is published together: recipes of one draft, or other palettes for it, by name."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from weaveusd.contract import MAX_COLORWAYS
from weaveusd.errors import DraftError, InputError

if TYPE_CHECKING:
    from weaveusd.draft.model import Draft
    from weaveusd.yarn.model import Recipe

PathLike = str | os.PathLike[str]


@dataclass(frozen=True, slots=True)
class Source:
    """What a colorway is made from: a recipe, its text, and perhaps a WIF file of other colors."""

    recipe: Recipe
    text: str
    palette: PathLike | None = None


def read_recipe(*, preset: str | None, recipe: PathLike | None) -> Recipe:
    """Return the preset or the recipe file, whichever is given; raises InputError for both."""
    return _source(preset, recipe).recipe


def read_colorways(
    preset: str | None, recipe: PathLike | None, others: Mapping[str, PathLike]
) -> dict[str, Source]:
    """Return the source of every colorway by its name; the default, of `preset` or `recipe`, first.

    Of `others` what ends in ``.toml`` is a recipe's file, what ends in ``.wif`` a draft whose
    palette the first recipe gets, and all else a preset.

    Raises
    ------
    InputError
        A name is not safe or comes twice, there are too many, or a recipe is broken.
    """
    from weaveusd.export.names import safe_name

    first = _source(preset, recipe)
    found = {safe_name(first.recipe.name): first}
    if len(others) >= MAX_COLORWAYS:
        raise InputError(f"{len(others) + 1} colorways, expected at most {MAX_COLORWAYS}")
    for name, what in others.items():
        if safe_name(name) != name:
            raise InputError(f"colorway {name[:80]!r}: expected a name such as {safe_name(name)!r}")
        if name in found:
            raise InputError(f"colorway {name!r}: the default recipe has that name")
        text = os.fspath(what)
        if text.endswith(".wif"):
            found[name] = replace(first, palette=what)
        elif text.endswith(".toml"):
            found[name] = _source(None, what)
        else:
            found[name] = _source(text, None)
    return found


def repainted(draft: Draft, palette: PathLike) -> Draft:
    """Return `draft` with the colors of the WIF file `palette`, entry for entry.

    Raises
    ------
    DraftError
        The file is broken, or has fewer colors than `draft` uses.
    """
    from weaveusd.draft.wif import load_wif, parse_wif

    colors = parse_wif(load_wif(palette), os.fspath(palette)).palette
    used = 1 + max(int(draft.warp_color.max()), int(draft.weft_color.max()))
    if len(colors) < used:
        raise DraftError(
            f"{os.fspath(palette)}: has {len(colors)} colors, "
            f"expected at least the {used} that the draft uses"
        )
    return replace(draft, palette=colors)


def _source(preset: str | None, recipe: PathLike | None) -> Source:
    from weaveusd.yarn.recipe import recipe_with_text

    if (preset is None) == (recipe is None):
        raise InputError("expected a preset or a recipe, exactly one of them")
    return Source(*recipe_with_text(preset=preset, path=recipe))
