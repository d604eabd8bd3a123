"""Uneven and mixed yarns are read strictly and keep the mean of their colors."""

from __future__ import annotations

import numpy as np
import pytest

from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.errors import RecipeError
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.color import linear_from_srgb, srgb_from_hex
from weaveusd.yarn.irregularity import REGULAR
from weaveusd.yarn.recipe import read_recipe

RECIPE = """\
name = "test"
title = "Test"
source = "invented"
sett = { ends_per_cm = 20, picks_per_cm = 18 }

[[yarn]]
name = "thread"
fibre = "wool"
count = "2/60 Nm"
twist_per_m = 500
packing = 0.55
optics = { eta = 1.56, k_d = 0.4, gamma_s_deg = 14, gamma_v_deg = 28 }
"""
MELANGE = """
[yarn.irregularity]
melange = [{ color = "#000000", share = 0.75 }, { color = "#ffffff", share = 0.25 }]
"""
MOULINE = """
[yarn.irregularity]
strands = [{ color = "#203060" }, { color = "#e0e0d0" }]
"""


@pytest.fixture
def read(tmp_path):
    def read(text: str):
        path = tmp_path / "recipe.toml"
        path.write_text(text, encoding="utf-8")
        return read_recipe(path)

    return read


def test_a_yarn_is_regular_where_nothing_else_is_stated(read):
    assert read(RECIPE).yarns[0].irregularity == REGULAR
    assert read(RECIPE + "[yarn.irregularity]\n").yarns[0].irregularity == REGULAR


def test_what_is_stated_reaches_the_yarn_in_the_cloth(read):
    recipe = read(
        RECIPE + "[yarn.irregularity]\nthickness = 0.1\nthickness_correlation_mm = 8\n"
        "bend = 0.05\ncolor_delta_e = 2\ncolor_correlation_mm = 15\nhairiness = 0.3\n"
    )
    (one, other) = weave(make_draft("plain"), recipe).yarns
    found = one.irregularity
    assert found == other.irregularity == recipe.yarns[0].irregularity
    assert (found.thickness, found.thickness_correlation_mm, found.bend) == (0.1, 8, 0.05)
    assert (found.color, found.color_correlation_mm, found.hairiness) == (2, 15, 0.3)


def test_a_melange_is_of_the_mean_of_its_fibres(read):
    spec = read(RECIPE + MELANGE).yarns[0]
    assert linear_from_srgb(spec.color) == pytest.approx((0.25,) * 3)
    assert [share for _, share in spec.irregularity.melange] == [0.75, 0.25]
    assert spec.color_stated == "75 % #000000 + 25 % #ffffff"


def test_a_mouline_is_of_the_mean_of_its_strands(read):
    spec = read(RECIPE + MOULINE).yarns[0]
    strands = [linear_from_srgb(srgb_from_hex(h)) for h in ("#203060", "#e0e0d0")]
    assert linear_from_srgb(spec.color) == pytest.approx(np.mean(strands, 0))
    assert spec.irregularity.strands == tuple(strands)


@pytest.mark.parametrize("mixed", [MELANGE, MOULINE], ids=["melange", "mouline"])
def test_a_mixture_shows_its_colors_and_no_other(read, mixed):
    cloth = weave(make_draft("plain"), read(RECIPE + mixed))
    colors = synthesize(cloth, resolution=128).whole()["base_color"].reshape(-1, 3)
    found = cloth.yarns[0].irregularity
    wanted = np.array(found.strands or [color for color, _ in found.melange])
    off = np.abs(colors[:, None] - wanted[None]).max(-1).min(-1)
    # A gap shows the mean of the end beside it.
    off = np.minimum(off, np.abs(colors - np.array(cloth.yarns[0].color)).max(-1))
    assert off.max() < 1e-5
    assert all((np.abs(colors - color).max(-1) < 1e-5).any() for color in wanted)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (RECIPE + "[yarn.irregularity]\nslub = 1\n", r":14: .*irregularity\.slub: unknown"),
        (RECIPE + "[yarn.irregularity]\nthickness = 2\n", r":14: .*thickness: found 2, expected 0"),
        (RECIPE + MELANGE.replace("0.25", "0.3"), r"melange: found 2 whose shares add up to 1\.05"),
        (RECIPE + MELANGE.replace("0.25", "0"), r":15: .*melange\[1\]\.share: found 0, exp"),
        (RECIPE + MELANGE.replace("#ffffff", "draft"), r"melange\[1\]\.color: found the draft's"),
        (RECIPE + MELANGE.replace("share = 0.25", "part = 1"), r"melange\[1\]\.share: missing"),
        (RECIPE.replace("2/60", "30") + MOULINE, "strands: found 2 for 1 plies, expected a color"),
        (RECIPE.replace("2/60", "3/60") + MOULINE, "strands: found 2 for 3 plies"),
        (RECIPE + MELANGE + MOULINE.replace("[yarn.irregularity]\n", ""), "found beside melange"),
        (RECIPE + 'color = "#111111"\n' + MELANGE, r":13: .*color: found beside colors to mix"),
    ],
)  # fmt: skip
def test_a_mixture_that_does_not_add_up_is_refused(read, text, message):
    with pytest.raises(RecipeError, match=message) as caught:
        read(text)
    assert "\n" not in str(caught.value)
