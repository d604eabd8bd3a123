"""The MaterialX document: the cloth for renderers without USD, in standard nodes only."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import MaterialX as mx  # noqa: N813

from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.lobe_nodes import ACROSS, ANISOTROPY
from weaveusd.export.mtlx_nodes import (
    add_image,
    add_maps,
    add_material,
    add_nodes,
    add_output,
    connect_output,
    new_document,
    set_numbers,
)
from weaveusd.export.standard import standard_shading

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles
    from weaveusd.export.standard import StandardShading
    from weaveusd.shading.material import ClothMaterial


def write_materialx(material: ClothMaterial, path: Path, files: LookFiles = CLOTH_ITSELF) -> None:
    """Write `material` as a MaterialX document beside the texture folder.

    The document holds an OpenPBR material named as the cloth, and the same as standard_surface
    under ``<name>_standard_surface``. Loaders that know no other nodes read all of it. It reads
    PNGs: those that have USD read the lobe maps, others make mip maps of their own and many no EXR.

    Raises
    ------
    ValueError
        The fit of the cloth is out of range.
    """
    standard, openpbr = (standard_shading(f) for f in (material.fit, material.yarn_fits[0]))
    document = new_document()
    graph = _add_graph(document, f"{material.name}_textures", material.weave.repeat_mm, files)
    _add_openpbr(document, graph, material.name, openpbr)
    _add_standard_surface(document, graph, f"{material.name}_standard_surface", standard)
    path.write_text(mx.writeToXmlString(document), encoding="utf-8")


def _add_graph(document: Any, name: str, repeat_mm: tuple[float, float], files: LookFiles) -> Any:
    graph = document.addNodeGraph(name)
    maps = add_maps(graph, repeat_mm, files)
    roughness = add_image(
        graph, "roughness_map", files.texture("roughness.png"), "float", maps.repeats
    )
    _add_rotation(graph, files.texture("rotation.png"), maps.repeats)
    opacity_color = graph.addNode("combine3", "opacity_color", "color3")
    for channel in ("in1", "in2", "in3"):
        opacity_color.setConnectedNode(channel, maps.opacity)
    for output, node in (
        ("base_color_out", maps.color),
        ("opacity_out", maps.opacity),
        ("opacity_color_out", opacity_color),
        ("roughness_out", roughness),
        ("anisotropy_out", add_nodes(graph, ANISOTROPY)),
        ("normal_out", maps.normal),
        ("across_out", add_nodes(graph, ACROSS)),
    ):
        add_output(graph, output, node)
    return graph


def _add_rotation(graph: Any, file: str, repeats: Any) -> None:
    """Add the rotation, which a PNG has as numbers from 0 to 1."""
    node = graph.addNode("remap", "rotation", "vector2")
    node.addInput("in", "vector2").setConnectedNode(
        add_image(graph, "rotation_map", file, "vector2", repeats)
    )
    set_numbers(node, "outlow", "float", -1.0)
    set_numbers(node, "outhigh", "float", 1.0)


def _add_openpbr(document: Any, graph: Any, name: str, shading: StandardShading) -> None:
    surface = document.addNode("open_pbr_surface", f"{name}_surface", "surfaceshader")
    set_numbers(surface, "base_weight", "float", shading.base)
    connect_output(surface, "specular_roughness", graph, "roughness_out")
    connect_output(surface, "specular_roughness_anisotropy", graph, "anisotropy_out")
    set_numbers(surface, "specular_ior", "float", shading.ior)
    connect_output(surface, "base_color", graph, "base_color_out")
    connect_output(surface, "geometry_opacity", graph, "opacity_out")
    connect_output(surface, "geometry_normal", graph, "normal_out")
    connect_output(surface, "geometry_tangent", graph, "across_out")
    add_material(document, name, surface)


def _add_standard_surface(document: Any, graph: Any, name: str, shading: StandardShading) -> None:
    surface = document.addNode("standard_surface", f"{name}_surface", "surfaceshader")
    set_numbers(surface, "base", "float", shading.base)
    set_numbers(surface, "specular_roughness", "float", shading.standard_roughness)
    set_numbers(surface, "specular_anisotropy", "float", shading.standard_anisotropy)
    set_numbers(surface, "specular_IOR", "float", shading.ior)
    connect_output(surface, "base_color", graph, "base_color_out")
    connect_output(surface, "opacity", graph, "opacity_color_out")
    connect_output(surface, "normal", graph, "normal_out")
    connect_output(surface, "tangent", graph, "across_out")
    add_material(document, name, surface)
