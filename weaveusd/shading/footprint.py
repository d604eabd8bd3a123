"""What moments say of the yarns under a footprint: even distributions, boxes, of their places."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.synth import moments as m

if TYPE_CHECKING:
    from weaveusd.shading.fibre import Doubles

NOTHING = 1e-7
"""Share of a footprint that is none."""

POINT = 1e-6
"""Least width of a box across the yarn, so that a part of it may be lit."""


class Box(NamedTuple):
    """An even distribution from `low` to `high`, and its share of the footprint."""

    low: float
    high: float
    share: float


def coverage(moments: Doubles) -> float:
    """Return a, the opacity of the system in the footprint."""
    return float(moments[m.FLAT] + moments[m.RISING] + moments[m.FALLING])


def arcs(moments: Doubles, count: int) -> list[Box]:
    """Return boxes in S: the straight part, and `count` pieces of what rises and what falls."""
    boxes = [Box(0.0, 0.0, float(moments[m.FLAT]))]
    for share, mean, square, low, high in (
        (m.RISING, m.RISING_S, m.RISING_SS, 0.0, 1.0),
        (m.FALLING, m.FALLING_S, m.FALLING_SS, -1.0, 0.0),
    ):
        whole = _box(moments[share], moments[mean], moments[square], low, high)
        step = (whole.high - whole.low) / count
        boxes += [
            Box(whole.low + k * step, whole.low + (k + 1) * step, whole.share / count)
            for k in range(count)
        ]
    return [box for box in boxes if box.share > NOTHING]


def halves(moments: Doubles) -> list[Box]:
    """Return boxes in X, of the half of the yarn where X is positive and of the other.

    Both have the same distribution of |X|, and as much of the yarn as makes the mean of X.
    """
    a = coverage(moments)
    aside, square, across = (moments[k] / a for k in (m.ASIDE, m.ACROSS_XX, m.ACROSS))
    box = _box(1.0, aside, square, 0.0, 1.0)
    middle = 0.5 * (box.low + box.high)
    reach = max(0.5 * (box.high - box.low), 0.5 * POINT)
    low, high = middle - reach, middle + reach
    right = min(max(0.5 * (1 + across / max(aside, 1e-12)), 0), 1)
    halves = Box(low, high, right), Box(-high, -low, 1 - right)
    return [half for half in halves if half.share > NOTHING]


def _box(share: float, first: float, second: float, low: float, high: float) -> Box:
    """Return the box of given sums within `low` and `high`; the half width is √(3 variance)."""
    if share <= NOTHING:
        return Box(low, low, 0.0)
    mean = first / share
    reach = np.sqrt(3 * max(second / share - mean * mean, 0))
    return Box(float(max(mean - reach, low)), float(min(mean + reach, high)), float(share))


def twist(moments: Doubles) -> tuple[float, float]:
    """Return mean and deviation of sin ψ."""
    a = coverage(moments)
    mean = float(moments[m.TWIST] / a)
    return mean, float(np.sqrt(max(moments[m.TWIST_PP] / a - mean * mean, 0)))
