"""Counts: how mills say how thick a yarn is, as tex and plies."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

UNITS: dict[str, Callable[[float], float]] = {
    "tex": lambda count: count,
    "denier": lambda count: count / 9,
    "Ne": lambda count: 590.541 / count,
    "Nm": lambda count: 1000 / count,
    "lea": lambda count: 1653.515 / count,
}
"""Tex of a count in each unit: g/km; g per 9 km; hanks of 840 yd to the pound (cotton); km to the
kilogram; leas of 300 yd to the pound (linen)."""

DIRECT = ("tex", "denier")
"""Units that weigh a length; the others measure the length of a weight."""

TEX_LIMITS = (0.1, 100_000.0)
MAX_PLIES = 16

_NUMBER = r"([0-9]{1,6}(?:\.[0-9]{1,6})?)"
_UNIT = r"(tex|denier|den|Ne|Nm|lea)"
_PAIR = rf"{_NUMBER}(?:\s*/\s*{_NUMBER})?"
_UNIT_LAST = re.compile(rf"{_PAIR}\s*{_UNIT}(?:\s*[x×]\s*(\d{{1,2}}))?")
_UNIT_FIRST = re.compile(rf"{_UNIT}\s*{_PAIR}")
_RESULTANT = re.compile(rf"R\s*{_NUMBER}\s*tex\s*/\s*(\d{{1,2}})")


@dataclass(frozen=True, slots=True)
class Count:
    """A count: linear density of the whole yarn in g/km, and its plies, None where not said."""

    tex: float
    plies: int | None = None


def parse_count(text: str) -> Count:
    """Return what a mill's `text` says of a yarn, the count being that of each single.

    ``60 Nm``, ``Nm 60`` and ``42 denier`` say nothing of plies: the count is the whole yarn's.
    ``2/60 Nm`` and ``10/2 Ne`` are two singles of 60 Nm and of 10 Ne: the smaller number is the
    plies, whichever comes first. ``16.5 tex x 2`` is two singles of 16.5 tex, and ``R 33 tex/2``
    a yarn of two singles that is 33 tex as a whole.

    Raises ValueError, with what was found and expected, for anything else: also for ``3/4 Ne``,
    which could mean either, and ``75/36 denier``, which counts filaments.
    """
    text = text.strip()
    if match := _RESULTANT.fullmatch(text):
        return Count(_within(float(match[1]), text), _plies(float(match[2]), text))
    if match := _UNIT_LAST.fullmatch(text):
        first, second, unit, times = match.groups()
    elif match := _UNIT_FIRST.fullmatch(text):
        unit, first, second = match.groups()
        times = None
    else:
        expected = 'a count like "42 denier", "2/60 Nm", "Ne 10/2", "16.5 tex x 2", "R 33 tex/2"'
        raise ValueError(f"found {text!r:.60}, expected {expected}")
    unit = "denier" if unit == "den" else unit
    if second is None:
        plies = None if times is None else _plies(float(times), text)
        return Count(_within(tex_of(float(first), unit) * (plies or 1), text), plies)
    return _plied(float(first), float(second), unit, text, times)


def tex_of(count: float, unit: str) -> float:
    """Return the g/km of a `count` in one of `UNITS`; raises ValueError for none above 0."""
    if not count > 0:
        raise ValueError(f"found {count:g} {unit}, expected a count above 0")
    return UNITS[unit](count)


def count_limits(unit: str) -> tuple[float, float]:
    """Return the counts in one of `UNITS` at `TEX_LIMITS`, the smaller first."""
    low, high = TEX_LIMITS
    if unit in DIRECT:
        per_tex = 1 / UNITS[unit](1)
        return low * per_tex, high * per_tex
    return UNITS[unit](high), UNITS[unit](low)


def _plied(first: float, second: float, unit: str, text: str, times: str | None) -> Count:
    if unit in DIRECT or times is not None:
        expected = f'the plies of {unit} as "84 {unit} x 2"'
        raise ValueError(f"found {text!r}, expected {expected}")
    plies, single = sorted((first, second))
    if single < 2 * plies:
        expected = "one number at least twice the other, or the count and `plies` apart"
        raise ValueError(f"found {text!r}, expected {expected}")
    whole = _plies(plies, text)
    return Count(_within(tex_of(single, unit) * whole, text), whole)


def _plies(number: float, text: str) -> int:
    if number != int(number) or not 1 <= number <= MAX_PLIES:
        raise ValueError(f"found {number:g} plies in {text!r}, expected 1 to {MAX_PLIES}")
    return int(number)


def _within(tex: float, text: str) -> float:
    low, high = TEX_LIMITS
    if not low <= tex <= high:
        raise ValueError(f"found {text}, that is {tex:.4g} tex, expected {low:g} to {high:g} tex")
    return tex
