"""From a draft and a recipe to a cloth in memory."""

from __future__ import annotations

import hashlib
import os
from typing import TYPE_CHECKING

from weaveusd._version import __version__
from weaveusd.colorways import repainted

if TYPE_CHECKING:
    from weaveusd.contract import ColorSpace
    from weaveusd.patch import Patch
    from weaveusd.shading.material import ClothMaterial
    from weaveusd.yarn.model import Recipe

PathLike = str | os.PathLike[str]


def make_material(
    draft: PathLike,
    recipe: Recipe,
    name: str,
    *,
    patch: Patch,
    recipe_toml: str = "",
    palette: PathLike | None = None,
    seed: int = 0,
    color_space: ColorSpace = "lin_rec709",
    keep_personal: bool = False,
    jobs: int | None = None,
) -> ClothMaterial:
    """Return the material of a patch of the WIF file `draft` and `recipe`, in memory.

    `recipe_toml` is the text that `recipe` was read from, which the asset keeps; `palette` a WIF
    file whose colors stand for those of the draft.
    """
    from weaveusd.cloth.weave import weave
    from weaveusd.draft.personal import personal_fields
    from weaveusd.draft.wif import load_wif, parse_wif
    from weaveusd.draft.write import write_wif
    from weaveusd.shading.material import Provenance
    from weaveusd.shading.shade import shade
    from weaveusd.synth.textures import synthesize

    data = load_wif(draft)
    parsed = parse_wif(data, os.fspath(draft))
    if palette is not None:
        parsed = repainted(parsed, palette)
    whole, resolution = patch.cut(parsed, recipe)
    cloth = weave(whole, recipe, color_space=color_space)
    personal = personal_fields(data, os.fspath(draft)) if keep_personal else None
    provenance = Provenance(
        draft_title=parsed.title,
        draft_sha256=hashlib.sha256(data).hexdigest(),
        draft_wif=write_wif(parsed, personal),
        shafts=parsed.shafts,
        recipe=recipe.name,
        recipe_source=recipe.source,
        tool_version=__version__,
        recipe_toml=recipe_toml.encode(),
        repeats=(whole.ends // parsed.ends, whole.picks // parsed.picks),
    )
    textures = synthesize(cloth, resolution=resolution, seed=seed, jobs=jobs)
    return shade(name, cloth, textures, provenance)
