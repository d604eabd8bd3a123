"""What moments say of the yarns under a footprint: even distributions, boxes, of their places."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.synth import moments as m

if TYPE_CHECKING:
    from weaveusd.shading.fibre import Doubles

NOTHING = 1e-7
"""Share of a footprint that is none."""

POINT = 1e-6
"""Least width of a box, so that a part of it may be lit."""


class Box(NamedTuple):
    """An even distribution from `low` to `high`, and its share of the footprint."""

    low: float
    high: float
    share: float


def coverage(moments: Doubles) -> float:
    """Return a, the opacity of the system in the footprint."""
    return float(moments[m.FLAT] + moments[m.RISING] + moments[m.FALLING])


def arcs(moments: Doubles, count: int) -> list[Box]:
    """Return boxes in S: the straight part, and `count` of equal share of each slope.

    A slope is one box, or two that adjoin at its median, the first from S = 0, where floats of
    unlike lengths give a variance that no box can have. What there is none of has boxes without
    share, so that each box has its place in the list.
    """
    boxes = [Box(0.0, 0.0, float(moments[m.FLAT]))]
    for share, first, second, sign in (
        (m.RISING, m.RISING_S, m.RISING_SS, 1),
        (m.FALLING, m.FALLING_S, m.FALLING_SS, -1),
    ):
        whole = float(moments[share])
        if whole > NOTHING:
            ends = _quantiles(sign * moments[first] / whole, moments[second] / whole, count)
            pairs = (sorted((sign * a, sign * b)) for a, b in pairwise(ends))
            boxes += [Box(low, high, whole / count) for low, high in pairs]
        else:
            boxes += [Box(0.0, 0.0, 0.0)] * count
    return boxes


def _quantiles(mean: float, square: float, count: int) -> list[float]:
    """Return the ends (count + 1) of parts of equal share; the half width is √(3 variance)."""
    mean = max(mean, 0)
    reach = np.sqrt(3 * max(square - mean * mean, 0))
    if reach <= mean or count == 1:
        reach = min(reach, mean)
        low, middle, high = mean - reach, mean, mean + reach
    else:
        middle = max(0.5 * (3 * mean - np.sqrt(6 * square - 7 * mean * mean)), 0)
        low, high = 0.0, 4 * mean - 2 * middle
    ends = np.interp(np.linspace(0, 1, count + 1), (0, 0.5, 1), (low, middle, min(high, 1)))
    return [float(end) for end in ends]


def halves(moments: Doubles) -> list[Box]:
    """Return boxes in X, of the half of the yarn where X is positive and of the other.

    The moments tell ∫ X of each half, not its share. One piece of yarn around the middle has shares
    as the roots of these; of two pieces apart the mean of |X| is taken to be the same. How wide
    |X| spreads says which of both is nearer. Widths are as the shares, and all moments are kept.
    """
    a = coverage(moments)
    aside, square, across = (float(moments[k] / a) for k in (m.ASIDE, m.ACROSS_XX, m.ACROSS))
    right, left = max(0.5 * (aside + across), 0), max(0.5 * (aside - across), 0)
    apart = min(max(0.5 * (1 + across / max(aside, 1e-12)), 0), 1)
    around = np.sqrt(right) / max(np.sqrt(right) + np.sqrt(left), 1e-12)
    spread = min(max(3 * (square / max(aside * aside, 1e-24) - 1), 0), 1)
    share = min(max(apart + spread * (around - apart), right), max(1 - left, right))
    parts = [(1, share, right), (-1, 1 - share, left)]
    parts = [(sign, part, total / part) for sign, part, total in parts if part > NOTHING]
    rest = max(square - sum(part * mean * mean for _, part, mean in parts), 0)
    scale = np.sqrt(12 * rest / sum(part**3 for _, part, _ in parts))
    return [_half(sign, part, mean, scale * part) for sign, part, mean in parts]


def _half(sign: int, share: float, mean: float, width: float) -> Box:
    reach = 0.5 * max(min(width, 2 * mean, 2 * (1 - mean)), POINT)
    low, high = sorted((sign * (mean - reach), sign * (mean + reach)))
    return Box(float(low), float(high), float(share))


def twist(moments: Doubles) -> tuple[float, float]:
    """Return mean and deviation of sin ψ."""
    a = coverage(moments)
    mean = float(moments[m.TWIST] / a)
    return mean, float(np.sqrt(max(moments[m.TWIST_PP] / a - mean * mean, 0)))
