"""Documents with one node `weaveusd_cloth`, its library beside them, and moments to give to it."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import MaterialX as mx  # noqa: N813
import numpy as np

from tests.weaves import woven
from weaveusd.shading.normalization import normalization
from weaveusd.stage import schema_dir
from weaveusd.synth.moments import Footprint, moment_maps
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.model import Optics

LIBRARY = schema_dir() / "materialx"
FAR, GROWING = "far", "growing"
SIZE = 64
"""Pixels of the pictures for which `GROWING` is meant, either way."""


def new_document() -> tuple[mx.Document, mx.Node]:
    """Return a document and its node `weaveusd_cloth`, which does not keep it alive."""
    made = mx.createDocument()
    made.setColorSpace("lin_rec709")
    return made, made.addNode("weaveusd_cloth", "cloth", "BSDF")


def write_document(made: mx.Document, folder: Path) -> Path:
    """Write `made` with a material "material" of its cloth, and the library, into `folder`."""
    shutil.copytree(LIBRARY, folder / "materialx")
    surface = made.addNode("surface", "surface", "surfaceshader")
    surface.setConnectedNode("bsdf", made.getNode("cloth"))
    made.addNode("surfacematerial", "material", "material").setConnectedNode(
        "surfaceshader", surface
    )
    mx.prependXInclude(made, "materialx/weaveusd_cloth.mtlx")
    path = folder / "document.mtlx"
    path.write_text(mx.writeToXmlString(made))
    return path


def write_systems(
    systems: Sequence[Footprint],
    folder: Path,
    *,
    footprint: str = FAR,
    side: int = 1,
    instead: Mapping[str, Sequence[float]] = MappingProxyType({}),
) -> Path:
    """Write a document with a node that has the moments of `systems`, and its library beside it.

    The footprint is `FAR` above a texel, or `GROWING` from left to right and upwards: the
    coordinates in texels are then 1.6 SIZE st². A `side` of −1 turns the back of the cloth to +z.
    Inputs named in `instead` have the numbers there.
    """
    folder.mkdir()
    made, node = new_document()
    st = made.addNode("texcoord", "st", "vector2")
    scaled = made.addNode("multiply", "texels", "vector2")
    scaled.setConnectedNode("in1", st)
    put(scaled, "in2", "float", [1.6 * SIZE if footprint == GROWING else 1e4])
    if footprint == GROWING:
        squared = made.addNode("multiply", "squared", "vector2")
        squared.setConnectedNode("in1", st)
        squared.setConnectedNode("in2", st)
        scaled.setConnectedNode("in1", squared)
    node.setConnectedNode("moment_texels", scaled)
    # A value would not do: MaterialX takes the surface's normal unless something is connected.
    outwards = made.addNode("constant", "outwards", "vector3")
    put(outwards, "value", "vector3", (0, 0, side))
    node.setConnectedNode("surface_normal", outwards)
    for one in systems:
        name = "weft" if one.weft else "warp"
        put(node, f"{name}_slopes", "vector4", one.moments[:4])
        put(node, f"{name}_along", "vector4", one.moments[4:8])
        put(node, f"{name}_across", "vector4", one.moments[8:])
        put(node, f"{name}_albedo", "color4", (*one.albedo, covered(one)))
        put(node, f"{name}_kinds", "vector4", [*one.share, 0, 0, 0][:4])
        put(node, f"{name}_section", "vector2", (one.section.flatness, one.section.curvature))
        rows = (list(one.kinds) * 4)[:4]
        fibres = [x for o in rows for x in (o.eta, o.k_d, o.k_s, o.tau)]
        put(node, f"{name}_fibres", "matrix44", fibres)
        lobes = [x for o in rows for x in (o.gamma_s, o.gamma_v, n_v(o), 0)]
        put(node, f"{name}_lobes", "matrix44", lobes)
    for name, numbers in instead.items():
        node.removeInput(name)
        kind = "color4" if name.endswith("albedo") else f"vector{len(numbers)}"
        put(node, name, kind, numbers)
    return write_document(made, folder)


def put(node: mx.Node, name: str, kind: str, numbers: Sequence[float]) -> None:
    text = ", ".join(f"{float(x):.9g}" for x in numbers)
    node.addInput(name, kind).setValueString(text)


def n_v(optics: Optics) -> float:
    o = optics
    return normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v)


def covered(footprint: Footprint) -> float:
    return float(footprint.moments[:3].sum())


def tile(warp_up: np.ndarray, preset: str, size: int = 1) -> list[Footprint]:
    """Return the footprint of the tile of a cloth, or the first texel of maps of `size`² texels.

    Numbers have the six decimals that MaterialX writes of a constant.
    """
    weave = woven(warp_up, preset)
    textures = synthesize(weave, resolution=64)
    maps = moment_maps(weave, textures, width=size, height=size)
    found = [one.footprint(0, 0) for one in maps]
    return [
        replace(one, moments=np.round(one.moments, 6), albedo=np.round(one.albedo, 6))
        for one in found
    ]
