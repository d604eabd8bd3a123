"""The network for Storm and usdview: our cloth shader in glslfx, on request only."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pxr import Sdf

from weaveusd.contract import GLSLFX_CONTEXT
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.layers import author, connect, define_prim
from weaveusd.export.uv_textures import RED, RGB, SIGNED, define_coordinates, define_texture

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles


def define_glslfx_network(material: Sdf.PrimSpec, files: LookFiles = CLOTH_ITSELF) -> None:
    """Define our shader on `outputs:glslfx:surface` of `material`; Storm prefers it to MaterialX.

    The optics of the yarns are in the shader's file, which `glslfx_text` makes. Normal and fibre
    are directions of the cloth frame, -1…1; the yarn id is that of the file over 255, filtered as
    Storm filters every texture.

    Raises
    ------
    ValueError
        `material` lacks the public inputs of texture coordinates.
    """
    st, repeats = define_coordinates(material, "Glslfx")

    def texture(name: str, file: str, output: tuple[str, str], **settings: Any) -> Sdf.Path:
        return define_texture(
            material, f"Glslfx{name}", files.anchored(file), repeats, output, **settings
        )

    inputs = {
        "base_color": ("color3f", texture("BaseColor", "base_color.png", RGB, space="sRGB")),
        "normal": ("float3", texture("Normal", "normal.png", RGB, values=SIGNED)),
        "fibre": ("float3", texture("Fibre", "tangent.png", RGB, values=SIGNED)),
        "opacity": ("float", texture("Opacity", "opacity.png", RED)),
        "yarn_id": ("float", texture("YarnId", "yarn_id.png", RED)),
        "st": ("float2", st),
    }
    surface = define_prim(material, "GlslfxSurface", "Shader")
    author(surface, "info:implementationSource", "token", "sourceAsset", uniform=True)
    author(surface, "info:glslfx:sourceAsset", "asset", f"./{files.glslfx}", uniform=True)
    for name, (kind, source) in inputs.items():
        connect(surface, f"inputs:{name}", kind, source)
    out = Sdf.AttributeSpec(surface, "outputs:surface", Sdf.ValueTypeNames.Token)
    connect(material, f"outputs:{GLSLFX_CONTEXT}:surface", "token", out.path)
