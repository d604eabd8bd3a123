"""Floats: maximal cyclic runs of crossings in which a thread is on top."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft.statistics import float_lengths

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bools = NDArray[np.bool_]
    Indices = NDArray[np.int32]


def cyclic_runs(on_top: Bools) -> tuple[Indices, Indices, Indices, Indices]:
    """Return the cyclic runs of True along each row of `on_top` (threads, crossings).

    Runs wrap around the end of a row; a row that is True everywhere is one run that starts at
    0. Physics.md B.

    Returns
    -------
    thread, start, count : (F,) int32
        Row, first crossing and length of each run, ordered by row, then by start.
    at : (threads, crossings) int32
        The run that each True crossing belongs to, -1 where False.
    """
    threads, crossings = on_top.shape
    starts = on_top & ~np.roll(on_top, 1, axis=1)
    closed = on_top.all(axis=1)
    starts[closed, 0] = True
    thread, start = (a.astype(np.int32) for a in np.nonzero(starts))

    # A run's number is that of the last start at or before it; a wrapped head takes the row's last.
    number = np.cumsum(starts.ravel(), dtype=np.int32).reshape(threads, crossings) - 1
    last_of_row = number[:, -1]
    first_of_row = np.concatenate([[0], last_of_row[:-1] + 1]).astype(np.int32)
    at = np.where(number < first_of_row[:, None], last_of_row[:, None], number)
    at = np.where(on_top, at, np.int32(-1)).astype(np.int32)
    count = np.bincount(at[on_top], minlength=len(thread)).astype(np.int32)
    return thread, start, count, at


def longest_float(warp_up: Bools) -> int:
    """Return the longest cyclic float of either face of a drawdown (picks, ends), in threads."""
    lengths = [*float_lengths(warp_up.T), *float_lengths(warp_up)]
    return max(int(found.max(initial=0)) for found in lengths)
