"""Colors keep what was measured, whichever way it was stated."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from weaveusd.errors import RecipeError
from weaveusd.yarn.color import linear_from_srgb, read_color, srgb_from_hex, srgb_from_linear
from weaveusd.yarn.colorimetry import (
    delta_e_2000,
    linear_from_lab,
    linear_from_reflectance,
)
from weaveusd.yarn.toml import parse_table

WAVELENGTHS = np.arange(380.0, 731.0, 10.0)
# CIE Lab of sRGB's primaries and a gray under D65 and, by Bradford, D50 (published calculators).
BOTH_WHITES = {
    "red": ((1, 0, 0), (53.2408, 80.0925, 67.2032), (54.2917, 80.8125, 69.8851)),
    "green": ((0, 1, 0), (87.7347, -86.1827, 83.1793), (87.8181, -79.2873, 80.9902)),
    "blue": ((0, 0, 1), (32.2970, 79.1875, -107.8602), (29.5676, 68.2986, -112.0294)),
    "gray": ((0.5, 0.5, 0.5), (76.0693, 0, 0), (76.0693, 0, 0)),
}


@pytest.fixture
def color(tmp_path):
    def color(value: str):
        return read_color(parse_table(f"color = {value}\n", "recipe.toml"), tmp_path)

    return color


@given(st.integers(0, (1 << 24) - 1))
def test_hex_to_linear_and_back_is_the_same_hex(number):
    text = f"#{number:06x}"
    back = srgb_from_linear(linear_from_srgb(srgb_from_hex(text)))
    assert "#" + "".join(f"{round(255 * v):02x}" for v in back) == text


@pytest.mark.parametrize("illuminant", ["D50", "D65"])
def test_white_is_one_under_both_illuminants(illuminant):
    assert linear_from_lab((100, 0, 0), illuminant) == pytest.approx((1, 1, 1), abs=1e-9)


@pytest.mark.parametrize("name", BOTH_WHITES)
def test_lab_of_both_illuminants_is_one_color(name):
    linear, d65, d50 = BOTH_WHITES[name]
    assert linear_from_lab(d65, "D65") == pytest.approx(linear, abs=1e-3)
    assert linear_from_lab(d50, "D50") == pytest.approx(linear, abs=1e-3)


@settings(deadline=None)  # the first example imports colour-science
@given(st.floats(0, 1))
def test_a_flat_spectrum_is_a_gray_of_its_reflectance(reflectance):
    flat = linear_from_reflectance(WAVELENGTHS, np.full(WAVELENGTHS.size, reflectance))
    assert flat == pytest.approx((reflectance,) * 3, abs=1e-9)


def test_a_spectrum_that_rises_is_warm_and_one_that_falls_is_cold():
    rise = np.linspace(0.1, 0.7, WAVELENGTHS.size)
    r, g, b = linear_from_reflectance(WAVELENGTHS, rise)
    assert r > g > b
    r, g, b = linear_from_reflectance(WAVELENGTHS, rise[::-1])
    assert r < g < b


def test_sampling_a_smooth_spectrum_closer_changes_nothing_visible():
    def smooth(nm):
        return 0.3 + 0.2 * np.sin(nm / 60)

    fine = np.arange(380.0, 731.0, 1.0)
    coarse = np.arange(380.0, 741.0, 20.0)
    ten = linear_from_reflectance(WAVELENGTHS, smooth(WAVELENGTHS))
    assert delta_e_2000(ten, linear_from_reflectance(fine, smooth(fine))) < 0.01
    assert delta_e_2000(ten, linear_from_reflectance(coarse, smooth(coarse))) < 0.2


def test_light_reflected_at_every_wavelength_adds_up():
    rng = np.random.default_rng(3)
    one, other = rng.uniform(0.2, 0.4, (2, WAVELENGTHS.size))
    both = np.array(linear_from_reflectance(WAVELENGTHS, one + other))
    apart = [linear_from_reflectance(WAVELENGTHS, r) for r in (one, other)]
    np.testing.assert_allclose(both, np.sum(apart, 0), atol=1e-12)


def test_every_way_to_state_one_color_agrees(color, tmp_path):
    rows = "\n".join(f"{nm:g},0.5" for nm in WAVELENGTHS)
    (tmp_path / "half.csv").write_text(f"nm,R\n{rows}\n")
    ways = [
        '"#bcbcbc"',  # 0.503 linear
        '{ lab = [76.07, 0, 0], illuminant = "D50" }',
        '{ lab = [76.07, 0, 0], illuminant = "D65" }',
        '{ reflectance = "half.csv" }',
    ]
    for way in ways:
        found = color(way)
        assert found.outside == ()
        assert found.srgb == pytest.approx((0.7354,) * 3, abs=2e-3), way


def test_the_draft_colors_what_the_recipe_does_not(color):
    assert color('"draft"').srgb is None


def test_a_color_that_no_display_shows_is_kept_whole_until_its_space_is_known(color):
    found = color('{ lab = [60, 90, -80], illuminant = "D65" }')
    (outside,) = found.outside
    assert outside.stated == "recipe.toml:1: color: Lab 60 90 -80 D65"
    assert outside.linear == pytest.approx(linear_from_lab((60, 90, -80), "D65"))
    assert linear_from_srgb(found.srgb) == pytest.approx(outside.linear, abs=1e-8)


@given(st.tuples(*[st.floats(-0.5, 2)] * 3))
def test_the_curve_and_its_inverse_go_on_beyond_what_a_display_shows(linear):
    assert linear_from_srgb(srgb_from_linear(linear)) == pytest.approx(linear, abs=1e-9)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ('"red"', "found 'red', expected \"draft\""),
        ('"#12345"', "found '#12345'"),
        ("3", "found 3"),
        ("{}", "color.lab: missing; expected exactly one of lab, reflectance"),
        ('{ lab = [1, 2, 3], reflectance = "a.csv" }', "color.reflectance: found beside lab"),
        ("{ lab = [50, 0, 0] }", "color.illuminant: missing"),
        ('{ lab = [50, 0, 0], illuminant = "A" }', "illuminant: found 'A', expected one of D50"),
        ('{ lab = [50, 0], illuminant = "D50" }', r"lab: found \[50, 0\], expected \[L, a, b\]"),
        ('{ lab = [101, 0, 0], illuminant = "D50" }', "L 0 to 100"),
        ('{ lab = [50, nan, 0], illuminant = "D50" }', "-150 to 150"),
        ('{ lab = [50, true, 0], illuminant = "D50" }', "-150 to 150"),
        ('{ lab = [50, 0, 0], illuminant = "D50", gloss = 1 }', "color.gloss: unknown key"),
    ],
)
def test_a_color_that_says_nothing_certain_is_refused(color, value, message):
    with pytest.raises(RecipeError, match=message) as caught:
        color(value)
    assert str(caught.value).startswith("recipe.toml:1: color")


def test_colour_science_comes_only_when_a_color_was_measured_and_quietly():
    script = (
        "import sys, numpy as np\n"
        "from weaveusd.yarn.recipe import preset_names, read_preset\n"
        "[read_preset(n) for n in preset_names()]\n"
        "assert 'colour' not in sys.modules\n"
        "before = np.get_printoptions()\n"
        "from weaveusd.yarn.colorimetry import linear_from_lab\n"
        "linear_from_lab((50, 0, 0), 'D50')\n"
        "assert 'colour' in sys.modules\n"
        "assert np.get_printoptions() == before\n"
    )
    done = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", "-c", script],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
