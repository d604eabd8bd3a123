"""The texels that a cloth needs at a distance."""

from __future__ import annotations

import pytest

from weaveusd import pipeline
from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif
from weaveusd.errors import InputError
from weaveusd.patch import PIXEL, TEXELS_PER_CROSSING, Patch
from weaveusd.yarn.recipe import read_preset

RECIPE = read_preset("linen")


def texels_per_mm(distance_m: float) -> float:
    budget = Patch(distance_m=distance_m).budget(RECIPE)
    assert budget is not None
    return float(budget["texels_per_mm"])


def test_near_cloth_gets_a_texel_for_every_pixel() -> None:
    assert texels_per_mm(0.05) == pytest.approx(1 / (50 * PIXEL), rel=1e-3)
    assert texels_per_mm(0.1) == pytest.approx(texels_per_mm(0.05) / 2, rel=1e-3)


def test_however_far_the_cloth_every_crossing_keeps_its_texels() -> None:
    fewest = TEXELS_PER_CROSSING * max(RECIPE.ends_per_cm, RECIPE.picks_per_cm) / 10
    assert texels_per_mm(3) == texels_per_mm(300) == pytest.approx(fewest, rel=1e-4)
    draft = make_draft("plain")
    _, resolution = Patch(distance_m=3).cut(draft, RECIPE)
    assert resolution >= TEXELS_PER_CROSSING * max(draft.ends, draft.picks)


def test_a_distance_stands_in_place_of_a_resolution() -> None:
    with pytest.raises(InputError, match="one of them"):
        Patch(resolution=64, distance_m=3.0)
    with pytest.raises(InputError, match="distance in m: found 0, expected"):
        Patch(distance_m=0.0)


def test_a_cloth_for_a_distance_is_small_and_says_why(tmp_path) -> None:
    draft = tmp_path / "twill.wif"
    draft.write_bytes(write_wif(make_draft("twill:2/2")))
    far = pipeline.publish(draft, preset="linen", root=tmp_path / "root", distance_m=3.0)
    whole = pipeline.publish(draft, preset="linen", root=tmp_path / "all", resolution=256)
    sizes = [sum(f.bytes for f in done.asset.files) for done in (far, whole)]
    assert sizes[0] < sizes[1]
    assert "keep the look" in far.as_dict()["budget"]["why"]
    assert "budget" not in whole.as_dict()
