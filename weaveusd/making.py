"""From a draft and a recipe to a cloth in memory."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from weaveusd._version import __version__
from weaveusd.colorways import repainted

if TYPE_CHECKING:
    from weaveusd.contract import ColorSpace
    from weaveusd.draft.model import Draft
    from weaveusd.patch import Patch
    from weaveusd.shading.material import ClothMaterial
    from weaveusd.yarn.model import Recipe

PathLike = str | os.PathLike[str]


@dataclass(frozen=True, slots=True)
class DraftFile:
    """A WIF file as read: its draft, the SHA-256 of its bytes, and the personal fields to keep."""

    draft: Draft
    sha256: str
    personal: Mapping[str, str]


def read_draft(path: PathLike, *, keep_personal: bool = False) -> DraftFile:
    """Return what the WIF file `path` says; of the person who drew it only with `keep_personal`.

    Raises
    ------
    DraftError
        The file cannot be read or is no complete draft.
    """
    from weaveusd.draft.personal import personal_fields
    from weaveusd.draft.wif import load_wif, parse_wif

    data, name = load_wif(path), os.fspath(path)
    draft = parse_wif(data, name)
    personal = personal_fields(data, name) if keep_personal else {}
    return DraftFile(draft, hashlib.sha256(data).hexdigest(), personal)


def make_material(
    draft: DraftFile,
    recipe: Recipe,
    name: str,
    *,
    patch: Patch,
    recipe_toml: str = "",
    palette: PathLike | None = None,
    seed: int = 0,
    color_space: ColorSpace = "lin_rec709",
    jobs: int | None = None,
) -> ClothMaterial:
    """Return the material of a patch of `draft` and `recipe`, in memory.

    `recipe_toml` is the text that `recipe` was read from, which the asset keeps; `palette` a WIF
    file whose colors stand for those of the draft.
    """
    from weaveusd.cloth.weave import weave
    from weaveusd.draft.write import write_wif
    from weaveusd.shading.material import Provenance
    from weaveusd.shading.shade import shade
    from weaveusd.synth.textures import synthesize

    parsed = draft.draft if palette is None else repainted(draft.draft, palette)
    whole, resolution = patch.cut(parsed, recipe)
    cloth = weave(whole, recipe, color_space=color_space)
    provenance = Provenance(
        draft_title=parsed.title,
        draft_sha256=draft.sha256,
        draft_wif=write_wif(parsed, draft.personal),
        shafts=parsed.shafts,
        recipe=recipe.name,
        recipe_source=recipe.source,
        tool_version=__version__,
        recipe_toml=recipe_toml.encode(),
        repeats=(whole.ends // parsed.ends, whole.picks // parsed.picks),
    )
    textures = synthesize(cloth, resolution=resolution, seed=seed, jobs=jobs)
    return shade(name, cloth, textures, provenance)
