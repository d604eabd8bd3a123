"""Cloth from afar in the node `weaveusd_cloth`: it is the reference's, and near goes over to it."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import MaterialX as mx  # noqa: N813
import numpy as np
import pytest

from tests.export.glsl import Job, render, view
from tests.weaves import plain, satin, twill, woven
from weaveusd.shading.distance import LEAN, evaluate
from weaveusd.shading.normalization import normalization
from weaveusd.stage import schema_dir
from weaveusd.synth.moments import Footprint, moment_maps
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.model import Optics
from weaveusd.yarn.recipe import read_preset

EYE, SIZE = 0.5, 64
LIGHTS = [
    np.array(light) / np.linalg.norm(light)
    for light in [(0, 0.1, 1), (0.5, 0.3, 0.8), (-0.9, 0.1, 0.15), (0.1, -0.95, 0.2)]
]
FAR = 1e4
"""Texels of the moment maps in one unit of st, for a square that shows one unit."""


def write(systems: Sequence[Footprint], folder: Path, texels: float = FAR) -> Path:
    """Write a document with a node that has the moments of `systems`, and its library beside it."""
    folder.mkdir()
    shutil.copytree(schema_dir() / "materialx", folder / "materialx")
    made = mx.createDocument()
    made.setColorSpace("lin_rec709")
    node = made.addNode("weaveusd_cloth", "cloth", "BSDF")
    st = made.addNode("texcoord", "st", "vector2")
    scaled = made.addNode("multiply", "texels", "vector2")
    scaled.setConnectedNode("in1", st)
    put(scaled, "in2", "float", [texels])
    node.setConnectedNode("moment_texels", scaled)
    for footprint in systems:
        name = "weft" if footprint.weft else "warp"
        put(node, f"{name}_slopes", "vector4", footprint.moments[:4])
        put(node, f"{name}_along", "vector4", footprint.moments[4:8])
        put(node, f"{name}_across", "vector4", footprint.moments[8:])
        put(node, f"{name}_albedo", "color4", (*footprint.albedo, covered(footprint)))
        put(node, f"{name}_kinds", "vector4", [*footprint.share, 0, 0, 0][:4])
        section = footprint.section
        put(node, f"{name}_section", "vector2", (section.flatness, section.curvature))
        rows = (list(footprint.kinds) * 4)[:4]
        fibres = [x for o in rows for x in (o.eta, o.k_d, o.k_s, o.tau)]
        put(node, f"{name}_fibres", "matrix44", fibres)
        lobes = [x for o in rows for x in (o.gamma_s, o.gamma_v, n_v(o), 0)]
        put(node, f"{name}_lobes", "matrix44", lobes)
    surface = made.addNode("surface", "surface", "surfaceshader")
    surface.setConnectedNode("bsdf", node)
    made.addNode("surfacematerial", "material", "material").setConnectedNode(
        "surfaceshader", surface
    )
    mx.prependXInclude(made, "materialx/weaveusd_cloth.mtlx")
    path = folder / "document.mtlx"
    path.write_text(mx.writeToXmlString(made))
    return path


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


def of_kinds(systems: Sequence[Footprint], *presets: str) -> list[Footprint]:
    """Return `systems` as if their yarns were of the first yarns of `presets`, unlike in share."""
    kinds = tuple(read_preset(preset).yarns[0].optics for preset in presets)
    shares = np.arange(1, len(kinds) + 1) / np.arange(1, len(kinds) + 1).sum()
    return [replace(one, kinds=kinds, share=covered(one) * shares) for one in systems]


def from_afar(systems: Sequence[Footprint], wi: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Return the reference for a footprint full of yarn: gaps are the surface's opacity."""
    flat = wi.reshape(-1, 3)
    value = evaluate(flat, np.broadcast_to(light, flat.shape), systems, LEAN)
    return value.reshape(wi.shape) / sum(map(covered, systems))


def check(systems: Sequence[Footprint], lights: Sequence[np.ndarray], folder: Path) -> None:
    document = write(systems, folder / "node")
    jobs = [
        Job(str(document), "material", str(folder / f"{i}.npy"), tuple(light), EYE, SIZE)
        for i, light in enumerate(lights)
    ]
    for job, light, picture in zip(jobs, lights, render(jobs, folder), strict=True):
        reference = from_afar(systems, view(job), light)
        error = np.abs(picture - reference) / reference.max()
        assert reference.max() > 0
        assert error.mean() < 1e-5
        assert error.max() < 1e-4


def test_a_tile_from_afar_is_that_of_the_reference(tmp_path):
    check(tile(plain(), "shot_silk"), LIGHTS[1:2], tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    "systems",
    [
        lambda: tile(plain(), "polyester"),
        lambda: tile(twill(), "canvas"),
        lambda: tile(plain(), "chiffon"),
        lambda: tile(satin(), "silk", 7),
        lambda: of_kinds(tile(twill(), "linen"), "polyester", "linen", "silk"),
    ],
    ids=["polyester", "canvas", "chiffon", "part of a satin", "kinds"],
)
def test_every_cloth_from_afar_is_that_of_the_reference(tmp_path, systems):
    check(systems(), LIGHTS, tmp_path)
