"""Rows of texels shared out among threads."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

SHARES = 4
"""Pieces of work a thread, so that one that is held up does not hold up the others."""


def thread_count(jobs: int | None) -> int:
    """Return how many threads `jobs` means: itself, or one for each core where it is None.

    Raises ValueError for fewer than one.
    """
    if jobs is None:
        return len(os.sched_getaffinity(0))
    if jobs < 1:
        raise ValueError(f"{jobs} jobs, expected at least 1")
    return jobs


def share_out(work: Callable[[int, int], None], rows: int, jobs: int) -> None:
    """Call `work` with the first row and the one behind the last, so that `rows` are all done.

    Calls run side by side on `jobs` threads; `work` must not hold Python's lock to gain by it.
    """
    size = -(-rows // (SHARES * jobs)) if jobs > 1 else rows
    firsts = range(0, rows, max(1, size))
    if len(firsts) <= 1:
        work(0, rows)
        return
    with ThreadPoolExecutor(jobs) as pool:
        for _ in pool.map(lambda first: work(first, min(rows, first + size)), firsts):
            pass
