"""Smaller and smaller copies of a texture, each the mean of what it covers, weighed by opacity."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]


CLEAR = np.float32(2**-20)
"""Weight of a texel that is not opaque: nothing beside one that is."""


class Halving:
    """Takes rows of a level, from the top down, and makes the next: half the size, rounded down.

    A texel of the new level is the mean of the area it covers, of three texels on a side that is
    odd, weighed by their opacity, which is `CLEAR` at least: where nothing is opaque, all count
    alike. Sums run in one order, so that every machine gives the same bits.

    Parameters
    ----------
    width, height
        Size of the level whose rows are added; a side of 1 stays.
    channels
        Numbers a texel, opacity left out.
    """

    __slots__ = ("_across", "_added", "_along", "_sums")

    def __init__(self, width: int, height: int, channels: int) -> None:
        self._across = _Taps(width)
        self._along = _Taps(height)
        self._sums = np.zeros((self._along.count, self._across.count, channels + 1), np.float32)
        self._added = 0

    def add(self, values: Floats, opacity: Floats) -> None:
        """Add rows of `values` (n, W, channels) and of their `opacity` (n, W)."""
        weight = np.maximum(opacity, CLEAR)[..., None]
        rows = self._across.reduced(np.concatenate([values * weight, weight], -1))
        for row in rows:
            for target, share in self._along.of(self._added):
                self._sums[target] += row * share
            self._added += 1

    def level(self) -> tuple[Floats, Floats]:
        """Return values (h, w, channels) and opacity (h, w) of the new level."""
        weight = self._sums[..., -1]
        return self._sums[..., :-1] / weight[..., None], weight


def smaller_levels(halving: Halving) -> Iterator[tuple[Floats, Floats]]:
    """Yield values and opacity of the level that `halving` has made, and of all below it."""
    values, opacity = halving.level()
    yield values, opacity
    while opacity.size > 1:
        below = Halving(opacity.shape[1], opacity.shape[0], values.shape[-1])
        below.add(values, opacity)
        values, opacity = below.level()
        yield values, opacity


class _Taps:
    """How the texels of one side of a level share in those of the next."""

    __slots__ = ("_first", "_shares", "count")

    def __init__(self, size: int) -> None:
        self.count = max(1, size // 2)
        length = size / self.count
        begin = np.arange(self.count) * length
        self._first = np.floor(begin + 1e-9).astype(np.intp)
        taps = 1 if size == 1 else 2 if size % 2 == 0 else 3
        place = self._first[:, None] + np.arange(taps)
        overlap = np.minimum(place + 1, begin[:, None] + length) - np.maximum(place, begin[:, None])
        self._shares = (np.maximum(overlap, 0) / length).astype(np.float32)

    def reduced(self, rows: Floats) -> Floats:
        """Return `rows` (n, W, k) with the texels of a row reduced to half: (n, w, k)."""
        last = rows.shape[1] - 1
        total = np.zeros((len(rows), self.count, rows.shape[2]), np.float32)
        for tap, share in enumerate(self._shares.T):
            total += rows[:, np.minimum(self._first + tap, last)] * share[:, None]
        return total

    def of(self, place: int) -> Iterator[tuple[int, np.float32]]:
        """Yield the new texels that the texel at `place` shares in, and its share."""
        guess = min(self.count - 1, int(np.searchsorted(self._first, place, side="right")) - 1)
        for target in (guess - 1, guess):
            tap = place - self._first[target] if target >= 0 else -1
            if 0 <= tap < self._shares.shape[1] and self._shares[target, tap] > 0:
                yield target, self._shares[target, tap]
