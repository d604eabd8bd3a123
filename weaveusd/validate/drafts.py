"""The judge's own reader of the draft in an asset: WIF, as far as the weave needs it.

Makers read drafts with other code, which nothing here imports: the weave that was asked for and
the one that is shown are found by two ways.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bools = NDArray[np.bool_]

MAX_BYTES = 16 << 20
MAX_THREADS = 1 << 16
MAX_SHAFTS = 4096
MAX_CROSSINGS = 1 << 26

_SECTION = re.compile(r"\[(.+)\]\s*")
_NUMBER = re.compile(r"\d{1,9}", re.ASCII)

Sections = Mapping[str, Mapping[str, str]]


@dataclass(frozen=True, slots=True, eq=False)
class ReadDraft:
    """The weave of a draft, one repeat.

    `warp_up` is (picks, ends), row 0 the first pick, true where the warp is on top. `even` tells
    whether the draft spaces all its ends alike, and all its picks.
    """

    warp_up: Bools
    even: bool

    def repeated(self, ends: int, picks: int) -> Bools | None:
        """Return the weave over `picks` and `ends` that are whole repeats of it, else None."""
        own_picks, own_ends = self.warp_up.shape
        if ends % own_ends or picks % own_picks or ends * picks > MAX_CROSSINGS:
            return None
        return np.tile(self.warp_up, (picks // own_picks, ends // own_ends))


def read_draft(path: Path) -> ReadDraft:
    """Return the weave of the WIF file at `path`.

    Raises
    ------
    InputError
        When the file cannot be read, is larger than is read, or states no whole weave; the
        message does not name the file.
    """
    sections = _sections(path)
    ends = _count(sections, "WARP", "Threads", MAX_THREADS)
    picks = _count(sections, "WEFT", "Threads", MAX_THREADS)
    shafts = _count(sections, "WEAVING", "Shafts", MAX_SHAFTS)
    if ends * picks > MAX_CROSSINGS:
        raise InputError(f"{ends} ends and {picks} picks are more than are read")
    threading = _matrix(sections, "THREADING", ends, shafts)
    if "LIFTPLAN" in sections:
        raised = _matrix(sections, "LIFTPLAN", picks, shafts)
    else:
        treadles = _count(sections, "WEAVING", "Treadles", MAX_SHAFTS)
        tieup = _matrix(sections, "TIEUP", treadles, shafts)
        raised = _any_of(_matrix(sections, "TREADLING", picks, treadles), tieup)
    if sections["WEAVING"].get("rising shed", "true").lower() in ("false", "0", "no", "off"):
        raised = ~raised
    even = not any(f"{name} SPACING" in sections for name in ("WARP", "WEFT"))
    return ReadDraft(_any_of(raised, threading.T), even)


def _sections(path: Path) -> Sections:
    """Return the keys of every section, in lower case, by the section's name in upper case."""
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
        text = data.decode("utf-8")
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError("is not UTF-8") from None
    if len(data) > MAX_BYTES:
        raise InputError(f"is larger than {MAX_BYTES} bytes")
    sections: dict[str, dict[str, str]] = {}
    keys: dict[str, str] = {}
    for line in text.splitlines():
        if found := _SECTION.fullmatch(line):
            keys = sections.setdefault(found[1].strip().upper(), {})
        elif "=" in line and not line.startswith(";"):
            key, _, value = line.partition("=")
            keys[key.strip().lower()] = value.strip()
    return sections


def _count(sections: Sections, section: str, key: str, most: int) -> int:
    value = sections.get(section, {}).get(key.lower(), "")
    if not _NUMBER.fullmatch(value) or not 1 <= int(value) <= most:
        raise InputError(f"[{section}] has {key}={value!r}, expected 1 to {most}")
    return int(value)


def _matrix(sections: Sections, section: str, rows: int, columns: int) -> Bools:
    """Return (rows, columns): what each row of a section lists, counted from 1; 0 is nothing."""
    if section not in sections:
        raise InputError(f"has no section [{section}]")
    if rows * columns > MAX_CROSSINGS:
        raise InputError(f"[{section}] is larger than is read")
    matrix = np.zeros((rows, columns), np.bool_)
    for key, value in sections[section].items():
        row = _numbers(section, key, rows)
        places = [n for text in value.split(",") for n in _numbers(section, text, columns)]
        if len(row) != 1:
            raise InputError(f"[{section}] names row {key!r}, expected 1 to {rows}")
        matrix[row[0] - 1, [place - 1 for place in places]] = True
    return matrix


def _numbers(section: str, text: str, most: int) -> list[int]:
    """Return the number that `text` is, in a list that is empty for 0."""
    if not _NUMBER.fullmatch(text.strip()) or int(text) > most:
        raise InputError(f"[{section}] has {text!r}, expected 0 to {most}")
    return [int(text)] if int(text) else []


def _any_of(left: Bools, right: Bools) -> Bools:
    """Return (n, m): where some k has `left`, (n, k), and `right`, (k, m).

    Rows and columns that are alike, which is most of them in a draft, are worked out once.
    """
    rows, of_row = np.unique(left, axis=0, return_inverse=True)
    columns, of_column = np.unique(right, axis=1, return_inverse=True)
    both = np.zeros((len(rows), columns.shape[1]), np.bool_)
    for k in _used(rows):
        both |= rows[:, k, None] & columns[k]
    return both[of_row.reshape(-1)][:, of_column.reshape(-1)]


def _used(rows: Bools) -> Iterator[int]:
    return (int(k) for k in np.flatnonzero(rows.any(axis=0)))
