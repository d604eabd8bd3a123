"""The figures of a cloth, against hand calculation and textbook laws."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from tests.export.cloths import plain_weave
from weaveusd.cloth import measures
from weaveusd.cloth.floats import longest_float

drawdowns = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=8))


@given(drawdowns, st.integers(0, 7), st.integers(0, 7))
def test_the_longest_float_is_that_of_the_cloth_seen_from_any_side(warp_up, rows, columns):
    longest = longest_float(warp_up)
    assert longest_float(~warp_up) == longest
    assert longest_float(warp_up.T) == longest
    assert longest_float(np.roll(warp_up, (rows, columns), (0, 1))) == longest
    assert 1 <= longest <= max(warp_up.shape)


@pytest.mark.parametrize(
    ("rows", "longest"),
    [(["10", "01"], 1), (["1100", "0110", "0011", "1001"], 2), (["1"], 1), (["111"], 3)],
)
def test_known_weaves_have_known_floats(rows, longest):
    warp_up = np.array([[c == "1" for c in row] for row in rows])
    assert longest_float(warp_up) == longest


def test_plain_weave_has_the_crimp_of_its_arcs():
    for crimp in measures.crimps(plain_weave()):
        assert crimp == pytest.approx(0.5 / math.sin(0.5) - 1, rel=1e-12)


def test_jammed_square_cloth_has_the_crimp_of_the_textbook():
    weave = plain_weave()
    jammed = replace(weave.warp_floats, u_max=np.full(2, math.pi / 3))
    assert measures.crimps(replace(weave, warp_floats=jammed))[0] == pytest.approx(0.209, abs=5e-4)


def test_straight_threads_have_no_crimp():
    weave = plain_weave()
    flat = {"u_max": np.zeros(2)}
    straight = replace(
        weave,
        warp_floats=replace(weave.warp_floats, **flat),
        weft_floats=replace(weave.weft_floats, **flat),
    )
    assert measures.crimps(straight) == (0.0, 0.0)
    # 25 ends and 20 picks in a centimetre, 66 tex each: 66e-3 g/m · (2500 + 2000) m/m².
    assert measures.areal_density_g_m2(straight) == pytest.approx(0.066 * 4500)


def test_crimp_adds_to_the_weight():
    weave = plain_weave()
    assert measures.areal_density_g_m2(weave) == pytest.approx(
        0.066 * 4500 * (1 + measures.crimps(weave)[0])
    )


def test_a_balanced_cloth_is_as_thick_as_two_threads():
    weave = replace(plain_weave(), weft_height_mm=np.full(2, 0.18))
    assert measures.thickness_mm(weave) == pytest.approx(0.36)
    assert measures.thickness_mm(replace(weave, crimp_balance=1.0)) == pytest.approx(0.54)
    assert measures.thickness_mm(replace(weave, crimp_balance=0.0)) == pytest.approx(0.54)


def test_cover_is_width_over_pitch_and_never_above_one():
    weave = plain_weave()
    assert measures.warp_cover(weave) == pytest.approx(0.75)
    assert measures.weft_cover(weave) == pytest.approx(0.8)
    assert measures.warp_cover(replace(weave, warp_width_mm=np.full(2, 9.0))) == 1.0
