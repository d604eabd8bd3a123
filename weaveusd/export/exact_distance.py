"""The moment maps for the node `weaveusd_cloth`: what it shows of a cloth from afar."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from weaveusd.contract import MAX_KINDS, section_input
from weaveusd.export.moments import system_maps
from weaveusd.export.mtlx_nodes import add_image, connect_node, set_numbers
from weaveusd.export.network_mitsuba import optics_of
from weaveusd.synth.moments import map_size

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles
    from weaveusd.export.moments import SystemMaps
    from weaveusd.shading.material import ClothMaterial

FIBRES = ("eta", "k_d", "k_s", "tau")
LOBES = ("gamma_s", "gamma_v", "normalization")
"""Optics of a kind, in the order of the rows of the node's inputs ``…_fibres`` and ``…_lobes``."""


def connect_moments(
    cloth: Any, graph: Any, repeats: Any, material: ClothMaterial, files: LookFiles
) -> None:
    """Give the node `cloth` the moment maps of `material`, read by images in `graph`.

    `repeats` is the node of the texture coordinates in repeats. From them the node also has the
    coordinates in texels of the maps, whose change from pixel to pixel is its footprint.
    """
    textures = material.textures
    width, height = map_size(material.weave, (textures.width, textures.height))
    texels = graph.addNode("multiply", "moment_texels", "vector2")
    texels.setConnectedNode("in1", repeats)
    set_numbers(texels, "in2", "vector2", width, height)
    connect_node(cloth, "moment_texels", graph, texels)
    for maps in system_maps(material.weave):
        for name, file in zip(maps.names, maps.files, strict=True):
            put = f"{maps.system}_{name}"
            kind = "color4" if name == "albedo" else "vector4"
            image = add_image(graph, f"{put}_map", files.texture(file), kind, repeats)
            if kind == "color4":
                image.getInput("file").setColorSpace(material.color_space)
            connect_node(cloth, put, graph, image)
        section = (maps.flatness, maps.curvature)
        set_numbers(cloth, section_input(maps.system), "vector2", *section)
        for put, names in (("fibres", FIBRES), ("lobes", LOBES)):
            numbers = [number for row in _kind_rows(material, maps, names) for number in row]
            set_numbers(cloth, f"{maps.system}_{put}", "matrix44", *numbers)


def _kind_rows(
    material: ClothMaterial, maps: SystemMaps, names: tuple[str, ...]
) -> list[tuple[float, ...]]:
    """Return `contract.MAX_KINDS` rows of four: the optics `names` of each kind, then zeros.

    Rows that no kind has are those of the first.
    """
    optics = optics_of(material)
    kinds = [*maps.kinds, *[maps.kinds[0]] * MAX_KINDS][:MAX_KINDS]
    rest = (0.0,) * (4 - len(names))
    return [tuple(optics[name][yarn - 1] for name in names) + rest for yarn in kinds]
