"""The network of high fidelity in standard nodes: OpenPBR by way of MaterialX."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weaveusd.contract import SHADER_UV_SCALE, SHADER_VARNAME, TEXTURE_DIR
from weaveusd.export.attributes import tidy
from weaveusd.export.layers import connect, define_shader, interface_input

if TYPE_CHECKING:
    from pxr import Sdf

    from weaveusd.export.standard import StandardShading

MATERIALX_VERSION = "1.39"

_OUT = "out"
_TYPES = {"vector3": "float3", "color3": "color3f", "float": "float"}


def define_openpbr_network(material: Sdf.PrimSpec, shading: StandardShading) -> None:
    """Define an OpenPBR surface on `outputs:mtlx:surface` of `material`.

    The tangent is the normal times the fibre: see `StandardShading`. Color spaces carry the
    names of MaterialX.

    Raises
    ------
    ValueError
        `material` lacks the public inputs of texture coordinates.
    """
    scale = interface_input(material, SHADER_UV_SCALE)
    varname = interface_input(material, SHADER_VARNAME)
    st = define_shader(
        material,
        "MtlxCoordinates",
        "ND_geompropvalue_vector2",
        {"geomprop": ("string", varname)},
        (_OUT, "float2"),
    )
    repeats = define_shader(
        material,
        "MtlxRepeats",
        "ND_multiply_vector2",
        {"in1": ("float2", st), "in2": ("float2", scale)},
        (_OUT, "float2"),
    )
    color = _image(material, "MtlxBaseColor", "base_color.png", "color3", repeats)
    opacity = _image(material, "MtlxOpacity", "opacity.png", "float", repeats)
    roughness = _image(material, "MtlxRoughness", "roughness.png", "float", repeats)
    anisotropy = _image(material, "MtlxAnisotropy", "anisotropy.png", "float", repeats)
    normal = _direction(material, "MtlxNormal", "normal.png", repeats)
    fibre = _direction(material, "MtlxFibre", "tangent.png", repeats)
    across = define_shader(
        material,
        "MtlxAcross",
        "ND_crossproduct_vector3",
        {"in1": ("float3", normal), "in2": ("float3", fibre)},
        (_OUT, "float3"),
    )
    surface = define_shader(
        material,
        "MtlxSurface",
        "ND_open_pbr_surface_surfaceshader",
        {
            "base_weight": ("float", tidy(shading.base)),
            "base_color": ("color3f", color),
            "specular_roughness": ("float", roughness),
            "specular_roughness_anisotropy": ("float", anisotropy),
            "specular_ior": ("float", tidy(shading.ior)),
            "geometry_opacity": ("float", opacity),
            "geometry_normal": ("float3", normal),
            "geometry_tangent": ("float3", across),
        },
        (_OUT, "token"),
    )
    material.layer.GetAttributeAtPath(
        material.path.AppendPath("MtlxBaseColor.inputs:file")
    ).colorSpace = "srgb_texture"
    connect(material, "outputs:mtlx:surface", "token", surface)


def _image(material: Sdf.PrimSpec, name: str, file: str, kind: str, st: Sdf.Path) -> Sdf.Path:
    return define_shader(
        material,
        name,
        f"ND_image_{kind}",
        {
            "file": ("asset", f"./{TEXTURE_DIR}/{file}"),
            "texcoord": ("float2", st),
            "uaddressmode": ("string", "periodic"),
            "vaddressmode": ("string", "periodic"),
        },
        (_OUT, _TYPES[kind]),
    )


def _direction(material: Sdf.PrimSpec, name: str, file: str, st: Sdf.Path) -> Sdf.Path:
    """Define the nodes that turn a direction of the cloth frame into one of the world."""
    encoded = _image(material, f"{name}Map", file, "vector3", st)
    return define_shader(
        material, name, "ND_normalmap_float", {"in": ("float3", encoded)}, (_OUT, "float3")
    )
