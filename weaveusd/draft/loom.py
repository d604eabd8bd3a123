"""Threading, tie-up, treadling and liftplan of a WIF as matrices over the shafts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft.numbering import Numbering
from weaveusd.draft.rows import Numbers, Rows
from weaveusd.errors import DraftError

if TYPE_CHECKING:
    from weaveusd.draft.model import Bools

MAX_THREADS = 2**20
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
    _check_cells(rows, "WEFT", "ends by picks", ends, picks)
    shafts = _shafts(rows, numbering)
    _check_cells(rows, "WEAVING", "ends by shafts", ends, shafts)
    _check_cells(rows, "WEAVING", "picks by shafts", picks, shafts)
    return Loom(ends, picks, shafts, numbering)


def read_threading(rows: Rows, loom: Loom) -> Bools:
    """Return the threading (ends, shafts); an end that is not listed is on no shaft."""
    if not (listed := rows.numbers("THREADING")):
        raise rows.error(0, "THREADING", "is missing or empty", "the shaft of each end")
    threading = _matrix(rows, "THREADING", listed, loom, loom.ends)
    idle = int((~threading.any(axis=1)).sum())
    if idle:
        rows.warn(0, "THREADING", f"{idle} of {loom.ends} ends are on no shaft; they stay down")
    return threading


def read_liftplan(rows: Rows, loom: Loom, threading: Bools) -> Bools:
    """Return the liftplan (picks, shafts), with tie-up and sinking shed resolved.

    Where a file has both a liftplan and a treadling with its tie-up, the treadling holds if it
    is complete.
    """
    lifted, treadled = rows.numbers("LIFTPLAN"), rows.numbers("TREADLING")
    if treadled and not rows.numbers("TIEUP"):
        if not lifted:
            raise rows.error(0, "TIEUP", "is missing or empty", "it beside [TREADLING]")
        rows.warn(0, "TIEUP", "is missing; [LIFTPLAN] is read instead of [TREADLING]")
        treadled = {}
    if not treadled and not lifted:
        raise rows.error(
            0, "TREADLING", "is missing or empty", "it beside [TIEUP], or a [LIFTPLAN]"
        )
    if treadled and lifted:
        up = _better_of_both(rows, loom, threading)
    elif treadled:
        up = _treadled(rows, loom)
    else:
        up = _matrix(rows, "LIFTPLAN", lifted, loom, loom.picks)
    return ~up if _sinking(rows, threading) else up


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


def _check_cells(rows: Rows, section: str, what: str, a: int, b: int) -> None:
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


def _matrix(rows: Rows, name: str, listed: Numbers, loom: Loom, count: int) -> Bools:
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
    _warn_beyond(rows, name, listed, first_row, count)
    matrix = np.zeros((count, loom.shafts), dtype=np.bool_)
    matrix[at[inside], on[inside]] = True
    return matrix


def _warn_beyond(rows: Rows, name: str, listed: Numbers, first_row: int, count: int) -> None:
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


def _treadled(rows: Rows, loom: Loom) -> Bools:
    """Return the liftplan that tie-up and treadling make: a pick lifts what its treadles do."""
    treadling = rows.numbers("TREADLING")
    treadles = _treadles(rows, loom)
    first_treadle = loom.numbering.first_value("TREADLING", treadles)
    first_pick = loom.numbering.first_row("TREADLING", loom.picks)
    _warn_beyond(rows, "TREADLING", treadling, first_pick, loom.picks)

    # Most picks press what another pressed: each different lift is made once.
    presses: dict[tuple[int, ...], int] = {(): 0}
    which = np.zeros(loom.picks, dtype=np.int64)
    for number, (line, pressed) in treadling.items():
        if pressed not in presses:
            if (top := max(pressed)) - first_treadle >= treadles:
                expected = f"at most {treadles - 1 + first_treadle}, all that the tie-up has"
                raise rows.error(line, "TREADLING", f"row {number} names treadle {top}", expected)
            presses[pressed] = len(presses)
        if 0 <= number - first_pick < loom.picks:
            which[number - first_pick] = presses[pressed]
    return _lifts(rows, loom, list(presses), first_treadle)[which]


def _treadles(rows: Rows, loom: Loom) -> int:
    """Return the number of treadles: those stated, or more where more are tied."""
    tieup = rows.numbers("TIEUP")
    stated = rows.count("WEAVING", "Treadles")
    treadles = max(max(tieup) + 1 - loom.numbering.first_row("TIEUP", stated), stated or 0)
    if stated is not None and treadles > stated:
        line = tieup[max(tieup)][0]
        rows.warn(line, "TIEUP", f"ties {treadles} treadles, but [WEAVING] states {stated}")
    return treadles


def _lifts(rows: Rows, loom: Loom, presses: list[tuple[int, ...]], first_treadle: int) -> Bools:
    """Return (presses, shafts): what the treadles of each press lift together."""
    tieup = rows.numbers("TIEUP")
    first_tied = loom.numbering.first_row("TIEUP", rows.count("WEAVING", "Treadles"))
    first_shaft = loom.numbering.first_value("TIEUP", loom.shafts)
    place: dict[int, int] = {}
    for treadle in {treadle for pressed in presses for treadle in pressed}:
        if treadle - first_treadle + first_tied in tieup and treadle >= first_treadle:
            place[treadle] = len(place)
    _check_cells(rows, "TIEUP", "treadles by shafts", max(1, len(place)), loom.shafts)
    tied = np.zeros((len(place), loom.shafts), dtype=np.bool_)
    for treadle, row in place.items():
        shafts = np.array(tieup[treadle - first_treadle + first_tied][1], dtype=np.int64)
        tied[row, shafts[shafts >= first_shaft] - first_shaft] = True
    packed = np.packbits(tied, axis=1)
    lifted = np.zeros((len(presses), packed.shape[1]), dtype=np.uint8)
    for n, pressed in enumerate(presses):
        if some := sorted({place[treadle] for treadle in pressed if treadle in place}):
            lifted[n] = np.bitwise_or.reduce(packed[some], axis=0)
    return np.unpackbits(lifted, axis=1, count=loom.shafts).astype(np.bool_)


def _better_of_both(rows: Rows, loom: Loom, threading: Bools) -> Bools:
    """Return the liftplan of a file that has a treadling with tie-up as well.

    The treadling holds when it presses something on every pick, or lifts something on as many
    picks as the liftplan; a treadling that cannot be read gives way.
    """
    lifted = _matrix(rows, "LIFTPLAN", rows.numbers("LIFTPLAN"), loom, loom.picks)
    try:
        treadled = _treadled(rows, loom)
    except DraftError as fault:
        rows.warn(0, "TREADLING", f"gives way to [LIFTPLAN]: {fault}")
        return lifted
    pressed = sum(any(numbers) for _, numbers in rows.numbers("TREADLING").values())
    complete = pressed >= loom.picks and bool(treadled.any())
    if complete or treadled.any(axis=1).sum() >= lifted.any(axis=1).sum():
        taken, up = "[TREADLING]", treadled
    else:
        taken, up = "[LIFTPLAN], which lifts on more picks,", lifted
    used = threading.any(axis=0)
    if (lifted != treadled)[:, used].any():
        rows.warn(0, "LIFTPLAN", f"and [TREADLING] weave different cloths; {taken} holds")
    return up


def _sinking(rows: Rows, threading: Bools) -> bool:
    rising = rows.boolean("WEAVING", "Rising Shed")
    if rising is None:
        rows.warn(0, "WEAVING", "does not say whether the shed rises; read as rising")
    if rising is False and (threading.sum(axis=1) > 1).any():
        rows.warn(0, "WEAVING", "the shed sinks: an end on several shafts is up with any of them")
    return rising is False
