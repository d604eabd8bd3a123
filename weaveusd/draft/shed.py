"""The shed of each pick of a WIF: tie-up and treadling, or a liftplan."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft.loom import Loom, check_cells, matrix_of, warn_beyond
from weaveusd.draft.rows import Rows
from weaveusd.errors import DraftError

if TYPE_CHECKING:
    from weaveusd.draft.model import Bools


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
        up = matrix_of(rows, "LIFTPLAN", lifted, loom, loom.picks)
    return ~up if _sinking(rows, threading) else up


def _treadled(rows: Rows, loom: Loom) -> Bools:
    """Return the liftplan that tie-up and treadling make: a pick lifts what its treadles do."""
    treadling = rows.numbers("TREADLING")
    treadles = _treadles(rows, loom)
    first_treadle = loom.numbering.first_value("TREADLING", treadles)
    first_pick = loom.numbering.first_row("TREADLING", loom.picks)
    warn_beyond(rows, "TREADLING", treadling, first_pick, loom.picks)

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
    check_cells(rows, "TIEUP", "treadles by shafts", max(1, len(place)), loom.shafts)
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
    lifted = matrix_of(rows, "LIFTPLAN", rows.numbers("LIFTPLAN"), loom, loom.picks)
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
