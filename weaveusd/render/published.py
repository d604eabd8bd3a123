"""The exact cloth of a published asset, for a Mitsuba scene of one's own.

Import this module after `weaveusd.render.variant.prepare`, as `weaveusd.render.bsdf`.
"""

from __future__ import annotations

import os
from typing import Any

from pxr import Usd, UsdShade

from weaveusd.contract import CLOTH_SHADER_ID
from weaveusd.errors import StageError
from weaveusd.render.cloth import translate
from weaveusd.render.model import Losses
from weaveusd.stage import open_stage


def published_bsdf(entry: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the dictionary from which `mi.load_dict` makes the cloth of the asset `entry`.

    Texture coordinates are those of the asset: as published, a unit is a metre of cloth.
    `repeats_u` and `repeats_v` of the dictionary are the repeats in one unit; multiply them for
    other coordinates.

    Raises
    ------
    StageError
        The stage cannot be opened, holds no exact cloth, or its cloth is broken.
    """
    stage = open_stage(entry)
    for prim in stage.Traverse():
        shader = UsdShade.Shader(prim)
        if shader and shader.GetIdAttr().Get() == CLOTH_SHADER_ID:
            made, _ = translate(shader, Usd.TimeCode.Default(), Losses())
            return made
    raise StageError(f"{os.fspath(entry)}: holds no {CLOTH_SHADER_ID} shader")
