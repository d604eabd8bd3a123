"""The MaterialX document: the cloth for renderers without USD, in standard nodes only."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import MaterialX as mx  # noqa: N813

from weaveusd.export.attributes import tidy
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.network_openpbr import MATERIALX_VERSION
from weaveusd.export.standard import standard_shading

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles
    from weaveusd.export.standard import StandardShading
    from weaveusd.shading.material import ClothMaterial


def write_materialx(material: ClothMaterial, path: Path, files: LookFiles = CLOTH_ITSELF) -> None:
    """Write `material` as a MaterialX document beside the texture folder.

    The document holds an OpenPBR material named as the cloth, and the same as standard_surface
    under ``<name>_standard_surface``. The node ``repeats`` multiplies the texture coordinates,
    in metres, by the repeats in one metre. The tangent is the normal times the fibre: see
    `StandardShading`.

    Raises
    ------
    ValueError
        The fit of the cloth is out of range.
    """
    standard, openpbr = (standard_shading(f) for f in (material.fit, material.yarn_fits[0]))
    document = mx.createDocument()
    document.setVersionString(MATERIALX_VERSION)
    # Without a space of its own a document leaves sRGB textures undecoded, silently.
    document.setColorSpace("lin_rec709")
    graph = _add_graph(document, f"{material.name}_textures", material.weave.repeat_mm, files)
    _add_openpbr(document, graph, material.name, openpbr)
    _add_standard_surface(document, graph, f"{material.name}_standard_surface", standard)
    path.write_text(mx.writeToXmlString(document), encoding="utf-8")


def _add_graph(document: Any, name: str, repeat_mm: tuple[float, float], files: LookFiles) -> Any:
    graph = document.addNodeGraph(name)
    coordinates = graph.addNode("texcoord", "coordinates", "vector2")
    repeats = graph.addNode("multiply", "repeats", "vector2")
    repeats.setConnectedNode("in1", coordinates)
    _set_numbers(repeats, "in2", "vector2", *(1000 / length for length in repeat_mm))
    color = _add_image(graph, "base_color_map", files.texture("base_color.png"), "color3", repeats)
    color.getInput("file").setColorSpace("srgb_texture")
    opacity = _add_image(graph, "opacity_map", files.texture("opacity.png"), "float", repeats)
    roughness = _add_image(graph, "roughness_map", files.texture("roughness.png"), "float", repeats)
    anisotropy = _add_image(
        graph, "anisotropy_map", files.texture("anisotropy.png"), "float", repeats
    )
    normal = _add_direction(graph, "normal", files.texture("normal.png"), repeats)
    fibre = _add_direction(graph, "fibre", files.texture("tangent.png"), repeats)
    across = graph.addNode("crossproduct", "across", "vector3")
    across.setConnectedNode("in1", normal)
    across.setConnectedNode("in2", fibre)
    opacity_color = graph.addNode("combine3", "opacity_color", "color3")
    for channel in ("in1", "in2", "in3"):
        opacity_color.setConnectedNode(channel, opacity)
    for name, node in (
        ("base_color_out", color),
        ("opacity_out", opacity),
        ("opacity_color_out", opacity_color),
        ("roughness_out", roughness),
        ("anisotropy_out", anisotropy),
        ("normal_out", normal),
        ("across_out", across),
    ):
        graph.addOutput(name, node.getType()).setConnectedNode(node)
    return graph


def _add_image(graph: Any, name: str, file: str, kind: str, texcoord: Any) -> Any:
    image = graph.addNode("image", name, kind)
    image.setInputValue("file", file, "filename")
    image.setConnectedNode("texcoord", texcoord)
    image.setInputValue("uaddressmode", "periodic")
    image.setInputValue("vaddressmode", "periodic")
    return image


def _add_direction(graph: Any, name: str, file: str, texcoord: Any) -> Any:
    encoded = _add_image(graph, f"{name}_map", file, "vector3", texcoord)
    node = graph.addNode("normalmap", name, "vector3")
    node.setConnectedNode("in", encoded)
    return node


def _add_openpbr(document: Any, graph: Any, name: str, shading: StandardShading) -> None:
    surface = document.addNode("open_pbr_surface", f"{name}_surface", "surfaceshader")
    _set_numbers(surface, "base_weight", "float", shading.base)
    _connect(surface, "specular_roughness", graph, "roughness_out")
    _connect(surface, "specular_roughness_anisotropy", graph, "anisotropy_out")
    _set_numbers(surface, "specular_ior", "float", shading.ior)
    _connect(surface, "base_color", graph, "base_color_out")
    _connect(surface, "geometry_opacity", graph, "opacity_out")
    _connect(surface, "geometry_normal", graph, "normal_out")
    _connect(surface, "geometry_tangent", graph, "across_out")
    _add_material(document, name, surface)


def _add_standard_surface(document: Any, graph: Any, name: str, shading: StandardShading) -> None:
    surface = document.addNode("standard_surface", f"{name}_surface", "surfaceshader")
    _set_numbers(surface, "base", "float", shading.base)
    _set_numbers(surface, "specular_roughness", "float", shading.standard_roughness)
    _set_numbers(surface, "specular_anisotropy", "float", shading.standard_anisotropy)
    _set_numbers(surface, "specular_IOR", "float", shading.ior)
    _connect(surface, "base_color", graph, "base_color_out")
    _connect(surface, "opacity", graph, "opacity_color_out")
    _connect(surface, "normal", graph, "normal_out")
    _connect(surface, "tangent", graph, "across_out")
    _add_material(document, name, surface)


def _set_numbers(node: Any, name: str, kind: str, *numbers: float) -> None:
    # Given as numbers, MaterialX would write six digits only.
    text = ", ".join(f"{tidy(number):.9g}" for number in numbers)
    node.addInput(name, kind).setValueString(text)


def _connect(surface: Any, name: str, graph: Any, output: str) -> None:
    surface.addInput(name, graph.getOutput(output).getType()).setConnectedOutput(
        graph.getOutput(output)
    )


def _add_material(document: Any, name: str, surface: Any) -> None:
    material = document.addNode("surfacematerial", name, "material")
    material.setConnectedNode("surfaceshader", surface)
