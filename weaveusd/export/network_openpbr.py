"""The networks of high fidelity in standard nodes: OpenPBR and standard_surface, MaterialX's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from pxr import Sdf

from weaveusd.contract import MTLX_SURFACES, MTLX_VARIANTS, SHADER_UV_SCALE, SHADER_VARNAME
from weaveusd.export.attributes import tidy
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.layers import connect, define_shader, interface_input

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles
    from weaveusd.export.standard import StandardShading

MATERIALX_VERSION = "1.39"

_OUT = "out"
_TYPES = {"vector3": "float3", "color3": "color3f", "float": "float"}


@dataclass(frozen=True, slots=True)
class _Maps:
    """Outputs of the nodes that both surfaces read."""

    color: Sdf.Path
    opacity: Sdf.Path
    normal: Sdf.Path
    across: Sdf.Path
    repeats: Sdf.Path


def define_materialx_networks(
    material: Sdf.PrimSpec,
    openpbr: StandardShading,
    standard: StandardShading,
    files: LookFiles = CLOTH_ITSELF,
) -> None:
    """Define an OpenPBR surface and a standard_surface on `outputs:mtlx:surface` of `material`.

    Renderers know one output for MaterialX, so a variant set of the material chooses which
    surface it leads to: OpenPBR unless another opinion says otherwise. Both read the same
    textures. The tangent is the normal times the fibre: see `StandardShading`. Color spaces
    carry the names of MaterialX.

    Raises
    ------
    ValueError
        `material` lacks the public inputs of texture coordinates.
    """
    maps = _define_maps(material, files)
    surfaces = {
        "openPbr": _define_openpbr(material, openpbr, maps, files),
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
    normal = _direction(material, "MtlxNormal", path("normal.png"), repeats)
    fibre = _direction(material, "MtlxFibre", path("tangent.png"), repeats)
    across = define_shader(
        material,
        "MtlxAcross",
        "ND_crossproduct_vector3",
        {"in1": ("float3", normal), "in2": ("float3", fibre)},
        (_OUT, "float3"),
    )
    return _Maps(color, opacity, normal, across, repeats)


def _define_openpbr(
    material: Sdf.PrimSpec, shading: StandardShading, maps: _Maps, files: LookFiles
) -> Sdf.Path:
    path = files.anchored
    roughness = _image(material, "MtlxRoughness", path("roughness.png"), "float", maps.repeats)
    anisotropy = _image(material, "MtlxAnisotropy", path("anisotropy.png"), "float", maps.repeats)
    return define_shader(
        material,
        MTLX_VARIANTS["openPbr"],
        "ND_open_pbr_surface_surfaceshader",
        {
            "base_weight": ("float", tidy(shading.base)),
            "base_color": ("color3f", maps.color),
            "specular_roughness": ("float", roughness),
            "specular_roughness_anisotropy": ("float", anisotropy),
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


def _direction(material: Sdf.PrimSpec, name: str, file: str, st: Sdf.Path) -> Sdf.Path:
    """Define the nodes that turn a direction of the cloth frame into one of the world."""
    encoded = _image(material, f"{name}Map", file, "vector3", st)
    return define_shader(
        material, name, "ND_normalmap_float", {"in": ("float3", encoded)}, (_OUT, "float3")
    )
