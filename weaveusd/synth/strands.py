"""Strands: where the plies of a yarn wind around it."""

from __future__ import annotations

import math

from weaveusd.synth.compiled import inlined

_1, _3 = 0.5 / math.pi, 0.25 - 0.5 / math.pi
"""Coefficients of sin v and its cube that stand for v / 2π."""


@inlined
def strand(plies: float, turns: float, phase: float, sin_v: float, s: float) -> float:
    """Return the strand at the section angle v and the share `s` of the repeat, not whole.

    Strands wind around the yarn: p = plies v / 2π + turns s. In place of v / 2π stands an odd
    cubic of sin v that has its slope at the crown and its value ±¼ at the sides.
    """
    around = sin_v * (_1 + _3 * sin_v * sin_v)
    return plies * around + turns * s + phase


@inlined
def strand_slope(sin_v: float) -> float:
    """Return by how many strands of one ply `strand` grows with sin v."""
    return _1 + 3.0 * _3 * sin_v * sin_v
