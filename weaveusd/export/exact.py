"""The exact MaterialX document: the cloth by our own node, for renderers that learn it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import MaterialX as mx  # noqa: N813

from weaveusd.contract import CLOTH_SHADER_ID, MATERIALX_NODE_DIR, SHADER_YARN_ARRAYS
from weaveusd.export.attributes import tidy
from weaveusd.export.exact_distance import connect_moments
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.mtlx_nodes import (
    add_direction,
    add_image,
    add_maps,
    add_material,
    connect_node,
    new_document,
    set_numbers,
)
from weaveusd.export.network_mitsuba import optics_of
from weaveusd.stage import schema_dir

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles
    from weaveusd.shading.material import ClothMaterial

_CASES = 10
"""Inputs of the standard node `switch`."""


def write_exact(material: ClothMaterial, folder: Path, files: LookFiles = CLOTH_ITSELF) -> None:
    """Write the exact document of `material` into `folder`, with the node's definition.

    The node `weaveusd_cloth` takes the optics of one yarn. They come from the yarn id by
    standard `switch` nodes, which every target of MaterialX has and which lose no digit; an
    input that all yarns share is a plain value. Of a cloth from afar it takes the moment maps,
    with the optics of each kind of yarn. The document includes its node from
    `contract.MATERIALX_NODE_DIR`, and needs nothing installed: a renderer that looks for shader
    sources beside the document finds them.
    """
    definition = folder / MATERIALX_NODE_DIR
    definition.mkdir(exist_ok=True)
    for source in sorted((schema_dir() / "materialx").iterdir()):
        (definition / source.name).write_bytes(source.read_bytes())
    document = new_document()
    mx.prependXInclude(document, f"{MATERIALX_NODE_DIR}/{CLOTH_SHADER_ID}.mtlx")
    graph = document.addNodeGraph(f"{material.name}_textures")
    maps = add_maps(graph, material.weave.repeat_mm, files)
    fibre = add_direction(graph, "fibre", files.texture("tangent.png"), maps.repeats)
    texels = (material.textures.width, material.textures.height)
    nearest = _add_texel_centers(graph, maps.repeats, texels)
    ids = add_image(graph, "yarn_id_map", files.texture("yarn_id.png"), "float", nearest)
    ids.setInputValue("filtertype", "closest")
    cloth = document.addNode(CLOTH_SHADER_ID, f"{material.name}_cloth", "BSDF")
    surface = document.addNode("surface", f"{material.name}_surface", "surfaceshader")
    for node, name, source in (
        (cloth, "base_color", maps.color),
        (cloth, "normal", maps.normal),
        (cloth, "tangent", fibre),
        (surface, "opacity", maps.opacity),
    ):
        connect_node(node, name, graph, source)
    lookup = _Lookup(graph, ids)
    optics = optics_of(material)
    for name in SHADER_YARN_ARRAYS:
        values = [tidy(value) for value in optics[name]]
        if len(set(values)) == 1:
            set_numbers(cloth, name, "float", values[0])
        else:
            connect_node(cloth, name, graph, lookup.add(name, values))
    connect_moments(cloth, graph, maps.repeats, material, files)
    surface.setConnectedNode("bsdf", cloth)
    surface.setInputValue("thin_walled", True)
    add_material(document, material.name, surface)
    text = mx.writeToXmlString(document)
    (folder / files.exact).write_text(text, encoding="utf-8")


def _add_texel_centers(graph: Any, repeats: Any, texels: tuple[int, int]) -> Any:
    """Add the middle of the texel that `repeats` lie in.

    Renderers magnify every texture linearly, whatever filter the image asks for; a yarn id
    between two is that of a third yarn.
    """
    node = repeats
    for category, name, numbers in (
        ("multiply", "texels", texels),
        ("floor", "texel", None),
        ("add", "texel_center", (0.5, 0.5)),
        ("divide", "nearest", texels),
    ):
        following = graph.addNode(category, name, "vector2")
        following.setConnectedNode("in" if numbers is None else "in1", node)
        if numbers is not None:
            set_numbers(following, "in2", "vector2", *numbers)
        node = following
    return node


class _Lookup:
    """Adds tables from the yarn's index to a number, as trees of `switch` nodes.

    A switch takes its input k where k − 1 ≤ `which` < k. The index lies in the middle of that,
    half below a whole number, so that no rounding of the texture's 8 bits takes another yarn;
    gaps, which lie below, take the first.
    """

    def __init__(self, graph: Any, ids: Any) -> None:
        self._graph = graph
        scaled = graph.addNode("multiply", "yarn_id", "float")
        scaled.setConnectedNode("in1", ids)
        set_numbers(scaled, "in2", "float", 255)
        self._index = graph.addNode("subtract", "yarn_index", "float")
        self._index.setConnectedNode("in1", scaled)
        set_numbers(self._index, "in2", "float", 0.5)

    def add(self, name: str, values: Sequence[float]) -> Any:
        """Add the table of `values` and return its root, a node of type float."""
        level: list[Any] = list(values)
        span = 1
        while len(level) > 1:
            level = [
                self._switch(f"{name}_{span}_{first}", level[first : first + _CASES], span, first)
                for first in range(0, len(level), _CASES)
            ]
            span *= _CASES
        return level[0]

    def _switch(self, name: str, cases: list[Any], span: int, first: int) -> Any:
        if len(cases) == 1 or all(case == cases[0] for case in cases):
            return cases[0]
        node = self._graph.addNode("switch", name, "float")
        for number, case in enumerate(cases, 1):
            if isinstance(case, float):
                set_numbers(node, f"in{number}", "float", case)
            else:
                node.setConnectedNode(f"in{number}", case)
        node.setConnectedNode("which", self._which(span, first))
        return node

    def _which(self, span: int, first: int) -> Any:
        """Return the node that counts groups of `span` yarns from group `first` on."""
        if (span, first) == (1, 0):
            return self._index
        name = f"yarn_group_{span}_{first}"
        if found := self._graph.getNode(name):
            return found
        grouped = self._graph.addNode("divide", f"{name}_of", "float")
        grouped.setConnectedNode("in1", self._index)
        set_numbers(grouped, "in2", "float", span)
        node = self._graph.addNode("subtract", name, "float")
        node.setConnectedNode("in1", grouped)
        set_numbers(node, "in2", "float", first)
        return node
