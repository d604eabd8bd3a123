"""Drafts from threading, tie-up and treadling as a weaver writes them down."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft.defaults import default_palette
from weaveusd.draft.loom import MAX_CELLS
from weaveusd.draft.model import Draft
from weaveusd.draft.text import quoted
from weaveusd.errors import DraftError

if TYPE_CHECKING:
    from weaveusd.draft.model import Bools

MAX_THREADS = 2**14
MAX_NUMBER = 1024
MAX_TEXT = 2**16

Places = list[tuple[int, ...]]
"""For each thread or treadle the shafts or treadles, counted from 1."""

_TOKEN = re.compile(r"\s*(?:([0-9+]+)(?:-([0-9]+))?|([(),])|([*x][0-9]+))")


def from_threading(threading: str, tieup: str, treadling: str, *, title: str = "") -> Draft:
    """Return the draft that three strings describe.

    Each is a list of numbers from 1, set apart by blanks or commas. `1+3` is an end on two
    shafts, a treadle tied to two, or a pick that presses two; 0 is none. `1-4` counts up,
    `4-1` down; `(1 2 3 2)*3` repeats, and groups nest. An overshot of four shafts:
    ``from_threading("(1 2)*3 (2 3)*2 3 4 1 4", "1+2 2+3 3+4 4+1 1+3 2+4", "(1 5 1 6)*2 2 5 2 6")``

    The loom has as many shafts as the highest that an end is on or a treadle lifts.

    Raises
    ------
    DraftError
        When a string is not of that form, is too long, or names a treadle without tie-up.
    """
    ends = parse_places(threading, "threading")
    tied = parse_places(tieup, "tie-up")
    pressed = parse_places(treadling, "treadling")
    if (top := max(max(treadles) for treadles in pressed)) > len(tied):
        raise DraftError(f"treadling: found treadle {top}; expected at most {len(tied)}, all tied")
    if len(ends) * len(pressed) > MAX_CELLS:
        raise DraftError(
            f"threading: found {len(ends)} ends by {len(pressed)} picks; expected a product up "
            f"to {MAX_CELLS}"
        )
    shafts = max(1, *(max(places) for places in (*ends, *tied)))
    lifts = _matrix(tied, shafts)
    presses = _matrix(pressed, len(tied))
    return Draft(
        threading=_matrix(ends, shafts),
        liftplan=presses.astype(np.float32) @ lifts.astype(np.float32) > 0.5,
        warp_color=np.zeros(len(ends), dtype=np.int32),
        weft_color=np.ones(len(pressed), dtype=np.int32),
        palette=default_palette(),
        title=title,
    )


def parse_places(text: str, what: str) -> Places:
    """Return the list of places in `text`; `what` stands for it in messages.

    Raises
    ------
    DraftError
        When the text is empty, malformed or too long.
    """
    if len(text) > MAX_TEXT:
        raise DraftError(f"{what}: found {len(text)} characters; expected at most {MAX_TEXT}")
    groups: list[Places] = [[]]
    last: Places = []  # what a repetition would repeat
    at = 0
    text = text.rstrip()
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise _malformed(what, text, at)
        number, to, mark, times = match.groups()
        if number is not None:
            last = _span(what, number, to)
            groups[-1] += last
        elif mark == "(":
            groups.append([])
            last = []
        elif mark == ")":
            if len(groups) == 1:
                raise _malformed(what, text, at)
            last = groups.pop()
            groups[-1] += last
        elif times is not None:
            count = int(times[1:]) if len(times) < 7 else MAX_THREADS + 1
            if not last or count == 0:
                raise _malformed(what, text, at)
            if len(last) * (count - 1) + len(groups[-1]) > MAX_THREADS:
                raise DraftError(f"{what}: found more than {MAX_THREADS} places; expected fewer")
            groups[-1] += last * (count - 1)
            last = []
        at = match.end()
        if len(groups[-1]) > MAX_THREADS:
            raise DraftError(f"{what}: found more than {MAX_THREADS} places; expected fewer")
    if len(groups) > 1 or not groups[0]:
        raise _malformed(what, text, len(text))
    return groups[0]


def _span(what: str, number: str, to: str | None) -> Places:
    """Return one place, or those that a range counts."""
    parts = number.split("+")
    if not all(part.isdigit() and len(part) < 6 for part in (*parts, to or "0")):
        raise DraftError(f"{what}: found {quoted(number)}; expected numbers joined by +")
    places = [int(part) for part in parts]
    if max(*places, int(to or 0)) > MAX_NUMBER or (to is not None and len(places) > 1):
        raise DraftError(f"{what}: found {quoted(number)}; expected a number up to {MAX_NUMBER}")
    if to is None:
        return [tuple(places)]
    step = 1 if int(to) >= places[0] else -1
    return [(n,) for n in range(places[0], int(to) + step, step)]


def _malformed(what: str, text: str, at: int) -> DraftError:
    found = quoted(text[at : at + 12]) if at < len(text) else "its end"
    return DraftError(
        f"{what}: found {found} at character {at + 1}; expected a list like '1-4 3 2'"
    )


def _matrix(places: Places, count: int) -> Bools:
    matrix = np.zeros((len(places), count), dtype=np.bool_)
    for row, numbers in enumerate(places):
        for number in numbers:
            if number:
                matrix[row, number - 1] = True
    return matrix
