"""Writing a draft as WIF 1.1: the same bytes for the same draft, and no field unasked for."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft.lengths import PLACEHOLDER_MM
from weaveusd.draft.loom import MAX_SHAFTS, MAX_THREADS
from weaveusd.draft.model import Draft
from weaveusd.draft.scan import MAX_BYTES, MAX_LINE, MAX_LINES
from weaveusd.errors import DraftError

if TYPE_CHECKING:
    from weaveusd.draft.model import Bools, Doubles, Indices

TREADLES = 32
"""A draft of at most so many shafts and different picks is written with a tie-up."""

_USUAL_RANGES = (255, 999, 65535)
_RARE_RANGES = range(1, 4096)

Sections = list[tuple[str, list[str]]]


def write_wif(draft: Draft, personal: Mapping[str, str] | None = None) -> bytes:
    """Return the draft as the bytes of a WIF 1.1 in UTF-8, which `parse_wif` reads back equal.

    Tie-up and treadling are written for up to 32 shafts and as many different picks, one
    treadle for each; a liftplan otherwise. Lengths are in centimeters. The range of the palette
    is the first of 0–255, 0–999 and 0–65535 that holds all colors exactly, or one that does.
    There is no date: the same draft gives the same bytes. `personal` are fields of the section
    TEXT beside the title, such as `personal_fields` returns; a draft has none.

    Raises
    ------
    DraftError
        When the draft is too large for the reader's limits: a large jacquard has no WIF.
    """
    sections: Sections = []
    text = {"Title": draft.title, **(personal or {})}
    if any(text.values()):
        sections.append(("TEXT", [f"{key}={value}" for key, value in text.items() if value]))
    if draft.notes:
        sections.append(("NOTES", list(_rows(draft.notes.split("\n")))))
    shed, treadles = _shed(draft.liftplan)
    loom = ["Rising Shed=true", f"Shafts={draft.shafts}", f"Treadles={treadles}"]
    sections.append(("WEAVING", loom))
    high, table = _colors(draft.palette)
    sections.append(("COLOR PALETTE", [f"Entries={len(table)}", f"Range=0,{high}"]))
    sections.append(("COLOR TABLE", list(_rows(",".join(map(str, c)) for c in table))))
    sections += _system("WARP", draft.warp_color, draft.warp_pitch_mm, draft.warp_thickness_mm)
    sections += _system("WEFT", draft.weft_color, draft.weft_pitch_mm, draft.weft_thickness_mm)
    sections.append(("THREADING", list(_rows(_lists(draft.threading)))))
    sections += shed
    return _join(draft, sections)


def _rows(values: Iterable[str]) -> Iterator[str]:
    return (f"{n}={value}" for n, value in enumerate(values, 1))


def _lists(matrix: Bools) -> Iterator[str]:
    """Return for each row the numbers, from 1, of what is true in it; 0 for nothing."""
    return (",".join(map(str, np.flatnonzero(row) + 1)) or "0" for row in matrix)


def _shed(liftplan: Bools) -> tuple[Sections, int]:
    """Return tie-up and treadling, or the liftplan, and the number of treadles."""
    treadle: dict[bytes, int] = {}
    pressed = [treadle.setdefault(row.tobytes(), len(treadle) + 1) for row in liftplan]
    shafts = liftplan.shape[1]
    if shafts > TREADLES or len(treadle) > TREADLES:
        return [("LIFTPLAN", list(_rows(_lists(liftplan))))], shafts
    tied = np.array([np.frombuffer(row, dtype=np.bool_) for row in treadle])
    return [
        ("TIEUP", list(_rows(_lists(tied)))),
        ("TREADLING", list(_rows(map(str, pressed)))),
    ], len(treadle)


def _system(
    name: str, color: Indices, pitch: Doubles | None, thickness: Doubles | None
) -> Sections:
    """Return the section of a system of threads, and those for its single threads."""
    entries = (color + 1).tolist()
    usual = Counter(entries).most_common(1)[0][0]
    head = [f"Threads={len(entries)}", f"Color={usual}"]
    single: Sections = []
    if any(entry != usual for entry in entries):
        single.append((f"{name} COLORS", list(_rows(map(str, entries)))))
    if pitch is not None or thickness is not None:
        head.append("Units=Centimeters")
    placeholder = (_only(pitch), _only(thickness)) == PLACEHOLDER_MM
    for key, lengths in (("Spacing", pitch), ("Thickness", thickness)):
        if lengths is None:
            continue
        values = lengths.tolist()
        usual = Counter(values).most_common(1)[0][0]
        head.append(f"{key}={_centimeters(usual)}")
        # One row shows that a pair which elsewhere is a placeholder is meant.
        rows = [
            f"{n}={_centimeters(value)}"
            for n, value in enumerate(values, 1)
            if value != usual or (placeholder and n == 1)
        ]
        if rows:
            single.append((f"{name} {key.upper()}", rows))
    return [(name, head), *single]


def _only(lengths: Doubles | None) -> float | None:
    """Return the one length that all threads have, else None."""
    if lengths is None or (lengths != lengths[0]).any():
        return None
    return float(lengths[0])


def _centimeters(length_mm: float) -> str:
    """Return a length in mm as centimeters, by moving the decimal point: nothing is rounded."""
    return format(Decimal(repr(length_mm)).scaleb(-1), "f")


def _colors(palette: Doubles) -> tuple[int, list[tuple[int, ...]]]:
    """Return the highest component and the colors as whole numbers up to it, exactly."""
    for high in (*_USUAL_RANGES, *_RARE_RANGES):
        whole = np.rint(palette * high)
        if np.array_equal(whole / high, palette):
            return high, [tuple(color) for color in whole.astype(np.int64).tolist()]
    exact = [[Fraction(c) for c in color] for color in palette.tolist()]
    high = max(c.denominator for color in exact for c in color)  # all are powers of two
    return high, [tuple(int(c * high) for c in color) for color in exact]


def _join(draft: Draft, sections: Sections) -> bytes:
    head = ["[WIF]", "Version=1.1", "Source Program=weaveusd"]
    contents = ["", "[CONTENTS]", *(f"{name}=true" for name, _ in sections)]
    lines = head + contents
    for name, rows in sections:
        lines += ["", f"[{name}]", *rows]
    data = "\n".join([*lines, ""]).encode()
    if (
        len(data) > MAX_BYTES
        or len(lines) >= MAX_LINES
        or max(map(len, lines)) > MAX_LINE
        or draft.shafts > MAX_SHAFTS
        or max(draft.ends, draft.picks) > MAX_THREADS
    ):
        raise DraftError(
            f"the draft of {draft.ends} ends, {draft.picks} picks and {draft.shafts} shafts takes "
            f"{len(data)} bytes as WIF; expected at most {MAX_BYTES}, and {MAX_LINE} a line"
        )
    return data
