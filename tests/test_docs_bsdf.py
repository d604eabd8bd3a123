"""docs/bsdf.md: its example runs, its pictures are there, its presets are counted."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import weaveusd
from weaveusd.errors import StageError
from weaveusd.proof.check import ANGLES
from weaveusd.proof.subjects import subjects

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "bsdf.md"


@pytest.fixture
def mi(renderer):
    import mitsuba

    return mitsuba


def test_the_example_of_a_scene_runs(mi, tmp_path, monkeypatch):
    weaveusd.publish(
        ROOT / "examples" / "drafts" / "twill_2_2.wif", preset="linen", resolution=64,
        root=tmp_path / "assets",
    )  # fmt: skip
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(re.search(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)[1], names)
    image = np.array(names["image"])
    assert image.shape == (64, 64, 3)
    assert 0.05 < image[24:40, 24:40].mean() < 1


def test_a_stage_without_a_cloth_is_no_cloth(mi):
    from weaveusd.render.published import published_bsdf

    with pytest.raises(StageError, match="holds no weaveusd_cloth shader"):
        published_bsdf(ROOT / "examples" / "stages" / "sky_sphere.usda")


def test_every_picture_is_there():
    for picture in re.findall(r"\]\((figures/[^)]+)\)", PAGE.read_text()):
        assert (PAGE.parent / picture).is_file(), picture


def test_the_page_counts_the_ways_to_scatter():
    found = subjects()
    text = PAGE.read_text()
    assert f"among the presets ({len(found)})" in text
    assert f"worst of {len(found) * len(ANGLES)}" in text
