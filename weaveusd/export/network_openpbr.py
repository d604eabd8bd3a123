"""The networks of high fidelity in standard nodes: OpenPBR and standard_surface, MaterialX's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pxr import Sdf

from weaveusd.contract import (
    MTLX_SURFACES,
    MTLX_VARIANTS,
    SHADER_UV_SCALE,
    SHADER_VARNAME,
    lobe_file,
)
from weaveusd.export.attributes import tidy
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.layers import connect, define_shader, interface_input
from weaveusd.export.lobe_nodes import ACROSS, ANISOTROPY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from weaveusd.export.files import LookFiles
    from weaveusd.export.lobe_nodes import Node
    from weaveusd.export.standard import StandardShading

MATERIALX_VERSION = "1.39"

_OUT = "out"
_TYPES = {
    "vector2": "float2",
    "vector3": "float3",
    "color3": "color3f",
    "float": "float",
    "integer": "int",
    "string": "string",
}


@dataclass(frozen=True, slots=True)
class _Maps:
    """Outputs of the nodes that both surfaces read."""

    color: Sdf.Path
    opacity: Sdf.Path
    normal: Sdf.Path
    roughness: Sdf.Path
    across: Sdf.Path


def define_materialx_networks(
    material: Sdf.PrimSpec,
    openpbr: StandardShading,
    standard: StandardShading,
    files: LookFiles = CLOTH_ITSELF,
) -> None:
    """Define an OpenPBR surface and a standard_surface on `outputs:mtlx:surface` of `material`.

    Renderers know one output for MaterialX, so a variant set of the material chooses which
    surface it leads to: OpenPBR unless another opinion says otherwise. Both read the same
    textures. The tangent lies across the fibre: see `StandardShading`. It comes from the lobe
    maps, which a renderer may filter, as do roughness and anisotropy of OpenPBR. Color spaces
    carry the names of MaterialX.

    Raises
    ------
    ValueError
        `material` lacks the public inputs of texture coordinates.
    """
    maps = _define_maps(material, files)
    surfaces = {
        "openPbr": _define_openpbr(material, openpbr, maps),
        "standardSurface": _define_standard_surface(material, standard, maps),
    }
    material.layer.GetAttributeAtPath(
        material.path.AppendPath("MtlxBaseColor.inputs:file")
    ).colorSpace = "srgb_texture"
    # An opinion outside the variants would be stronger than theirs.
    variants = Sdf.VariantSetSpec(material, MTLX_SURFACES)
    for name in MTLX_VARIANTS:
        variant = Sdf.VariantSpec(variants, name)
        connect(variant.primSpec, "outputs:mtlx:surface", "token", surfaces[name])
    material.variantSetNameList.prependedItems = [MTLX_SURFACES]
    material.variantSelections[MTLX_SURFACES] = next(iter(MTLX_VARIANTS))


def _define_maps(material: Sdf.PrimSpec, files: LookFiles) -> _Maps:
    st = define_shader(
        material,
        "MtlxCoordinates",
        "ND_geompropvalue_vector2",
        {"geomprop": ("string", interface_input(material, SHADER_VARNAME))},
        (_OUT, "float2"),
    )
    scale = interface_input(material, SHADER_UV_SCALE)
    repeats = define_shader(
        material,
        "MtlxRepeats",
        "ND_multiply_vector2",
        {"in1": ("float2", st), "in2": ("float2", scale)},
        (_OUT, "float2"),
    )
    path = files.anchored
    color = _image(material, "MtlxBaseColor", path("base_color.png"), "color3", repeats)
    opacity = _image(material, "MtlxOpacity", path("opacity.png"), "float", repeats)
    encoded = _image(material, "MtlxNormalMap", path("normal.png"), "vector3", repeats)
    normal = define_shader(
        material, "MtlxNormal", "ND_normalmap_float", {"in": ("float3", encoded)}, (_OUT, "float3")
    )
    roughness = _image(material, "MtlxRoughness", path(lobe_file("roughness")), "float", repeats)
    _image(material, "MtlxRotation", path(lobe_file("rotation")), "vector2", repeats)
    return _Maps(color, opacity, normal, roughness, _define_nodes(material, ACROSS))


def _define_openpbr(material: Sdf.PrimSpec, shading: StandardShading, maps: _Maps) -> Sdf.Path:
    return define_shader(
        material,
        MTLX_VARIANTS["openPbr"],
        "ND_open_pbr_surface_surfaceshader",
        {
            "base_weight": ("float", tidy(shading.base)),
            "base_color": ("color3f", maps.color),
            "specular_roughness": ("float", maps.roughness),
            "specular_roughness_anisotropy": ("float", _define_nodes(material, ANISOTROPY)),
            "specular_ior": ("float", tidy(shading.ior)),
            "geometry_opacity": ("float", maps.opacity),
            "geometry_normal": ("float3", maps.normal),
            "geometry_tangent": ("float3", maps.across),
        },
        (_OUT, "token"),
    )


def _define_standard_surface(
    material: Sdf.PrimSpec, shading: StandardShading, maps: _Maps
) -> Sdf.Path:
    opacity = define_shader(
        material,
        "MtlxOpacityColor",
        "ND_combine3_color3",
        dict.fromkeys(("in1", "in2", "in3"), ("float", maps.opacity)),
        (_OUT, "color3f"),
    )
    return define_shader(
        material,
        MTLX_VARIANTS["standardSurface"],
        "ND_standard_surface_surfaceshader",
        {
            "base": ("float", tidy(shading.base)),
            "base_color": ("color3f", maps.color),
            "specular_roughness": ("float", tidy(shading.standard_roughness)),
            "specular_anisotropy": ("float", tidy(shading.standard_anisotropy)),
            "specular_IOR": ("float", tidy(shading.ior)),
            "opacity": ("color3f", opacity),
            "normal": ("float3", maps.normal),
            "tangent": ("float3", maps.across),
        },
        (_OUT, "token"),
    )


def _image(material: Sdf.PrimSpec, name: str, file: str, kind: str, st: Sdf.Path) -> Sdf.Path:
    return define_shader(
        material,
        name,
        f"ND_image_{kind}",
        {
            "file": ("asset", file),
            "texcoord": ("float2", st),
            "uaddressmode": ("string", "periodic"),
            "vaddressmode": ("string", "periodic"),
        },
        (_OUT, _TYPES[kind]),
    )


def _define_nodes(material: Sdf.PrimSpec, nodes: Sequence[Node]) -> Sdf.Path:
    """Define `nodes` in their order, and return the output of the last."""
    for node in nodes:
        inputs = {
            key: (_TYPES[kind], _value(material, kind, value))
            for key, (kind, value) in node.inputs.items()
        }
        output = define_shader(
            material,
            _prim_name(node.name),
            f"ND_{node.category}_{node.kind}",
            inputs,
            (_OUT, _TYPES[node.output]),
        )
    return output


def _value(material: Sdf.PrimSpec, kind: str, value: object) -> object:
    if isinstance(value, str) and kind != "string":
        return material.path.AppendPath(f"{_prim_name(value)}.outputs:{_OUT}")
    return value


def _prim_name(node: str) -> str:
    return "Mtlx" + "".join(word.capitalize() for word in node.split("_"))
