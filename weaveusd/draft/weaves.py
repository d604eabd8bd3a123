"""Standard weaves as drawdowns of one repeat: (picks, ends) bool, True where the end is up.

Row 0 is the first pick and y runs up, so that a Z twill climbs from lower left to upper right.
"""

from __future__ import annotations

from math import gcd, lcm
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.draft.model import Bools

Direction = Literal["S", "Z"]
Steps = tuple[int, ...]
"""Ends up, ends down and so on along a pick, in turn: (2, 2), (3, 1) or (3, 1, 1, 2)."""


def plain() -> Bools:
    """Return the plain weave: end 1 is up on pick 1."""
    return np.eye(2, dtype=np.bool_)


def twill(steps: Steps, direction: Direction = "Z") -> Bools:
    """Return a twill that moves by one end a pick; 45° where the setts are equal."""
    along = _along(steps)
    pick = np.arange(along.size)
    return _moved(along, pick if direction == "Z" else -pick)


def herringbone(steps: Steps, ends: int) -> Bools:
    """Return stripes of `ends` ends of Z and S twill in turn.

    The S stripes are inverted, so that up meets down at the border and no float runs across.
    """
    z = twill(steps)
    wide = np.arange(ends) % z.shape[1]
    return np.hstack([z[:, wide], ~z[:, wide[::-1]]])


def pointed(steps: Steps) -> Bools:
    """Return a twill whose direction turns at a single end: waves along the weft."""
    return twill(steps)[:, _there_and_back(sum(steps))]


def diamond(steps: Steps) -> Bools:
    """Return a pointed twill that turns along the warp as well."""
    turn = _there_and_back(sum(steps))
    return twill(steps)[np.ix_(turn, turn)]


def satin(shafts: int, step: int) -> Bools:
    """Return the warp-faced satin; each end is down once, `step` ends further each pick.

    Raises
    ------
    ValueError
        When step and shafts have a common divisor, or the step is 1 or shafts - 1: a twill.
    """
    if not 2 <= step <= shafts - 2 or gcd(step, shafts) != 1:
        raise ValueError(f"a satin of {shafts} has no step {step}")
    return _moved(np.arange(shafts) != 0, step * np.arange(shafts))


def basket(ends: int, picks: int) -> Bools:
    """Return a plain weave of `ends` ends and `picks` picks that go as one.

    With one of them 1 it is a rib: `basket(1, 2)` a warp rib, `basket(2, 1)` a weft rib.
    """
    return np.kron(np.eye(2, dtype=np.bool_), np.ones((picks, ends), dtype=np.bool_))


def honeycomb(shafts: int) -> Bools:
    """Return the honeycomb, or waffle, over 2 shafts - 2 threads each way.

    With p and q the distances of end and pick from the middle of the cell, ends are up inside
    the diamond p + q <= shafts - 2, which floats them over the cell's middle, and on the line
    p + q = shafts around it, which ties the weft that floats in the corners.
    """
    middle = shafts - 1
    away = np.abs(np.arange(2 * middle) - middle)
    both = away[:, None] + away[None, :]
    up: Bools = (both <= shafts - 2) | (both == shafts)
    return up


def tiled(up: Bools, picks: int, ends: int) -> Bools:
    """Return the drawdown over the least multiples of its repeat and of `picks` and `ends`."""
    down, across = lcm(up.shape[0], picks), lcm(up.shape[1], ends)
    return np.tile(up, (down // up.shape[0], across // up.shape[1]))


def _along(steps: Steps) -> Bools:
    up: Bools = np.repeat(np.arange(len(steps)) % 2 == 0, steps)
    return up


def _moved(along: Bools, shift: NDArray[np.int_]) -> Bools:
    """Return one row a shift: `along` moved cyclically to the right by it."""
    up: Bools = along[(np.arange(along.size) - shift[:, None]) % along.size]
    return up


def _there_and_back(count: int) -> NDArray[np.int_]:
    return np.concatenate([np.arange(count), np.arange(count - 2, 0, -1)])
