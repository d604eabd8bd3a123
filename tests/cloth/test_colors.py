"""Colors come into the cloth's space; what is lost there, and only that, is reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from weaveusd.cloth.weave import weave
from weaveusd.color_space import from_rec709
from weaveusd.draft.make import make_draft
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.color import srgb_from_linear
from weaveusd.yarn.colorimetry import linear_from_lab
from weaveusd.yarn.irregularity import Irregularity
from weaveusd.yarn.model import OutsideColor
from weaveusd.yarn.recipe import read_preset

SPACES = ("lin_rec709", "acescg")
LINEN = read_preset("linen")
TURQUOISE = linear_from_lab((60, -45, -30), "D65")
"""Red is negative in Rec.709; ACEScg holds it."""
VIOLET = linear_from_lab((60, 90, -80), "D65")
"""Outside both."""
PRIMARIES = {"red": (53.2408, 80.0925, 67.2032), "green": (87.7347, -86.1827, 83.1793)}


def cloth(linear, space, **changes):
    outside = (OutsideColor("mill.toml:3: color: Lab", linear),)
    spec = replace(LINEN.yarns[0], color=srgb_from_linear(linear), colors_outside=outside)
    return weave(
        make_draft("plain"),
        replace(LINEN, yarns=(replace(spec, **changes),)),
        color_space=space,
    )


def test_a_color_outside_rec709_is_reported_there_and_kept_in_acescg():
    narrow, wide = (cloth(TURQUOISE, space) for space in SPACES)
    (warning,) = narrow.warnings
    assert warning.startswith("mill.toml:3: color: Lab is outside Rec.709 (linear -0.")
    assert "clipped, CIEDE2000" in warning
    assert wide.warnings == ()
    assert narrow.yarns[0].color[0] == 0
    assert wide.yarns[0].color == pytest.approx(from_rec709(TURQUOISE, "acescg"), abs=1e-9)
    assert (narrow.color_space, wide.color_space) == SPACES


def test_a_color_outside_acescg_is_reported_with_its_numbers_there():
    (warning,) = cloth(VIOLET, "acescg").warnings
    assert "outside ACEScg (linear 0.522, 0.109, 1.173)" in warning
    assert "\n" not in warning


@pytest.mark.parametrize("space", SPACES)
def test_rounding_of_a_measured_primary_is_not_reported(space):
    for lab in PRIMARIES.values():
        assert cloth(linear_from_lab(lab, "D65"), space).warnings == ()


@given(st.floats(0, 1))
def test_a_gray_is_the_same_in_both_spaces(gray):
    narrow, wide = (cloth((gray,) * 3, space).yarns[0].color for space in SPACES)
    assert wide == pytest.approx(narrow, abs=1e-15)


@pytest.mark.parametrize("space", SPACES)
def test_a_mixture_is_the_mean_of_its_colors_as_they_came_out(space):
    uneven = Irregularity(melange=((TURQUOISE, 0.25), ((0.5, 0.5, 0.5), 0.75)))
    yarn = cloth(TURQUOISE, space, irregularity=uneven).yarns[0]
    parts = [(np.array(color), share) for color, share in yarn.irregularity.melange]
    assert min(color.min() for color, _ in parts) >= 0
    assert yarn.color == pytest.approx(sum(share * color for color, share in parts))
    assert (parts[0][0][0] == 0) == (space == "lin_rec709")


def test_tones_of_a_color_are_as_light_in_both_spaces():
    uneven = Irregularity(color=4.0)
    color = (0.3, 0.1, 0.05)
    narrow, wide = (
        synthesize(cloth(color, space, irregularity=uneven), resolution=64).whole()["base_color"]
        for space in SPACES
    )
    flat = narrow.reshape(-1, 3).astype(float)
    assert np.ptp(flat[:, 0]) > 0.05
    expected = np.array([from_rec709(tuple(texel), "acescg") for texel in flat])
    # Adaptation from D65 to D60 moves the luminance of a color, and with it its lightness.
    np.testing.assert_allclose(wide.reshape(-1, 3), expected, rtol=1e-3)
