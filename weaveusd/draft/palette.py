"""Colors of a WIF: the palette, and the entry that each thread takes from it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft.defaults import default_palette
from weaveusd.draft.loom import Loom
from weaveusd.draft.rows import Numbers, Rows

if TYPE_CHECKING:
    from weaveusd.draft.model import Doubles, Indices

MAX_ENTRIES = 2**16
COLOR_DIGITS = 400
"""Digits of a color: enough to write any double between 0 and 1 exactly."""

RGB = tuple[float, float, float]

_SYSTEMS = ("WARP", "WEFT")
_USUAL_RANGES = (255, 999, 65535)


def read_colors(rows: Rows, loom: Loom) -> tuple[Indices, Indices, Doubles]:
    """Return the palette index of each end and of each pick, and the palette (P, 3) in 0…1.

    Palette entry n of the file has index n - 1; entries that the file leaves out are black and
    belong to no thread.
    """
    table = _table(rows)
    given = {system: _given(rows, loom, system) for system in _SYSTEMS}
    defaults = {system: _default(rows, system) for system in _SYSTEMS}
    if not table:
        table = _without_table(rows, given, defaults)
    shift = _shift(rows, loom, table, given, defaults)
    entries = {
        system: _entries(rows, loom, system, table, given[system], defaults[system], shift)
        for system in _SYSTEMS
    }
    first = min(1, *table)
    palette = np.zeros((max(table) + 1 - first, 3))
    for entry, color in table.items():
        palette[entry - first] = color
    return entries["WARP"] - np.int32(first), entries["WEFT"] - np.int32(first), palette


def _range(rows: Rows, top: int) -> tuple[int, int]:
    """Return the lowest and highest component, as stated or else the usual one that fits."""
    row = rows.value("COLOR PALETTE", "Range")
    if row is not None:
        line = row[0]
        limits = rows.integers("COLOR PALETTE", row, "Range", COLOR_DIGITS)
        if len(limits) == 2 and limits[0] < limits[1]:
            return limits[0], limits[1]
        rows.warn(line, "COLOR PALETTE", "Range is not a lower and a higher number; ignored")
    high = next((high for high in _USUAL_RANGES if top <= high), top)
    rows.warn(0, "COLOR PALETTE", f"states no Range; 0 to {high} is taken")
    return 0, high


def _table(rows: Rows) -> dict[int, RGB]:
    """Return the entries of [COLOR TABLE] as display sRGB in 0…1."""
    listed: dict[int, tuple[int, tuple[int, ...]]] = {}
    for entry, (line, text) in rows.keyed("COLOR TABLE").items():
        if not text:
            continue
        # Behind R, G, B some programs write the name of the yarn.
        rgb, name = text.split(",")[:3], text.split(",")[3:]
        numbers = rows.integers(
            "COLOR TABLE", (line, ",".join(rgb)), f"color {entry}", COLOR_DIGITS
        )
        if len(numbers) != 3:
            raise rows.error(
                line, "COLOR TABLE", f"color {entry} has {len(numbers)} numbers", "R, G, B"
            )
        if entry > MAX_ENTRIES:
            raise rows.error(line, "COLOR TABLE", f"found color {entry}", f"at most {MAX_ENTRIES}")
        if name:
            rows.warn(line, "COLOR TABLE", f"color {entry} has more than R, G, B; ignored")
        listed[entry] = (line, numbers)
    if not listed:
        return {}
    limits = _range(rows, max(max(numbers) for _, numbers in listed.values()))
    return {
        entry: _scaled(rows, "COLOR TABLE", line, numbers, limits)
        for entry, (line, numbers) in listed.items()
    }


def _scaled(
    rows: Rows, section: str, line: int, numbers: tuple[int, ...], limits: tuple[int, int]
) -> RGB:
    low, high = limits
    clamped = [min(max(n, low), high) for n in numbers[:3]]
    if list(numbers[:3]) != clamped:
        rows.warn(line, section, "a color leaves the palette's Range; moved to its nearest")
    r, g, b = ((n - low) / (high - low) for n in clamped)  # correctly rounded by Python
    return r, g, b


def _given(rows: Rows, loom: Loom, system: str) -> Numbers:
    """Return the colors of single threads, by thread counted from 0; empty rows left out."""
    name = f"{system} COLORS"
    count = loom.ends if system == "WARP" else loom.picks
    first = loom.numbering.first_row(name, count)
    listed = rows.numbers(name)
    inside = {n - first: row for n, row in listed.items() if 0 <= n - first < count and row[1]}
    beyond = [row for n, row in listed.items() if not 0 <= n - first < count]
    if beyond:
        rows.warn(beyond[0][0], name, f"{len(beyond)} rows are beyond the {count} threads; ignored")
    return inside


def _default(rows: Rows, system: str) -> tuple[int, tuple[int, ...]] | None:
    """Return line and numbers of the color of all threads: entry, or entry, R, G, B."""
    row = rows.value(system, "Color")
    if row is None:
        return None
    numbers = rows.integers(system, row, "Color")
    return (row[0], numbers) if numbers else None


def _without_table(
    rows: Rows,
    given: dict[str, Numbers],
    defaults: dict[str, tuple[int, tuple[int, ...]] | None],
) -> dict[int, RGB]:
    """Return a palette for a file without [COLOR TABLE].

    Colors that rows spell out as entry, R, G, B are taken. Otherwise colors are made up, unless
    the file announces a palette and colors its threads by it: then something was lost.
    """
    spelled = {
        system: [*given[system].values(), *([row] if (row := defaults[system]) else [])]
        for system in _SYSTEMS
    }
    every = [row for system in _SYSTEMS for row in spelled[system]]
    full = [numbers for _, numbers in every if len(numbers) == 4 and numbers[0] <= MAX_ENTRIES]
    if full:
        limits = _range(rows, max(max(numbers[1:]) for numbers in full))
        return {n[0]: _scaled(rows, "WARP", 0, n[1:], limits) for n in full}
    for system in _SYSTEMS:
        if given[system] and rows.section("COLOR PALETTE") is not None:
            line, numbers = next(iter(given[system].values()))
            raise rows.error(
                line, f"{system} COLORS", f"names color {numbers[0]} of a missing [COLOR TABLE]",
                "a [COLOR TABLE]",
            )  # fmt: skip
    named = sorted({numbers[0] for _, numbers in every if numbers[0] <= MAX_ENTRIES})
    rows.warn(0, "COLOR TABLE", "is missing; the colors are made up")
    names = named if len(named) > 1 else [1, 2]
    dark, pale = default_palette()
    steps = np.linspace(0.0, 1.0, len(names))[:, None]
    made_up = dark + (pale - dark) * steps
    return {n: (float(r), float(g), float(b)) for n, (r, g, b) in zip(names, made_up, strict=True)}


def _shift(
    rows: Rows,
    loom: Loom,
    table: dict[int, RGB],
    given: dict[str, Numbers],
    defaults: dict[str, tuple[int, tuple[int, ...]] | None],
) -> int:
    """Return what to add to a color so that it names an entry of the table.

    It is 0 but in a file that counts from 0 and counts only one of colors and table so.
    """
    if not loom.numbering.from_zero:
        return 0
    used = {n[0] for s in _SYSTEMS for _, n in given[s].values()}
    used |= {row[1][0] for s in _SYSTEMS if (row := defaults[s])}
    if used <= table.keys():
        return 0
    for shift in (1, -1):
        if {n + shift for n in used} <= table.keys():
            rows.warn(0, "COLOR TABLE", f"is read as counting its colors from {max(shift, 0)}")
            return shift
    return 0


def _entries(
    rows: Rows,
    loom: Loom,
    system: str,
    table: dict[int, RGB],
    given: Numbers,
    default: tuple[int, tuple[int, ...]] | None,
    shift: int,
) -> Indices:
    """Return the table entry of each thread of a system."""
    count = loom.ends if system == "WARP" else loom.picks
    entries = np.zeros(count, dtype=np.int32)
    if len(given) < count:
        if default is not None:
            entries[:] = _known(rows, system, default[0], default[1][0] + shift, table)
        else:
            ordered = sorted(table)
            fallback = ordered[0] if system == "WARP" or len(ordered) == 1 else ordered[1]
            rows.warn(0, system, f"states no Color; color {fallback} serves where none is listed")
            entries[:] = fallback
    elif default is not None and default[1][0] + shift not in table:
        rows.warn(default[0], system, "Color is not in the palette; no thread takes it")
    for thread, (line, numbers) in given.items():
        entries[thread] = _known(rows, f"{system} COLORS", line, numbers[0] + shift, table)
    return entries


def _known(rows: Rows, section: str, line: int, entry: int, table: dict[int, RGB]) -> int:
    if entry not in table:
        raise rows.error(
            line, section, f"names color {entry}", f"one of the {len(table)} in the palette"
        )
    return entry
