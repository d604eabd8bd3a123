"""The name of a weave, found from one repeat of its drawdown."""

from __future__ import annotations

from math import atan2, degrees
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from weaveusd.draft.model import Bools

LARGEST = 64
"""Ends or picks of the largest repeat that has a name."""


def smallest_repeat(up: Bools) -> tuple[int, int]:
    """Return the picks and ends after which a drawdown repeats, divisors of its size."""
    return _period(up), _period(up.T)


def structure_name(up: Bools) -> str | None:
    """Return the name of the weave whose smallest repeat is `up`, None where it has none.

    Names are ``plain``, ``twill 2/2 Z 45°`` (ends up and down along a pick, in turn, with the
    angle at equal setts), ``satin 5 step 2``, ``sateen 5 step 3``, ``basket 2/2`` (ends and
    picks that go as one), ``warp rib 2`` and ``weft rib 2``, and ``herringbone``.
    """
    if max(up.shape) > LARGEST:
        return None
    return _basket(up) or _moving(up) or _herringbone(up)


def _period(rows: Bools) -> int:
    """Return the least divisor p of the rows such that row r + p equals row r."""
    kinds: dict[bytes, int] = {}
    packed = np.packbits(rows, axis=1)
    kind = np.array([kinds.setdefault(row.tobytes(), len(kinds)) for row in packed])
    count = len(kind)
    for period in range(1, count // 2 + 1):
        if count % period == 0 and np.array_equal(kind[period:], kind[:-period]):
            return period
    return count


def _basket(up: Bools) -> str | None:
    """Name a plain weave of groups of threads, wherever its repeat starts."""
    changes = up[0] != np.roll(up[0], 1)
    turns = up[:, 0] != np.roll(up[:, 0], 1)
    if not np.array_equal(up, up[0] ^ up[:, :1] ^ up[0, 0]):
        return None
    if changes.sum() != 2 or turns.sum() != 2:
        return None
    ends, picks = up.shape[1], up.shape[0]
    if np.diff(np.flatnonzero(changes))[0] * 2 != ends:
        return None
    if np.diff(np.flatnonzero(turns))[0] * 2 != picks:
        return None
    ends, picks = ends // 2, picks // 2
    if (ends, picks) == (1, 1):
        return "plain"
    if ends == 1:
        return f"warp rib {picks}"
    return f"weft rib {ends}" if picks == 1 else f"basket {ends}/{picks}"


def _moving(up: Bools) -> str | None:
    """Name a weave whose every pick is the one before, moved by the same number of ends."""
    ends = up.shape[1]
    for step in range(1, ends):
        if all(np.array_equal(up[r], np.roll(up[r - 1], step)) for r in range(len(up))):
            return _satin(up, step) or _twill(up, step)
    return None


def _satin(up: Bools, step: int) -> str | None:
    ends = up.shape[1]
    if up.shape[0] != ends or not 2 <= step <= ends - 2 or ends < 5:
        return None
    risen = int(up[0].sum())
    if risen == ends - 1:
        return f"satin {ends} step {step}"
    return f"sateen {ends} step {step}" if risen == 1 else None


def _twill(up: Bools, step: int) -> str:
    """Name a twill by its runs, the longest first, and by its angle to the weft."""
    ends = up.shape[1]
    starts = np.flatnonzero(up[0] != np.roll(up[0], 1))
    runs = np.diff(np.append(starts, starts[0] + ends)).tolist()
    turned = [
        tuple(runs[i:] + runs[:i]) for i in range(len(runs)) if bool(up[0, starts[i]])
    ]  # each way to begin with ends up
    steps = "/".join(map(str, max(turned)))
    # The line that the eye follows is the shortest way from a riser to the next.
    ways = [((k * step + ends // 2) % ends - ends // 2, k) for k in range(1, len(up) + 1)]
    across, rise = min((way for way in ways if way[0]), key=lambda way: way[0] ** 2 + way[1] ** 2)
    direction = "Z" if across > 0 else "S"
    return f"twill {steps} {direction} {degrees(atan2(rise, abs(across))):.0f}°"


def _herringbone(up: Bools) -> str | None:
    """Name stripes of one twill in both directions, inverted at their borders."""
    picks, ends = up.shape
    if ends % 2:
        return None
    for start in range(ends):
        left = np.roll(up, -start, axis=1)[:, : ends // 2]
        right = np.roll(up, -start, axis=1)[:, ends // 2 :]
        if np.array_equal(right, ~left[:, ::-1]) and _climbs(left):
            runs = up[:, 0]
            risen = int(runs.sum())
            return f"herringbone {risen}/{picks - risen} over {ends // 2} ends"
    return None


def _climbs(stripe: Bools) -> bool:
    """Return whether each end of the stripe is the one before, one pick later."""
    return stripe.shape[1] > 1 and all(
        np.array_equal(stripe[:, c], np.roll(stripe[:, c - 1], 1))
        for c in range(1, stripe.shape[1])
    )
