"""Recipes: TOML files that say what the yarns of a cloth are, and presets of ours."""

from __future__ import annotations

import os
from pathlib import Path

from weaveusd.errors import RecipeError
from weaveusd.yarn.model import Recipe
from weaveusd.yarn.spec import read_spec
from weaveusd.yarn.toml import MAX_BYTES, Table, parse_table, read_text

PRESETS = Path(__file__).parent / "presets"
MAX_SPECS = 64


def read_recipe(path: str | os.PathLike[str]) -> Recipe:
    """Return the recipe in the TOML file `path` (the format: docs/recipes.md).

    Raises RecipeError with file, line and key for a key that is missing, unknown or out of
    its limits.
    """
    return recipe_with_text(path=path)[0]


def recipe_with_text(
    *, preset: str | None = None, path: str | os.PathLike[str] | None = None
) -> tuple[Recipe, str]:
    """Return a preset or the recipe of the file `path`, and the TOML that it was parsed from.

    Raises RecipeError as `read_preset` and `read_recipe` do.
    """
    if preset is not None:
        file, place = _preset_file(preset), f"preset {preset}"
    elif path is not None:
        file, place = Path(path), str(path)
    else:
        raise ValueError("expected a preset or a path")
    text = read_text(file, MAX_BYTES, place)
    return _recipe(parse_table(text, place), file.parent), text


def preset_names() -> tuple[str, ...]:
    """Return the names of the presets, sorted."""
    return tuple(sorted(p.stem for p in PRESETS.glob("*.toml")))


def read_preset(name: str) -> Recipe:
    """Return the preset `name`; raises RecipeError that lists the presets there are."""
    return recipe_with_text(preset=name)[0]


def _preset_file(name: str) -> Path:
    if name not in preset_names():
        raise RecipeError(f"no preset {name!r}; there are {', '.join(preset_names())}")
    return PRESETS / f"{name}.toml"


def _recipe(root: Table, folder: Path) -> Recipe:
    sett = root.table("sett")
    weave = root.table("weave", {})
    recipe = Recipe(
        name=root.text("name"),
        title=root.text("title"),
        kind="fabric" if root.text("kind", "yarn", ("yarn", "fabric")) == "fabric" else "yarn",
        source=root.text("source"),
        certainty=root.text("certainty", ""),
        ends_per_cm=_sett(sett, "ends"),
        picks_per_cm=_sett(sett, "picks"),
        crimp_balance=sett.number("crimp_balance", 0, 1, 0.5),
        yarns=tuple(read_spec(t, folder) for t in root.tables("yarn", MAX_SPECS)),
        weave=weave.text("notation", ""),
        finish=root.text("finish", ""),
        weight_g_m2=root.optional("weight_g_m2", 1, 10_000),
    )
    weave.close()
    sett.close()
    root.close()
    return recipe


def _sett(sett: Table, threads: str) -> float:
    """Return the threads per cm, stated as `ends_per_cm` or `ends_per_inch`."""
    key = sett.one_of(f"{threads}_per_cm", f"{threads}_per_inch")
    unit = 2.54 if key.endswith("inch") else 1.0
    return sett.number(key, 0.1 * unit, 1000 * unit) / unit
