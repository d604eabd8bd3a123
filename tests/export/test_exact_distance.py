"""Cloth from afar in the node `weaveusd_cloth`: it is the reference's, and near goes over to it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import MaterialX as mx  # noqa: N813
import numpy as np
import pytest

from tests.export.cloths import cloth, plain_weave, yarn
from tests.export.glsl import Job, render, view
from tests.export.node_documents import GROWING, SIZE, covered, tile, write_systems
from tests.weaves import plain, satin, twill, woven
from weaveusd.contract import EXACT_FILE
from weaveusd.export.asset import write_asset
from weaveusd.export.exact import write_exact
from weaveusd.shading.distance import LEAN, evaluate
from weaveusd.shading.material import ClothMaterial
from weaveusd.shading.shade import shade
from weaveusd.synth.moments import Footprint
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import read_preset

EYE = 0.5
LIGHTS = [
    np.array(light) / np.linalg.norm(light)
    for light in [(0, 0.1, 1), (0.5, 0.3, 0.8), (-0.9, 0.1, 0.15), (0.1, -0.95, 0.2)]
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


def check(
    systems: Sequence[Footprint], lights: Sequence[np.ndarray], folder: Path, side: int = 1
) -> None:
    """Hold pictures of the face (1) or the back (−1) of a footprint to the reference."""
    document = write_systems(systems, folder / "node", side=side)
    jobs = [
        Job(str(document), "material", str(folder / f"{i}.npy"), tuple(light), EYE, SIZE)
        for i, light in enumerate(lights)
    ]
    for job, light, picture in zip(jobs, lights, render(jobs, folder), strict=True):
        reference = from_afar(systems, view(job) * (1, 1, side), light * (1, 1, side))
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


@pytest.mark.slow
@pytest.mark.parametrize("side", [1, -1])
def test_light_passes_from_either_side_as_in_the_reference(tmp_path, side):
    through = np.array([0.1, 0.3, -0.9]) / np.linalg.norm([0.1, 0.3, -0.9])
    check(tile(plain(), "chiffon"), [through, LIGHTS[1]], tmp_path, side)


def test_near_is_the_yarn_alone_and_goes_over_into_far_without_a_step(tmp_path):
    systems = tile(twill(), "linen")
    documents = {
        "near": write_systems([], tmp_path / "near", footprint=GROWING),
        "far": write_systems(systems, tmp_path / "far"),
        "growing": write_systems(systems, tmp_path / "growing", footprint=GROWING),
    }
    jobs = [
        Job(str(path), "material", str(tmp_path / f"{name}.npy"), tuple(LIGHTS[1]), EYE, SIZE)
        for name, path in documents.items()
    ]
    near, far, growing = render(jobs, tmp_path)
    # What coordinates change by between the pixels of a quad.
    at = (np.arange(SIZE) + 0.5) / SIZE
    change = np.repeat(np.diff((1.6 * SIZE * at**2).reshape(-1, 2)), 2)
    footprint = np.maximum(change[:, None], change)
    farness = np.clip(1 + np.log2(footprint), 0, 1)[..., None]
    assert {0.0, 1.0} < set(farness.ravel().tolist())
    np.testing.assert_array_equal(growing[footprint < 0.5], near[footprint < 0.5])
    expected = near * (1 - farness) + far * farness
    np.testing.assert_allclose(growing, expected, atol=1e-5 * expected.max())


def of_two_warps() -> ClothMaterial:
    """Return a cloth whose ends are of two kinds in turn."""
    warp, weft = yarn("warp", "warp"), yarn("weft", "weft")
    shiny = replace(warp, name="shiny", optics=replace(warp.optics, gamma_s=0.05))
    made = replace(plain_weave(), yarns=(warp, weft, shiny), warp_yarn=np.array([0, 2], np.int32))
    measured = (*cloth().measured, cloth().measured[0])
    return replace(cloth(), weave=made, normalization=(1.5, 1.6, 1.7), measured=measured)


def test_the_document_hands_the_node_its_maps_and_what_the_kinds_are_like(tmp_path):
    material = of_two_warps()
    write_exact(material, tmp_path)
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(tmp_path / EXACT_FILE))
    node = document.getNode("plain_cloth")

    def file(name: str) -> str:
        image = node.getInput(name).getConnectedNode()
        assert image.getCategory() == "image"
        return image.getInput("file").getValueString()

    for system, names in (("warp", "slopes along across albedo kinds"),
                          ("weft", "slopes along across albedo")):  # fmt: skip
        for name in names.split():
            assert file(f"{system}_{name}") == f"textures/{system}_{name}.exr"
    # Plain weave of one kind each: the weft has no map of kinds.
    assert node.getInput("weft_kinds") is None
    lobes = np.array(node.getInput("warp_lobes").getValueString().split(", "), float).reshape(4, 4)
    np.testing.assert_allclose(lobes[:2], [[0.21, 0.42, 1.5, 0], [0.05, 0.42, 1.7, 0]], rtol=1e-6)
    texels = node.getInput("moment_texels").getConnectedNode()
    np.testing.assert_allclose(texels.getInput("in2").getValue().asTuple(), (8, 8))


def test_albedo_is_in_the_color_space_of_the_cloth_and_moments_are_data(tmp_path):
    material = cloth()
    material = replace(material, weave=replace(material.weave, color_space="acescg"))
    write_exact(material, tmp_path)
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(tmp_path / EXACT_FILE))
    graph = document.getNodeGraph("plain_textures")
    assert graph.getNode("weft_albedo_map").getInput("file").getColorSpace() == "acescg"
    assert graph.getNode("weft_slopes_map").getType() == "vector4"


def seen(asset: Path, repeats: float, size: int, name: str, **settings) -> Job:
    """Return a picture of so many repeats of the cloth, from far above."""
    width, height = woven(twill(), "polyester").repeat_mm
    return Job(
        str(asset / f"{name}.mtlx"), "plain", str(asset / f"{name} {repeats} {size}.npy"),
        (0.3, 0.2, 0.93), eye=20.0, size=size,
        st=(repeats * width / 1000, repeats * height / 1000), **settings,
    )  # fmt: skip


@pytest.fixture(scope="module")
def glossy(tmp_path_factory) -> Path:
    """Return the asset of a glossy twill: ``exact.mtlx``, and ``yarns.mtlx`` without its maps."""
    folder = tmp_path_factory.mktemp("asset")
    weave = woven(twill(), "polyester")
    textures = synthesize(weave, resolution=128)  # a texel a pixel, where a picture shows a repeat
    write_asset(shade("plain", weave, textures, cloth().provenance), folder, also=["exact"], jobs=1)
    text = (folder / EXACT_FILE).read_text()
    yarns = re.sub(r'<input name="moment_texels"[^>]*/>', "", text)
    (folder / "yarns.mtlx").write_text(yarns)
    return folder


def off(picture: np.ndarray, truth: np.ndarray) -> float:
    """Return the sum of the absolute differences, relative."""
    return float(np.abs(picture - truth).sum() / truth.sum())


@pytest.mark.slow
def test_a_sheet_far_away_has_the_light_of_its_tile(glossy):
    tile, far, yarns = render(
        [
            seen(glossy, 1, 128, "exact"),
            seen(glossy, 60, 64, "exact"),
            seen(glossy, 60, 64, "yarns"),
        ],
        glossy,
    )
    light = tile.mean((0, 1))
    np.testing.assert_allclose(far.mean((0, 1)), light, rtol=0.03)
    assert np.abs(yarns.mean((0, 1)) / light - 1).max() > 0.2


def blocks(picture: np.ndarray, count: int) -> np.ndarray:
    """Return the means of `count`² equal blocks."""
    size = len(picture) // count
    return picture.reshape(count, size, count, size, 3).mean((1, 3))


@pytest.mark.slow
def test_pixels_of_a_yarn_or_two_have_the_light_of_their_neighborhood_and_no_moire(glossy):
    many, far, yarns = render(
        [
            seen(glossy, 11, 1024, "yarns"),
            seen(glossy, 11, 32, "exact"),
            seen(glossy, 11, 32, "yarns"),
        ],
        glossy,
    )
    # A yarn and a third lie in a pixel. Moiré is in waves longer than that: over four pixels, what
    # a trilinear filter blurs more than a box is gone, and moiré is not.
    truth = blocks(many, 8)
    assert off(blocks(far, 8), truth) < 0.05
    assert off(blocks(yarns, 8), truth) > 0.2


@pytest.mark.slow
def test_a_sheet_far_away_under_an_even_sky_has_the_light_of_its_tile(glossy):
    tile, far = render(
        [
            seen(glossy, 1, 128, "exact", environment=True),
            seen(glossy, 60, 64, "exact", environment=True),
        ],
        glossy,
    )
    np.testing.assert_allclose(far.mean((0, 1)), tile.mean((0, 1)), atol=0.03)
