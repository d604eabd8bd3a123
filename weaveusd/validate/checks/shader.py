"""Whether the exact shader is there, whole and says what the attributes say."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from pxr import Sdf, Usd, UsdShade

from weaveusd.contract import (
    CLOTH_SHADER_ID,
    MITSUBA_CONTEXT,
    SHADER_FILES,
    SHADER_UV_SCALE,
    SHADER_VARNAME,
    SHADER_YARN_ARRAYS,
)
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

ABSENT = Code("shader-missing", Status.FAIL, "The exact shader is not connected, or another is.")
INPUT = Code("shader-input-missing", Status.FAIL, "An input of the exact shader has no value.")
TYPE = Code("shader-input-type", Status.FAIL, "An input of the exact shader has another type.")
FILE = Code("shader-file", Status.FAIL, "An input of the exact shader names another texture.")
LENGTH = Code(
    "shader-array-length", Status.FAIL, "An array of the exact shader has no value for each yarn."
)
VALUE = Code(
    "shader-disagrees", Status.FAIL, "An array of the exact shader differs from the attributes."
)

TYPES: dict[str, str] = {
    **dict.fromkeys(SHADER_FILES, "asset"),
    **dict.fromkeys(SHADER_YARN_ARRAYS, "float[]"),
    SHADER_UV_SCALE: "float2",
    SHADER_VARNAME: "string",
}
"""Sdf type of every input."""

ATTRIBUTES = {
    "eta": "eta",
    "k_d": "kD",
    "k_s": "kS",
    "gamma_s": "gammaS",
    "gamma_v": "gammaV",
    "tau": "tau",
    "normalization": "normalization",
    "albedo_gain": "albedoGain",
}
"""The yarn attribute that says the same as an array of the shader."""

FLOAT_TOLERANCE = 1e-6
"""A float differs from the double that it was rounded from by less, relatively."""


@check(
    id="shader/exact",
    why="The exact renderer reads this shader and nothing else; USD lets any input through.",
    needs=("material",),
    codes=(ABSENT, INPUT, TYPE, FILE, LENGTH, VALUE),
)
def exact_shader(asset: OpenAsset) -> Iterator[Finding]:
    """The exact shader has every input, and its arrays agree with the yarns' attributes."""
    prim = asset.shader
    if not prim:
        output = f"outputs:{MITSUBA_CONTEXT}:surface"
        yield ABSENT(f"{output} is not connected", str(asset.material.GetPath()))
        return
    if UsdShade.Shader(prim).GetIdAttr().Get() != CLOTH_SHADER_ID:
        found = UsdShade.Shader(prim).GetIdAttr().Get()
        yield ABSENT(f"has id {found!r}, expected {CLOTH_SHADER_ID!r}", str(prim.GetPath()))
        return
    for name, kind in TYPES.items():
        yield from _judge_input(asset, prim, name, kind)


def _judge_input(asset: OpenAsset, prim: Usd.Prim, name: str, kind: str) -> Iterator[Finding]:
    path = f"{prim.GetPath()}.inputs:{name}"
    value = input_value(prim, name)
    if value is None:
        yield INPUT("has no value", path)
        return
    found = UsdShade.Shader(prim).GetInput(name).GetTypeName()
    if str(found) != kind:
        yield TYPE(f"has type {found}, expected {kind}", path)
    elif name in SHADER_FILES:
        expected = asset.texture_path(SHADER_FILES[name])
        if isinstance(value, Sdf.AssetPath) and not value.path.endswith(expected[1:]):
            yield FILE(f"is @{value.path}@, expected @{expected}@", path)
    elif name in SHADER_YARN_ARRAYS:
        if len(value) != len(asset.yarns):
            yield LENGTH(f"has {len(value)} values, expected {len(asset.yarns)}, one a yarn", path)
            return
        for yarn, number in zip(asset.yarns, value, strict=True):
            stated = asset.yarn(yarn, ATTRIBUTES[name])
            if stated is not None and not math.isclose(number, stated, rel_tol=FLOAT_TOLERANCE):
                yield VALUE(f"is {number:.9g} for {yarn}, whose attribute says {stated:.9g}", path)


def input_value(prim: Usd.Prim, name: str) -> Any:
    """Return the value that reaches the input `name` of the shader `prim`, or None.

    Connections are followed to the interface of the material.
    """
    shader_input = UsdShade.Shader(prim).GetInput(name)
    if not shader_input:
        return None
    sources = UsdShade.Utils.GetValueProducingAttributes(shader_input)
    return sources[0].Get() if sources else None
