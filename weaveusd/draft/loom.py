"""The loom of a WIF: how many threads and shafts, how they are counted, and the threading."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft.numbering import Numbering
from weaveusd.draft.rows import Numbers, Rows

if TYPE_CHECKING:
    from weaveusd.draft.model import Bools

MAX_THREADS = 2**20
MAX_SHAFTS = 2**16
MAX_CELLS = 2**26


@dataclass(frozen=True, slots=True)
class Loom:
    """Ends, picks and shafts, and how a file counts them."""

    ends: int
    picks: int
    shafts: int
    numbering: Numbering


def read_loom(rows: Rows) -> Loom:
    """Return the loom that the file describes, its size checked before memory is taken."""
    numbering = Numbering(rows)
    ends = _threads(rows, numbering, "WARP", ("THREADING",))
    picks = _threads(rows, numbering, "WEFT", ("TREADLING", "LIFTPLAN"))
    check_cells(rows, "WEFT", "ends by picks", ends, picks)
    shafts = _shafts(rows, numbering)
    if shafts > MAX_SHAFTS:
        raise rows.error(0, "WEAVING", f"found {shafts} shafts", f"at most {MAX_SHAFTS}")
    check_cells(rows, "WEAVING", "ends by shafts", ends, shafts)
    check_cells(rows, "WEAVING", "picks by shafts", picks, shafts)
    return Loom(ends, picks, shafts, numbering)


def read_threading(rows: Rows, loom: Loom) -> Bools:
    """Return the threading (ends, shafts); an end that is not listed is on no shaft."""
    if not (listed := rows.numbers("THREADING")):
        raise rows.error(0, "THREADING", "is missing or empty", "the shaft of each end")
    threading = matrix_of(rows, "THREADING", listed, loom, loom.ends)
    idle = int((~threading.any(axis=1)).sum())
    if idle:
        rows.warn(0, "THREADING", f"{idle} of {loom.ends} ends are on no shaft; they stay down")
    return threading


def _threads(rows: Rows, numbering: Numbering, system: str, lists: tuple[str, ...]) -> int:
    """Return the number of ends or picks, as stated or else as listed."""
    count = rows.count(system, "Threads")
    if count is None:
        count = max(
            (
                max(listed) + 1 - numbering.first_row(name, None)
                for name in lists
                if (listed := rows.numbers(name))
            ),
            default=0,
        )
        if count < 1:
            expected = f"Threads, or rows in {' or '.join(f'[{n}]' for n in lists)}"
            raise rows.error(0, system, "states no number of threads", expected)
        rows.warn(0, system, f"states no Threads; {count} are taken from the rows listed")
    if count > MAX_THREADS:
        line = (rows.value(system, "Threads") or (0, ""))[0]
        raise rows.error(line, system, f"found {count} threads", f"at most {MAX_THREADS}")
    return count


def check_cells(rows: Rows, section: str, what: str, a: int, b: int) -> None:
    """Raise a `DraftError` unless a matrix of a × b cells is one that memory is taken for."""
    if a * b > MAX_CELLS:
        raise rows.error(0, section, f"found {a} × {b} {what}", f"a product up to {MAX_CELLS}")


def _shafts(rows: Rows, numbering: Numbering) -> int:
    """Return the number of shafts: those stated, or more where some are lifted beyond them."""
    stated = rows.count("WEAVING", "Shafts")
    tops = {
        name: _top(rows.numbers(name), numbering.first_value(name, stated))
        for name in ("TIEUP", "LIFTPLAN", "THREADING")
    }
    lifted = max(tops["TIEUP"][0], tops["LIFTPLAN"][0])
    if stated is None:
        shafts = max(lifted, tops["THREADING"][0], 1)
        rows.warn(0, "WEAVING", f"states no Shafts; {shafts} are in use")
        return shafts
    for name in ("TIEUP", "LIFTPLAN"):
        if tops[name][0] > stated:
            rows.warn(
                tops[name][1],
                name,
                f"lifts shaft {tops[name][0]}, but [WEAVING] states {stated}; the loom has "
                f"{lifted}",
            )
    shafts = max(stated, lifted)
    top, line = tops["THREADING"]
    if top > shafts:
        raise rows.error(
            line, "THREADING", f"names shaft {top}", f"at most {shafts}, all that the loom has"
        )
    return shafts


def _top(listed: Numbers, first: int) -> tuple[int, int]:
    """Return the highest number listed, counted from 1, and its line."""
    return max(
        ((max(numbers) + 1 - first, line) for line, numbers in listed.values() if numbers),
        default=(0, 0),
        key=lambda top: top[0],
    )


def matrix_of(rows: Rows, name: str, listed: Numbers, loom: Loom, count: int) -> Bools:
    """Return (count, shafts), True where a row of section `name` names the shaft."""
    first_row = loom.numbering.first_row(name, count)
    first_shaft = loom.numbering.first_value(name, loom.shafts)
    row: list[int] = []
    shaft: list[int] = []
    for number, (_, numbers) in listed.items():
        row.extend([number] * len(numbers))
        shaft.extend(numbers)
    at = np.array(row, dtype=np.int64) - first_row
    on = np.array(shaft, dtype=np.int64) - first_shaft
    inside = (at >= 0) & (at < count) & (on >= 0)
    warn_beyond(rows, name, listed, first_row, count)
    matrix = np.zeros((count, loom.shafts), dtype=np.bool_)
    matrix[at[inside], on[inside]] = True
    return matrix


def warn_beyond(rows: Rows, name: str, listed: Numbers, first_row: int, count: int) -> None:
    """Warn of the rows of a section that belong to none of `count` threads."""
    beyond = [
        (line, number)
        for number, (line, _) in listed.items()
        if not 0 <= number - first_row < count
    ]
    if beyond:
        line, number = beyond[0]
        rows.warn(
            line, name, f"row {number} is not one of {count} threads; {len(beyond)} rows ignored"
        )
