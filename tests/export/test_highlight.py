"""Every renderer shows the highlight across the fibres, and the cloth the right way up."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from tests.export.cloths import cloth, texture_set
from tests.export.renderers import DIRECTED, RENDERERS, picture
from weaveusd.draft.model import Draft
from weaveusd.draft.write import write_wif
from weaveusd.export.asset import write_asset
from weaveusd.pipeline import publish
from weaveusd.shading.material import StandardFit
from weaveusd.stage import open_stage
from weaveusd.synth.model import Band
from weaveusd.validate.run import validate
from weaveusd.yarn.model import Optics


def by_speed(names: tuple[str, ...]) -> list[object]:
    """Return the renderers as parameters: one is fast, the others are slow."""
    fast = "glsl exact"
    return [n if n == fast else pytest.param(n, marks=pytest.mark.slow) for n in names]


def flat_cloth(fibre: tuple[float, float, float], folder: Path) -> Path:
    """Write a black cloth of straight fibres, smooth along them, and return its entry layer."""
    values = {
        "base_color": (0.0, 0.0, 0.0),
        "normal": (0.0, 0.0, 1.0),
        "tangent": fibre,
        "height": (0.0,),
        "opacity": (1.0,),
        "yarn_id": (0.0,),
        "system": (0.0,),
        "fibre_angle": (fibre[0] ** 2 - fibre[1] ** 2, 2 * fibre[0] * fibre[1]),
        "ambient_occlusion": (1.0,),
    }

    def band(first: int, last: int) -> Band:
        shape = (last - first, 32)
        return {
            name: np.broadcast_to(np.array(v, np.float32), (*shape, len(v))).copy()
            for name, v in values.items()
        }

    material, fit = cloth(), StandardFit(alpha_along=0.05, alpha_across=0.4, f0=0.3)
    optics = Optics(eta=1.54, k_d=0.1, k_s=1.0, gamma_s=0.05, gamma_v=0.1, tau=0.0)
    yarns = tuple(replace(yarn, optics=optics) for yarn in material.weave.yarns)
    isotropic = StandardFit(0.15, 0.15, 0.3)
    return write_asset(
        replace(
            material,
            weave=replace(material.weave, yarns=yarns),
            textures=replace(texture_set(), band=band),
            fits=replace(material.fits, together=fit, yarns=(fit, fit), isotropic=isotropic),
        ),
        folder,
        also=["exact"],
    )


def stretch(image: np.ndarray) -> float:
    """Return how much lighter the picture is left and right of its middle than above and below."""
    middle, edge = len(image) // 2, 4
    sides = image[middle, [edge, -edge - 1], 0]
    ends = image[[edge, -edge - 1], middle, 0]
    return float(sides.mean() / ends.mean())


def clearly(renderer: str) -> float:
    """Return the stretch to expect; three.js widens OpenPBR's highlight along the fibre too."""
    return 1.8 if renderer.startswith("three") else 10


@pytest.mark.parametrize("renderer", by_speed(DIRECTED))
def test_the_highlight_of_a_warp_lies_across_it(tmp_path, renderer):
    (tmp_path / "asset").mkdir()
    entry = flat_cloth((0.0, 1.0, 0.0), tmp_path / "asset")
    assert stretch(picture(renderer, entry, (1.0, 1.0), tmp_path)) > clearly(renderer)


@pytest.mark.slow
@pytest.mark.parametrize("renderer", [n for n in DIRECTED if not n.startswith("three")])
def test_the_highlight_of_a_weft_lies_across_it(tmp_path, renderer):
    """three.js reads no tangent: its highlight lies as that of a warp."""
    (tmp_path / "asset").mkdir()
    entry = flat_cloth((1.0, 0.0, 0.0), tmp_path / "asset")
    assert 1 / stretch(picture(renderer, entry, (1.0, 1.0), tmp_path)) > clearly(renderer)


