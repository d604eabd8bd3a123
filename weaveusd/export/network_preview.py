"""The network that every renderer of USD understands: UsdPreviewSurface."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weaveusd.contract import lobe_file
from weaveusd.export.attributes import tidy
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.layers import connect, define_shader
from weaveusd.export.uv_textures import RED, RGB, SIGNED, define_coordinates, define_texture

if TYPE_CHECKING:
    from pxr import Sdf

    from weaveusd.export.files import LookFiles
    from weaveusd.export.standard import StandardShading


def define_preview_network(
    material: Sdf.PrimSpec, shading: StandardShading, files: LookFiles = CLOTH_ITSELF
) -> None:
    """Define a UsdPreviewSurface on `outputs:surface` of `material`.

    Base color, normal and opacity come from the 8- and 16-bit PNGs, roughness from the lobe maps.
    Opacity is coverage: it fades the highlight along with the color, hence opacityMode
    `presence`. The surface is isotropic, for this shader knows no direction; readers that cannot
    load an EXR get one roughness for all yarns.

    Raises
    ------
    ValueError
        `material` lacks the public inputs of texture coordinates.
    """
    _, repeats = define_coordinates(material, "Preview")
    # This shader has no weight for its base: the texture's reader scales the color.
    weight: dict[str, tuple[str, object]] = {"scale": ("float4", (*[tidy(shading.base)] * 3, 1.0))}
    path = files.anchored
    color = define_texture(
        material, "PreviewBaseColor", path("base_color.png"), repeats, RGB,
        space="sRGB", values=weight,
    )  # fmt: skip
    normal = define_texture(
        material, "PreviewNormal", path("normal.png"), repeats, RGB, values=SIGNED
    )
    opacity = define_texture(material, "PreviewOpacity", path("opacity.png"), repeats, RED)
    even = tidy(shading.preview_roughness)
    roughness = define_texture(
        material, "PreviewRoughness", path(lobe_file("preview_roughness")), repeats, RED,
        values={"fallback": ("float4", (even, even, even, 1.0))},
    )  # fmt: skip
    surface = define_shader(
        material,
        "PreviewSurface",
        "UsdPreviewSurface",
        {
            "diffuseColor": ("color3f", color),
            "normal": ("normal3f", normal),
            "opacity": ("float", opacity),
            "opacityMode": ("token", "presence"),
            "roughness": ("float", roughness),
            "metallic": ("float", 0.0),
            "ior": ("float", tidy(shading.ior)),
            "useSpecularWorkflow": ("int", 0),
        },
        ("surface", "token"),
    )
    connect(material, "outputs:surface", "token", surface)
