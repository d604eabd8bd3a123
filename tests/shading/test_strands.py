"""Strands: boxes keep the moments that they are made from, and hold only what is seen."""

from __future__ import annotations

import numpy as np
import pytest

from weaveusd.shading.directions import pairs
from weaveusd.shading.fibre import dot
from weaveusd.shading.footprint import arcs, coverage, halves
from weaveusd.shading.strands import FULL, Nodes, frame, strands
from weaveusd.synth import moments as m
from weaveusd.synth.moments import Section

SECTION = Section(0.5, 0.1)
WI, WO = pairs(96)
ABOVE = np.array([[0.0, 0.0, 1.0]])


def of_places(s, x):
    """The moments of yarn at places (N,) along and across."""
    s, x = np.broadcast_arrays(np.asarray(s, float), np.asarray(x, float))
    out = np.zeros(m.MOMENTS)
    rising, falling = s > m.STRAIGHT, s < -m.STRAIGHT
    out[[m.RISING, m.RISING_S, m.RISING_SS]] = (
        rising.mean(),
        (rising * s).mean(),
        (rising * s * s).mean(),
    )
    out[[m.FALLING, m.FALLING_S, m.FALLING_SS]] = (
        falling.mean(),
        (falling * s).mean(),
        (falling * s * s).mean(),
    )
    out[m.FLAT] = 1 - out[m.RISING] - out[m.FALLING]
    out[[m.ACROSS, m.ASIDE, m.ACROSS_XX]] = x.mean(), np.abs(x).mean(), (x * x).mean()
    return out


def sums(boxes):
    """Share, ∫ x and ∫ x² of boxes."""
    return np.sum(
        [
            (b.share, b.share * (b.low + b.high) / 2,
             b.share * (b.low**2 + b.low * b.high + b.high**2) / 3)
            for b in boxes
        ],
        0,
    )  # fmt: skip


FLOATS = {
    "even": np.linspace(0.1, 0.6, 999),
    "from the middle": np.linspace(0.002, 0.6, 999),
    "long and short": np.concatenate([np.linspace(0.002, 0.2, 800), np.linspace(0.002, 0.6, 199)]),
}


@pytest.mark.parametrize("s", FLOATS.values(), ids=FLOATS)
@pytest.mark.parametrize("sign", [1, -1])
def test_arcs_keep_share_mean_and_variance_of_a_slope(s, sign):
    moments = of_places(sign * s, 0)
    names = [m.RISING, m.RISING_S, m.RISING_SS]
    if sign < 0:
        names = [m.FALLING, m.FALLING_S, m.FALLING_SS]
    for count in (2, 4):
        found = [box for box in arcs(moments, count) if box.share > 0]
        assert len(found) == count
        np.testing.assert_allclose(sums(found), moments[names], rtol=3e-3)


def test_one_arc_keeps_the_mean():
    moments = of_places(FLOATS["long and short"], 0)
    np.testing.assert_allclose(sums(arcs(moments, 1))[1], moments[m.RISING_S], rtol=1e-9)


@pytest.mark.parametrize(
    "x",
    [
        np.linspace(-1, 1, 999),
        np.linspace(0.2, 0.7, 999),
        np.linspace(-0.1, 0.4, 999),
        np.concatenate([np.linspace(0.7, 1, 300), np.linspace(-1, -0.6, 400)]),
    ],
    ids=["a whole yarn", "one side", "around the middle", "two neighbors"],
)
def test_halves_keep_the_moments_across(x):
    moments = of_places(0, x)
    found = halves(moments)
    share, mean, square = sums(found)
    aside = sum(b.share * abs(b.low + b.high) / 2 for b in found)
    np.testing.assert_allclose(
        [share, mean, aside, square],
        [1, moments[m.ACROSS], moments[m.ASIDE], moments[m.ACROSS_XX]],
        atol=0.01,
    )


def test_a_piece_around_the_middle_is_told_from_neighbors():
    right, left = halves(of_places(0, np.linspace(-0.1, 0.4, 999)))
    assert right.share == pytest.approx(0.8, abs=0.01)
    assert (right.low, right.high) == pytest.approx((0, 0.4), abs=0.02)
    assert (left.low, left.high) == pytest.approx((-0.1, 0), abs=0.02)


def test_from_straight_above_all_of_the_yarn_counts():
    s, x = np.meshgrid(np.linspace(-0.6, 0.6, 41), np.linspace(-0.9, 0.9, 41))
    moments = 0.7 * of_places(s, x)
    found = strands(ABOVE, ABOVE, np.ones(1), moments, SECTION, FULL)
    assert sum(strand.weight[0] for strand in found) == pytest.approx(coverage(moments), rel=1e-6)


@pytest.mark.parametrize("lit", [1, -1])
def test_strands_face_viewer_and_light(lit):
    wo, side = WO * (1, 1, lit), np.full(len(WO), float(lit))
    s, x = np.meshgrid(np.linspace(-0.7, 0.7, 41), np.linspace(-1, 1, 41))
    moments = of_places(s, x)
    count = 0
    for strand in strands(WI, wo, side, moments, SECTION, Nodes(3, 3, beyond=False)):
        seen = strand.weight > 1e-9
        count += np.count_nonzero(seen)
        for place in np.linspace(0.01, 0.99, 5):
            s_here = strand.along[0] + place * (strand.along[1] - strand.along[0])
            normal, _ = frame(s_here, strand.x, strand.sin_psi, SECTION)
            assert (dot(normal, WI)[seen] > -1e-9).all()
            assert (lit * dot(normal, wo)[seen] > -1e-9).all()
    assert count > 1000


def test_the_share_that_is_seen_is_that_of_the_places_that_face_both():
    even = (np.arange(80) + 0.5) / 40 - 1
    s, x = np.meshgrid(0.7 * even, even)
    moments = of_places(s, x)
    fine = strands(WI, WO, np.ones(len(WI)), moments, SECTION, Nodes(8, 2, beyond=False))
    found = sum(strand.weight for strand in fine)
    normals = np.stack([frame(a, b, 0.0, SECTION)[0] for a, b in zip(s, x, strict=True)])
    both = (normals @ WI.T > 0) & (normals @ WO.T > 0)
    np.testing.assert_allclose(found, both.mean((0, 1)), atol=0.02)
