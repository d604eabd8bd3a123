"""Recipes are read strictly, and every preset says where it comes from."""

from __future__ import annotations

import pytest

from weaveusd.errors import RecipeError
from weaveusd.yarn.recipe import preset_names, read_preset, read_recipe
from weaveusd.yarn.textile import diameter_mm, twist_angle

GOOD = """\
name = "test"
title = "Test"
source = "invented"

[sett]
ends_per_cm = 20
picks_per_cm = 18

[[yarn]]
name = "thread"
fibre = "linen"
tex = 66
twist_per_m = 420
packing = 0.6

[yarn.optics]
eta = 1.46
k_d = 0.3
gamma_s_deg = 12
gamma_v_deg = 24
"""


@pytest.fixture
def write(tmp_path):
    def write(text: str):
        path = tmp_path / "recipe.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_recipe_is_read(write):
    recipe = read_recipe(write(GOOD))
    assert (recipe.ends_per_cm, recipe.picks_per_cm) == (20, 18)
    assert recipe.yarns[0].systems == ("warp", "weft")
    assert recipe.yarns[0].optics.gamma_s == pytest.approx(0.20944, abs=1e-5)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("tex = 66", "tex = -1", r"recipe\.toml:12: yarn\[0\]\.tex: found -1, expected 0\.1 to"),
        ("tex = 66", 'tex = "66"', r":12: yarn\[0\]\.tex: found '66', expected a number"),
        ("tex = 66", "tex = nan", r":12: yarn\[0\]\.tex: found nan, expected"),
        ("tex = 66\n", "", r":9: yarn\[0\]\.tex: missing"),
        ("k_d = 0.3", "k_d = 0.3\nshine = 2", r":19: yarn\[0\]\.optics\.shine: unknown key"),
        ('"linen"', '"kevlar"', r":11: yarn\[0\]\.fibre: found 'kevlar', expected one of cotton"),
        ("ends_per_cm = 20", "ends_per_cm = true", r":6: sett\.ends_per_cm: found True"),
        ("[sett]", "[sett", r":5: not valid TOML"),
        ('packing = 0.6', 'packing = 0.6\ncolor = "red"', r":15: yarn\[0\]\.color: found 'red'"),
        ('packing = 0.6', 'packing = 0.6\nsystems = "warp"', r":15: yarn\[0\]\.systems: found"),
        ('packing = 0.6', "packing = 0.6\npalette = [0]", r":15: yarn\[0\]\.palette: found"),
    ],
)  # fmt: skip
def test_a_fault_is_named_with_its_line_and_key(write, old, new, message):
    with pytest.raises(RecipeError, match=message) as caught:
        read_recipe(write(GOOD.replace(old, new)))
    assert "\n" not in str(caught.value)


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "binary.toml"
    path.write_bytes(b"\xff\xfe\x00name")
    with pytest.raises(RecipeError, match="not UTF-8"):
        read_recipe(path)


def test_a_huge_file_is_refused_before_it_is_read(write):
    with pytest.raises(RecipeError, match="larger than"):
        read_recipe(write("#" * ((1 << 20) + 1)))


def test_a_missing_file_is_named():
    with pytest.raises(RecipeError, match=r"nowhere\.toml: No such file"):
        read_recipe("nowhere.toml")


def test_an_unknown_preset_lists_those_there_are():
    with pytest.raises(RecipeError, match="linen"):
        read_preset("asbestos")


@pytest.mark.parametrize("name", preset_names())
def test_every_preset_is_named_like_its_file_and_has_a_source(name):
    recipe = read_preset(name)
    assert recipe.name == name
    assert len(recipe.source) > 20
    assert recipe.certainty


def test_a_twenty_count_cotton_has_the_diameter_that_peirce_gives():
    ours = diameter_mm(590.5 / 20, "cotton", 0.91 / 1.52)
    assert ours == pytest.approx(25.4 / 28 / 20**0.5, rel=3e-3)


def test_s_twist_leans_to_the_left_and_z_to_the_right():
    assert twist_angle(500, "S", 0.3) > 0
    assert twist_angle(500, "Z", 0.3) == -twist_angle(500, "S", 0.3)
    assert twist_angle(0, "Z", 0.3) == 0
