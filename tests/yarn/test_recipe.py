"""Recipes are read strictly, and every preset says where it comes from."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from weaveusd.errors import RecipeError
from weaveusd.yarn.color import linear_from_srgb
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
        ("tex = 66", "tex = 66\nNe = 9", r":13: yarn\[0\]\.Ne: found beside tex, expected exactly"),
        ("tex = 66", "Ne = 0", r":12: yarn\[0\]\.Ne: found 0, expected 0\.0059"),
        ("tex = 66", 'count = "3/4 Ne"', r":12: yarn\[0\]\.count: found '3/4 Ne', expected one"),
        ("tex = 66", 'count = "2/60 Nm"\nplies = 2', r":13: yarn\[0\]\.plies: found beside a"),
        ("tex = 66", "tex = 66\nplies = 1.5", r":13: yarn\[0\]\.plies: found 1\.5, expected a"),
        ("tex = 66", "tex = 66\nplies = 17", r":13: yarn\[0\]\.plies: found 17, expected 1 to 16"),
        ("420", "420\ntwist_per_inch = 9", r":14: yarn\[0\]\.twist_per_inch: found beside"),
        ("twist_per_m = 420\n", "", r":9: yarn\[0\]\.twist_per_m: missing; expected exactly one"),
        ("0.6", "0.6\nheight_mm = 0.2\nflatness = 0.5", r":16: yarn\[0\]\.flatness: found beside"),
        ("0.6", "0.6\ncrimp = 1.5", r":15: yarn\[0\]\.crimp: found 1\.5, expected 0 to 1"),
        ("0.6", "0.6\nu_max_deg = 90", r":15: yarn\[0\]\.u_max_deg: found 90, expected 0 to 85"),
        ("0.6", "0.6\ntwist_angle_deg = -20", r":15: yarn\[0\]\.twist_angle_deg: found -20"),
        ("ends_per_cm = 20", "ends_per_cm = 20\nends_per_inch = 50", r":7: sett\.ends_per_inch:"),
        ("picks_per_cm = 18", "picks = 18", r":5: sett\.picks_per_cm: missing; expected exactly"),
        ("picks_per_cm = 18", "picks_per_inch = 9999", r":7: sett\.picks_per_inch: found 9999"),
        ('title = "Test"', 'title = "Two\\nlines"', r":2: title: found 'Two\\nlines', expected"),
        ('title = "Test"', 'weight_g_m2 = 0\ntitle = "Test"', r":2: weight_g_m2: found 0"),
        ('title = "Test"', '"a\\nb" = 1\ntitle = "Test"', r"recipe\.toml: 'a\\nb': unknown key"),
        ("[sett]", "[weave]\nkind = 1\n\n[sett]", r":6: weave\.kind: unknown key; known here:"),
        ('packing = 0.6', 'packing = 0.6\nsystems = "warp"', r":15: yarn\[0\]\.systems: found"),
        ('packing = 0.6', "packing = 0.6\npalette = [0]", r":15: yarn\[0\]\.palette: found"),
    ],
)  # fmt: skip
def test_a_fault_is_named_with_its_line_and_key(write, old, new, message):
    with pytest.raises(RecipeError, match=message) as caught:
        read_recipe(write(GOOD.replace(old, new)))
    assert "\n" not in str(caught.value)


def test_a_count_too_long_to_be_a_number_is_refused(write):
    with pytest.raises(RecipeError, match="not valid TOML"):
        read_recipe(write(GOOD.replace("66", "9" * 5000)))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("ends_per_cm = 20", "ends_per_inch = 50.8"),
        ("picks_per_cm = 18", "picks_per_inch = 45.72"),
        ("twist_per_m = 420", "twist_per_inch = 10.668"),
        ("tex = 66", "denier = 594"),
        ("tex = 66", "Nm = 15.151515151515"),
        ("tex = 66", 'count = "66 tex"'),
        ("tex = 66", 'count = "66 tex"\nplies = 1'),
    ],
)
def test_units_of_two_worlds_state_one_recipe(write, old, new):
    one, other = read_recipe(write(GOOD)), read_recipe(write(GOOD.replace(old, new)))
    yarn = replace(
        other.yarns[0],
        tex=pytest.approx(other.yarns[0].tex),
        twist_per_m=pytest.approx(other.yarns[0].twist_per_m),
        count=one.yarns[0].count,
    )
    assert (one.ends_per_cm, one.picks_per_cm) == pytest.approx(
        (other.ends_per_cm, other.picks_per_cm)
    )
    assert yarn == one.yarns[0]


def test_a_plied_yarn_is_as_heavy_as_its_singles(write):
    yarn = read_recipe(write(GOOD.replace("tex = 66", 'count = "2/60 Nm"'))).yarns[0]
    assert (yarn.tex, yarn.plies, yarn.count) == (pytest.approx(33.33, abs=0.01), 2, "2/60 Nm")


def test_a_stated_angle_leans_with_the_twist(write):
    stated = GOOD.replace("packing = 0.6", "packing = 0.6\ntwist_angle_deg = 20")
    z = read_recipe(write(stated)).yarns[0].twist_angle
    s = read_recipe(write(stated.replace("packing", 'twist_direction = "S"\npacking'))).yarns[0]
    assert z == pytest.approx(-math.radians(20))
    assert s.twist_angle == pytest.approx(math.radians(20))


def test_a_spectrum_lies_beside_its_recipe(write, tmp_path, monkeypatch):
    (tmp_path / "a.csv").write_text("\n".join(f"{nm},0.5" for nm in range(380, 731, 10)))
    path = write(GOOD.replace("0.6\n", '0.6\ncolor = { reflectance = "a.csv" }\n'))
    monkeypatch.chdir("/")
    yarn = read_recipe(path).yarns[0]
    assert linear_from_srgb(yarn.color) == pytest.approx((0.5,) * 3, abs=1e-8)
    assert yarn.color_stated == "reflectance a.csv"


def test_a_spectrum_that_is_not_there_is_named_with_the_line_that_asks(write):
    with pytest.raises(RecipeError, match=r":15: yarn\[0\]\.color\.reflectance: no such file"):
        read_recipe(write(GOOD.replace("0.6\n", '0.6\ncolor = { reflectance = "b.csv" }\n')))


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
