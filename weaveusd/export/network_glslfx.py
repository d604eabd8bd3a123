"""The network for Storm and usdview: our cloth shader in glslfx, on request only."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pxr import Sdf

from weaveusd.contract import GLSLFX_CONTEXT, SHADER_UV_SCALE, SHADER_VARNAME
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.layers import author, connect, define_prim, define_shader, interface_input

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles

_SIGNED: dict[str, tuple[str, object]] = {
    "scale": ("float4", (2.0, 2.0, 2.0, 1.0)),
    "bias": ("float4", (-1.0, -1.0, -1.0, 0.0)),
}


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
    scale = interface_input(material, SHADER_UV_SCALE)
    varname = interface_input(material, SHADER_VARNAME)
    st = define_shader(
        material,
        "GlslfxCoordinates",
        "UsdPrimvarReader_float2",
        {"varname": ("string", varname)},
        ("result", "float2"),
    )
    repeats = define_shader(
        material,
        "GlslfxRepeats",
        "UsdTransform2d",
        {"in": ("float2", st), "scale": ("float2", scale)},
        ("result", "float2"),
    )

    def texture(
        name: str, file: str, output: tuple[str, str], space: str = "raw", *, signed: bool = False
    ) -> Sdf.Path:
        inputs: dict[str, tuple[str, object]] = {
            "file": ("asset", files.anchored(file)),
            "sourceColorSpace": ("token", space),
            "st": ("float2", repeats),
            "wrapS": ("token", "repeat"),
            "wrapT": ("token", "repeat"),
            **(_SIGNED if signed else {}),
        }
        return define_shader(material, name, "UsdUVTexture", inputs, output)

    rgb, red = ("rgb", "float3"), ("r", "float")
    inputs = {
        "base_color": ("color3f", texture("GlslfxBaseColor", "base_color.png", rgb, "sRGB")),
        "normal": ("float3", texture("GlslfxNormal", "normal.png", rgb, signed=True)),
        "fibre": ("float3", texture("GlslfxFibre", "tangent.png", rgb, signed=True)),
        "opacity": ("float", texture("GlslfxOpacity", "opacity.png", red)),
        "yarn_id": ("float", texture("GlslfxYarnId", "yarn_id.png", red)),
        "st": ("float2", st),
    }
    surface = define_prim(material, "GlslfxSurface", "Shader")
    author(surface, "info:implementationSource", "token", "sourceAsset", uniform=True)
    author(surface, "info:glslfx:sourceAsset", "asset", f"./{files.glslfx}", uniform=True)
    for name, (kind, source) in inputs.items():
        connect(surface, f"inputs:{name}", kind, source)
    out = Sdf.AttributeSpec(surface, "outputs:surface", Sdf.ValueTypeNames.Token)
    connect(material, f"outputs:{GLSLFX_CONTEXT}:surface", "token", out.path)
