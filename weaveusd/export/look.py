"""The look layer: the material, what it says about its cloth, and its networks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from weaveusd.contract import (
    CLOTH_API,
    CLOTH_ATTRIBUTES,
    CLOTH_NAMESPACE,
    DEFAULT_ST,
    MATERIAL_NAME,
    SHADER_UV_SCALE,
    SHADER_VARNAME,
    YARN_API,
    YARN_ATTRIBUTES,
    YARN_NAMESPACE,
)
from weaveusd.export.attributes import cloth_values, tidy, yarn_values
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.layers import apply_schemas, author, define_prim
from weaveusd.export.moments import system_maps
from weaveusd.export.network_glslfx import define_glslfx_network
from weaveusd.export.network_mitsuba import define_mitsuba_network, optics_of
from weaveusd.export.network_openpbr import MATERIALX_VERSION, define_materialx_networks
from weaveusd.export.network_preview import define_preview_network
from weaveusd.export.standard import standard_shading

if TYPE_CHECKING:
    from pxr import Sdf

    from weaveusd.export.attributes import Value
    from weaveusd.export.files import LookFiles
    from weaveusd.shading.material import ClothMaterial

UV_SCALE_DOC = (
    "Repeats of the cloth in one unit of the texture coordinates. As published it is one over "
    "the repeat in metres, for texture coordinates in metres. With coordinates in another unit "
    "or in 0…1, multiply it by that unit, or by the size of the surface, in metres."
)
VARNAME_DOC = "Name of the primvar that holds the texture coordinates."


def define_look(
    root: Sdf.PrimSpec,
    material: ClothMaterial,
    cover: float,
    files: LookFiles = CLOTH_ITSELF,
    *,
    glslfx: bool = False,
) -> None:
    """Define the material of a cloth below `root`, in a layer beside the texture folder.

    Every attribute of both schemas is authored, so that a reader without our plugin sees all.
    `cover` is the mean of the opacity texture, `files` says where the textures are.
    With `glslfx` there is a network for Storm, which prefers it to all others.

    Raises
    ------
    ValueError
        A fit of the cloth is out of range.
    """
    preview = standard_shading(material.fits.isotropic)
    openpbr = standard_shading(material.fits.yarns[0])
    standard = standard_shading(material.fits.together)
    cloth, yarns = cloth_values(material, cover, files), yarn_values(material)
    optics = optics_of(material)
    prim = define_prim(root, MATERIAL_NAME, "Material")
    apply_schemas(
        prim, [CLOTH_API, *(f"{YARN_API}:{name}" for name in yarns), "MaterialXConfigAPI"]
    )
    author(prim, "config:mtlx:version", "string", MATERIALX_VERSION, uniform=True)
    _author_attributes(prim, cloth, yarns)
    _author_interface(prim, material.weave.repeat_mm)
    define_preview_network(prim, preview, files)
    define_materialx_networks(prim, openpbr, standard, files)
    define_mitsuba_network(prim, optics, system_maps(material.weave), material.color_space, files)
    if glslfx:
        define_glslfx_network(prim, files)


def _author_attributes(
    prim: Sdf.PrimSpec, cloth: Mapping[str, Value], yarns: Mapping[str, Mapping[str, Value]]
) -> None:
    for attribute in CLOTH_ATTRIBUTES:
        name = f"{CLOTH_NAMESPACE}:{attribute.name}"
        author(prim, name, attribute.type, cloth[attribute.name], uniform=True)
    for instance, values in yarns.items():
        for attribute in YARN_ATTRIBUTES:
            name = f"{YARN_NAMESPACE}:{instance}:{attribute.name}"
            author(prim, name, attribute.type, values[attribute.name], uniform=True)


def _author_interface(prim: Sdf.PrimSpec, repeat_mm: tuple[float, float]) -> None:
    scale = tuple(tidy(1000 / length) for length in repeat_mm)
    author(prim, f"inputs:{SHADER_UV_SCALE}", "float2", scale).documentation = UV_SCALE_DOC
    author(prim, f"inputs:{SHADER_VARNAME}", "string", DEFAULT_ST).documentation = VARNAME_DOC
