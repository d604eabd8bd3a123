"""The matrices are those of the standards, and undo each other."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from weaveusd.color_space import (
    ACESCG_TO_REC709,
    DISPLAY_NAMES,
    LUMINANCE,
    REC709_TO_ACESCG,
    from_rec709,
    texels_to_rec709,
    to_rec709,
)
from weaveusd.contract import COLOR_SPACES

COLORS = st.tuples(*[st.floats(0, 1)] * 3)


def test_the_constants_are_those_of_colour_science():
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", '"(Matplotlib|SciPy)" related API features')
        import colour
    rec709, acescg = (colour.RGB_COLOURSPACES[n] for n in ("ITU-R BT.709", "ACEScg"))
    for matrix, way in (
        (REC709_TO_ACESCG, (rec709, acescg)),
        (ACESCG_TO_REC709, (acescg, rec709)),
    ):
        expected = colour.matrix_RGB_to_RGB(*way, chromatic_adaptation_transform="Bradford")
        np.testing.assert_allclose(matrix, expected, atol=1e-12)
    for name, space in (("lin_rec709", rec709), ("acescg", acescg)):
        # BT.709 states its weights to four digits.
        np.testing.assert_allclose(LUMINANCE[name], space.matrix_RGB_to_XYZ[1], atol=5e-5)


def test_every_space_has_weights_that_add_up_and_a_name():
    assert tuple(LUMINANCE) == tuple(DISPLAY_NAMES) == COLOR_SPACES
    assert all(sum(weights) == pytest.approx(1) for weights in LUMINANCE.values())


@pytest.mark.parametrize("space", COLOR_SPACES)
@given(color=COLORS)
def test_there_and_back_is_the_same_color(space, color):
    there = from_rec709(color, space)
    assert to_rec709(there, space) == pytest.approx(color, abs=1e-12)
    assert texels_to_rec709(np.array([[there]]), space)[0, 0] == pytest.approx(color, abs=1e-12)


@given(color=COLORS)
def test_acescg_holds_all_of_rec709(color):
    assert all(0 <= v <= 1 + 1e-15 for v in from_rec709(color, "acescg"))
