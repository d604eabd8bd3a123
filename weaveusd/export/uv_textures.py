"""USD's own nodes for textures: coordinates in repeats of the cloth, and readers of files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weaveusd.contract import SHADER_UV_SCALE, SHADER_VARNAME
from weaveusd.export.layers import define_shader, interface_input

if TYPE_CHECKING:
    from collections.abc import Mapping

    from pxr import Sdf

RGB = ("rgb", "float3")
RED = ("r", "float")
"""Outputs of a texture's reader: name and type."""

SIGNED: dict[str, tuple[str, object]] = {
    "scale": ("float4", (2.0, 2.0, 2.0, 1.0)),
    "bias": ("float4", (-1.0, -1.0, -1.0, 0.0)),
}
"""Inputs of a reader of unsigned vectors, as UsdPreviewSurface prescribes; 0 is -1/65535 then."""


def define_coordinates(material: Sdf.PrimSpec, prefix: str) -> tuple[Sdf.Path, Sdf.Path]:
    """Define the texture coordinates below `material`, in prims whose names begin with `prefix`.

    Returns
    -------
    (Sdf.Path, Sdf.Path)
        Outputs of type float2: the coordinates of the primvar, and those in repeats.

    Raises
    ------
    ValueError
        `material` lacks the public inputs of texture coordinates.
    """
    scale = interface_input(material, SHADER_UV_SCALE)
    varname = interface_input(material, SHADER_VARNAME)
    st = define_shader(
        material,
        f"{prefix}Coordinates",
        "UsdPrimvarReader_float2",
        {"varname": ("string", varname)},
        ("result", "float2"),
    )
    repeats = define_shader(
        material,
        f"{prefix}Repeats",
        "UsdTransform2d",
        {"in": ("float2", st), "scale": ("float2", scale)},
        ("result", "float2"),
    )
    return st, repeats


def define_texture(
    material: Sdf.PrimSpec,
    name: str,
    file: str,
    repeats: Sdf.Path,
    output: tuple[str, str],
    *,
    space: str = "raw",
    values: Mapping[str, tuple[str, object]] | None = None,
) -> Sdf.Path:
    """Define the reader of the anchored path `file`, which repeats, and return its output.

    `values` are the inputs `scale`, `bias` and `fallback` where they are not as the node has them.
    """
    return define_shader(
        material,
        name,
        "UsdUVTexture",
        {
            "file": ("asset", file),
            "sourceColorSpace": ("token", space),
            "st": ("float2", repeats),
            "wrapS": ("token", "repeat"),
            "wrapT": ("token", "repeat"),
            **(values or {}),
        },
        output,
    )
