"""What MaterialX documents of a cloth have in common: the document, its maps, its inputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import MaterialX as mx  # noqa: N813

from weaveusd.export.attributes import tidy
from weaveusd.export.network_openpbr import MATERIALX_VERSION

if TYPE_CHECKING:
    from collections.abc import Sequence

    from weaveusd.export.files import LookFiles
    from weaveusd.export.lobe_nodes import Node


@dataclass(frozen=True, slots=True)
class Maps:
    """Nodes of a graph that read the textures: directions of the world, linear colors.

    `repeats` are the texture coordinates in repeats of the cloth.
    """

    color: Any
    opacity: Any
    normal: Any
    repeats: Any


def new_document() -> Any:
    """Return an empty document in linear Rec.709."""
    document = mx.createDocument()
    document.setVersionString(MATERIALX_VERSION)
    # Without a space of its own a document leaves sRGB textures undecoded, silently.
    document.setColorSpace("lin_rec709")
    return document


def add_maps(graph: Any, repeat_mm: tuple[float, float], files: LookFiles) -> Maps:
    """Add the nodes that every cloth reads to `graph`.

    The node ``repeats`` multiplies the texture coordinates, in metres, by the repeats in one
    metre.
    """
    coordinates = graph.addNode("texcoord", "coordinates", "vector2")
    repeats = graph.addNode("multiply", "repeats", "vector2")
    repeats.setConnectedNode("in1", coordinates)
    set_numbers(repeats, "in2", "vector2", *(1000 / length for length in repeat_mm))
    color = add_image(graph, "base_color_map", files.texture("base_color.png"), "color3", repeats)
    color.getInput("file").setColorSpace("srgb_texture")
    return Maps(
        color,
        add_image(graph, "opacity_map", files.texture("opacity.png"), "float", repeats),
        add_direction(graph, "normal", files.texture("normal.png"), repeats),
        repeats,
    )


def add_nodes(graph: Any, nodes: Sequence[Node]) -> Any:
    """Add `nodes` in their order to `graph`, and return the last."""
    for node in nodes:
        added = graph.addNode(node.category, node.name, node.output)
        for key, (kind, value) in node.inputs.items():
            if kind == "string":
                added.setInputValue(key, value, kind)
            elif isinstance(value, str):
                added.addInput(key, kind).setConnectedNode(graph.getNode(value))
            else:
                set_numbers(added, key, kind, value)
    return added


def add_image(graph: Any, name: str, file: str, kind: str, repeats: Any) -> Any:
    """Add an image that repeats; `file` is below the document's folder."""
    image = graph.addNode("image", name, kind)
    image.setInputValue("file", file, "filename")
    image.setConnectedNode("texcoord", repeats)
    image.setInputValue("uaddressmode", "periodic")
    image.setInputValue("vaddressmode", "periodic")
    return image


def add_output(graph: Any, name: str, node: Any) -> None:
    """Let `graph` give what `node` gives under `name`."""
    graph.addOutput(name, node.getType()).setConnectedNode(node)


def set_numbers(node: Any, name: str, kind: str, *numbers: float) -> None:
    """Give the input `name` of `node` a value of type `kind`, to nine significant digits."""
    # Given as numbers, MaterialX would write six digits only.
    text = ", ".join(f"{tidy(number):.9g}" for number in numbers)
    node.addInput(name, kind).setValueString(text)


def connect_output(node: Any, name: str, graph: Any, output: str) -> None:
    """Let the input `name` of `node` take the output of `graph`."""
    found = graph.getOutput(output)
    node.addInput(name, found.getType()).setConnectedOutput(found)


def connect_node(node: Any, name: str, graph: Any, source: Any) -> None:
    """Let the input `name` of `node` take what `source` gives, through an output of `graph`."""
    add_output(graph, f"{name}_out", source)
    connect_output(node, name, graph, f"{name}_out")


def add_material(document: Any, name: str, surface: Any) -> None:
    """Add the material `name` with `surface`."""
    material = document.addNode("surfacematerial", name, "material")
    material.setConnectedNode("surfaceshader", surface)


def add_direction(graph: Any, name: str, file: str, repeats: Any) -> Any:
    """Add the nodes that turn a direction of the cloth frame into one of the world."""
    encoded = add_image(graph, f"{name}_map", file, "vector3", repeats)
    node = graph.addNode("normalmap", name, "vector3")
    node.setConnectedNode("in", encoded)
    return node
