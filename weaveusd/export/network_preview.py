"""The network that every renderer of USD understands: UsdPreviewSurface."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weaveusd.contract import SHADER_UV_SCALE, SHADER_VARNAME
from weaveusd.export.attributes import tidy
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.layers import connect, define_shader, interface_input

if TYPE_CHECKING:
    from pxr import Sdf

    from weaveusd.export.files import LookFiles
    from weaveusd.export.standard import StandardShading

_RGB = ("rgb", "float3")


def define_preview_network(
    material: Sdf.PrimSpec, shading: StandardShading, files: LookFiles = CLOTH_ITSELF
) -> None:
    """Define a UsdPreviewSurface on `outputs:surface` of `material`.

    Base color, normal and opacity come from the 8- and 16-bit PNGs. Opacity is coverage: it
    fades the highlight along with the color, hence opacityMode `presence`. The surface is
    isotropic, for this shader knows no direction.

    Raises
    ------
    ValueError
        `material` lacks the public inputs of texture coordinates.
    """
    scale = interface_input(material, SHADER_UV_SCALE)
    varname = interface_input(material, SHADER_VARNAME)
    st = define_shader(
        material,
        "PreviewCoordinates",
        "UsdPrimvarReader_float2",
        {"varname": ("string", varname)},
        ("result", "float2"),
    )
    repeats = define_shader(
        material,
        "PreviewRepeats",
        "UsdTransform2d",
        {"in": ("float2", st), "scale": ("float2", scale)},
        ("result", "float2"),
    )
    # As UsdPreviewSurface prescribes for unsigned files; 0 comes back as -1/65535.
    decode: dict[str, tuple[str, object]] = {
        "scale": ("float4", (2.0, 2.0, 2.0, 1.0)),
        "bias": ("float4", (-1.0, -1.0, -1.0, 0.0)),
    }
    # This shader has no weight for its base: the texture's reader scales the color.
    weight: dict[str, tuple[str, object]] = {"scale": ("float4", (*[tidy(shading.base)] * 3, 1.0))}
    path = files.anchored
    color = _texture(
        material, "PreviewBaseColor", path("base_color.png"), "sRGB", repeats, _RGB, weight
    )
    normal = _texture(material, "PreviewNormal", path("normal.png"), "raw", repeats, _RGB, decode)
    opacity = _texture(
        material, "PreviewOpacity", path("opacity.png"), "raw", repeats, ("r", "float"), {}
    )
    surface = define_shader(
        material,
        "PreviewSurface",
        "UsdPreviewSurface",
        {
            "diffuseColor": ("color3f", color),
            "normal": ("normal3f", normal),
            "opacity": ("float", opacity),
            "opacityMode": ("token", "presence"),
            "roughness": ("float", tidy(shading.preview_roughness)),
            "metallic": ("float", 0.0),
            "ior": ("float", tidy(shading.ior)),
            "useSpecularWorkflow": ("int", 0),
        },
        ("surface", "token"),
    )
    connect(material, "outputs:surface", "token", surface)


def _texture(
    material: Sdf.PrimSpec,
    name: str,
    file: str,
    space: str,
    st: Sdf.Path,
    output: tuple[str, str],
    scaling: dict[str, tuple[str, object]],
) -> Sdf.Path:
    return define_shader(
        material,
        name,
        "UsdUVTexture",
        {
            "file": ("asset", file),
            "sourceColorSpace": ("token", space),
            "st": ("float2", st),
            "wrapS": ("token", "repeat"),
            "wrapT": ("token", "repeat"),
            **scaling,
        },
        output,
    )
