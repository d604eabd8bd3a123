"""Drafts from a notation of one word: `plain`, `twill:2/2:Z`, `satin:5:2`, `tartan:K4 R24`."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft import weaves
from weaveusd.draft.defaults import DEFAULT_COLORS, palette_of
from weaveusd.draft.model import Draft
from weaveusd.draft.resolve import from_drawdown
from weaveusd.draft.sett import TARTAN_COLORS, parse_sett
from weaveusd.draft.text import quoted
from weaveusd.errors import DraftError

if TYPE_CHECKING:
    from weaveusd.draft.model import Bools, Doubles

MAX_THREADS = 1024
"""Longest run, stripe or repeat that a notation may ask for."""

_COLORS = re.compile(r"([0-9a-fA-F]{6}),([0-9a-fA-F]{6})")
_TITLES = {
    "basket": "Basket", "diamond": "Diamond twill", "herringbone": "Herringbone",
    "honeycomb": "Honeycomb", "houndstooth": "Houndstooth", "plain": "Plain",
    "pointed": "Pointed twill", "sateen": "Sateen", "satin": "Satin", "tartan": "Tartan",
    "twill": "Twill", "waffle": "Waffle",
}  # fmt: skip


def make_draft(notation: str) -> Draft:
    """Return the draft of one repeat that the notation names.

    The notation is `NAME[:ARGUMENT…][@WARP,WEFT]` with colors as six hexadecimal digits of
    display sRGB::

        plain                   basket:ENDS[/PICKS]     honeycomb:SHAFTS (also waffle)
        twill:UP/DOWN…[:S|Z]    herringbone:UP/DOWN…[:ENDS]
        pointed:UP/DOWN…        diamond:UP/DOWN…
        satin:SHAFTS:STEP       sateen:SHAFTS:STEP      (warp- and weft-faced)
        houndstooth[:ENDS]      tartan:SETT             a sett as `parse_sett` reads it

    Raises
    ------
    DraftError
        When the notation names no weave, or one that cannot be woven.
    """
    weave, _, colors = notation.partition("@")
    name, *arguments = (part.strip() for part in weave.split(":"))
    name = name.lower()
    if name == "tartan":
        return _tartan(notation, arguments, colors)
    if name not in _WEAVES:
        known = ", ".join(sorted([*_WEAVES, "tartan"]))
        raise _error(notation, f"weave {quoted(name)}", f"one of {known}")
    up = _WEAVES[name](notation, arguments)
    palette = _palette(notation, colors)
    warp = np.zeros(up.shape[1], dtype=np.int32)
    weft = np.ones(up.shape[0], dtype=np.int32)
    if name == "houndstooth":
        group = _group(notation, arguments)
        up = weaves.tiled(up, 2 * group, 2 * group)
        warp = (np.arange(up.shape[1]) // group % 2).astype(np.int32)
        weft = (np.arange(up.shape[0]) // group % 2).astype(np.int32)
    title = " ".join([_TITLES[name], *arguments])
    return from_drawdown(up, warp, weft, palette, title=title)


def _error(notation: str, found: str, expected: str) -> DraftError:
    return DraftError(f"notation {quoted(notation)}: found {found}; expected {expected}")


def _arguments(notation: str, arguments: list[str], least: int, most: int) -> list[str]:
    if not least <= len(arguments) <= most:
        expected = f"{least}" if least == most else f"{least} to {most}"
        raise _error(notation, f"{len(arguments)} arguments", expected)
    return arguments


def _count(notation: str, text: str, least: int = 1) -> int:
    """Return the whole number in `text`, from `least` to `MAX_THREADS`."""
    if not (text.isascii() and text.isdigit() and len(text) < 6):
        raise _error(notation, quoted(text), "a whole number")
    if not least <= (count := int(text)) <= MAX_THREADS:
        raise _error(notation, f"{count}", f"a number from {least} to {MAX_THREADS}")
    return count


def _steps(notation: str, text: str) -> weaves.Steps:
    steps = tuple(_count(notation, part) for part in text.split("/"))
    if len(steps) % 2 or sum(steps) > MAX_THREADS:
        raise _error(notation, quoted(text), "ends up and down in turn, as 2/2 or 3/1/1/2")
    return steps


def _plain(notation: str, arguments: list[str]) -> Bools:
    _arguments(notation, arguments, 0, 0)
    return weaves.plain()


def _twill(notation: str, arguments: list[str]) -> Bools:
    steps, *rest = _arguments(notation, arguments, 1, 2)
    direction = rest[0].upper() if rest else "Z"
    if direction == "Z":
        return weaves.twill(_steps(notation, steps), "Z")
    if direction == "S":
        return weaves.twill(_steps(notation, steps), "S")
    raise _error(notation, f"direction {quoted(direction)}", "S or Z")


def _herringbone(notation: str, arguments: list[str]) -> Bools:
    text, *rest = _arguments(notation, arguments, 1, 2)
    steps = _steps(notation, text)
    if sum(steps[0::2]) != sum(steps[1::2]):
        raise _error(notation, quoted(text), "as many ends up as down, since stripes invert")
    ends = _count(notation, rest[0], 2) if rest else 2 * sum(steps)
    return weaves.herringbone(steps, ends)


def _pointed(notation: str, arguments: list[str]) -> Bools:
    return weaves.pointed(_steps(notation, _arguments(notation, arguments, 1, 1)[0]))


def _diamond(notation: str, arguments: list[str]) -> Bools:
    return weaves.diamond(_steps(notation, _arguments(notation, arguments, 1, 1)[0]))


def _satin(notation: str, arguments: list[str]) -> Bools:
    shafts, step = (_count(notation, a) for a in _arguments(notation, arguments, 2, 2))
    try:
        return weaves.satin(shafts, step)
    except ValueError as error:
        raise _error(
            notation, str(error), "a step from 2 to shafts - 2 without a common divisor"
        ) from error


def _sateen(notation: str, arguments: list[str]) -> Bools:
    return ~_satin(notation, arguments)


def _basket(notation: str, arguments: list[str]) -> Bools:
    parts = _arguments(notation, arguments, 1, 1)[0].split("/")
    counts = [_count(notation, part) for part in parts]
    if len(counts) > 2:
        raise _error(notation, f"{len(counts)} numbers", "ENDS or ENDS/PICKS")
    return weaves.basket(counts[0], counts[-1])


def _honeycomb(notation: str, arguments: list[str]) -> Bools:
    return weaves.honeycomb(_count(notation, _arguments(notation, arguments, 1, 1)[0], 4))


def _group(notation: str, arguments: list[str]) -> int:
    return _count(notation, _arguments(notation, arguments, 0, 1)[0]) if arguments else 4


def _houndstooth(notation: str, arguments: list[str]) -> Bools:
    _group(notation, arguments)
    return weaves.twill((2, 2))


_WEAVES: dict[str, Callable[[str, list[str]], Bools]] = {
    "basket": _basket,
    "diamond": _diamond,
    "herringbone": _herringbone,
    "honeycomb": _honeycomb,
    "houndstooth": _houndstooth,
    "plain": _plain,
    "pointed": _pointed,
    "sateen": _sateen,
    "satin": _satin,
    "twill": _twill,
    "waffle": _honeycomb,
}


def _palette(notation: str, colors: str) -> Doubles:
    """Return the two colors of the notation, or the usual ones, as (2, 3) in 0…1."""
    pair: tuple[str, ...] = DEFAULT_COLORS
    if "@" in notation:
        match = _COLORS.fullmatch(colors.strip())
        if match is None:
            raise _error(notation, f"colors {quoted(colors)}", "@RRGGBB,RRGGBB")
        pair = match.groups()
    return palette_of(*pair)


def _tartan(notation: str, arguments: list[str], colors: str) -> Draft:
    if "@" in notation:
        raise _error(notation, f"colors {quoted(colors)}", "those of the sett")
    sett = _arguments(notation, arguments, 1, 1)[0]
    try:
        stripes = parse_sett(sett)
    except ValueError as error:
        raise _error(notation, str(error), "a sett like 'K/4 R24 G12 Y/2'") from error
    names = sorted({color for color, _ in stripes})
    threads = np.array([names.index(c) for c, n in stripes for _ in range(n)], dtype=np.int32)
    if threads.size > MAX_THREADS:
        raise _error(notation, f"{threads.size} threads", f"at most {MAX_THREADS}")
    up = weaves.tiled(weaves.twill((2, 2)), threads.size, threads.size)
    threads = np.tile(threads, up.shape[0] // threads.size)
    palette = np.array([TARTAN_COLORS[name] for name in names]) / 255
    return from_drawdown(up, threads, threads, palette, title=f"Tartan {sett}")