@pytest.mark.slow
def test_the_highlight_of_the_preview_is_round(tmp_path):
    (tmp_path / "asset").mkdir()
    entry = flat_cloth((0.0, 1.0, 0.0), tmp_path / "asset")
    image = picture("mitsuba preview", entry, (1.0, 1.0), tmp_path)
    assert stretch(image) == pytest.approx(1, abs=0.1)


COLORS = {"red": (0.5, 0.02, 0.02), "green": (0.02, 0.5, 0.02), "blue": (0.02, 0.02, 0.5),
          "gray": (0.45, 0.45, 0.45)}  # fmt: skip
WARP, WEFT = ("red", "green"), ("blue", "gray")
"""Ends from left to right, picks from below."""


def quadrant_draft() -> Draft:
    """Return a draft with red, then green ends, and blue, then gray picks, in four blocks."""
    row, column = np.mgrid[0:16, 0:16]
    float_of_seven = (row + 3 * column) % 8 > 0
    upper, right = row >= 8, column >= 8
    warp_up = np.where(upper == right, float_of_seven, ~float_of_seven)
    return Draft(
        threading=np.eye(16, dtype=bool),
        liftplan=warp_up,
        warp_color=np.repeat([0, 1], 8),
        weft_color=np.repeat([2, 3], 8),
        palette=np.array(list(COLORS.values())) ** (1 / 2.2),
        title="Quadrants",
    )


@pytest.fixture(scope="module")
def quadrants(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("quadrants")
    draft = folder / "quadrants.wif"
    draft.write_bytes(write_wif(quadrant_draft()))
    done = publish(draft, root=folder, preset="cotton", resolution=128, exact=True, glslfx=True)
    return done.asset.entry


def repeat_of(entry: Path) -> tuple[float, float]:
    """Return the size of the repeat in metres."""
    stage = open_stage(entry)
    prim = stage.GetDefaultPrim().GetChild("Material")
    width, height = (prim.GetAttribute(f"weave:repeat{side}").Get() for side in ("Width", "Height"))
    return width / 1000, height / 1000


def threads(shown: np.ndarray) -> tuple[str, str, bool]:
    """Return the warp and the weft whose colors mix to `shown` best, and whether warp is on top."""
    found = []
    for warp, weft in product(WARP, WEFT):
        mixed = np.array([COLORS[warp], COLORS[weft]]).T
        shares, residual = np.linalg.lstsq(mixed, shown.astype(float))[:2]
        found.append((float(residual[0]), warp, weft, bool(shares[0] > shares[1])))
    return min(found)[1:]


@pytest.mark.parametrize("renderer", by_speed(RENDERERS))
def test_a_cloth_of_four_colors_is_the_right_way_up(quadrants, tmp_path, renderer):
    image = picture(renderer, quadrants, repeat_of(quadrants), tmp_path)
    half = len(image) // 2
    for upper, right in product((0, 1), (0, 1)):
        rows, columns = (slice(i * half + 8, (i + 1) * half - 8) for i in (upper, right))
        shown = image[rows, columns].mean((0, 1))
        assert threads(shown) == (WARP[right], WEFT[upper], upper == right), (upper, right, shown)


def test_a_cloth_with_every_network_passes_its_checks(quadrants):
    report = validate(quadrants)
    assert report.passed, [f.message for f in report.findings if f.status > 1]


@pytest.mark.slow
def test_the_exact_document_shows_what_mitsuba_shows(quadrants, tmp_path):
    """By its 8-bit textures, and each at its own points of a pixel."""
    st = repeat_of(quadrants)
    mitsuba = picture("mitsuba exact", quadrants, st, tmp_path)
    glsl = picture("glsl exact", quadrants, st, tmp_path)
    assert glsl.mean() == pytest.approx(mitsuba.mean(), rel=0.02)
    assert np.abs(glsl - mitsuba).sum() < 0.2 * mitsuba.sum()
