"""Reading WIF, the Weaving Information File 1.1, as real programs write it."""

from __future__ import annotations

import os
from pathlib import Path

from weaveusd.draft.lengths import read_lengths
from weaveusd.draft.loom import read_loom, read_threading
from weaveusd.draft.model import Draft
from weaveusd.draft.numbers import parse_integer
from weaveusd.draft.palette import read_colors
from weaveusd.draft.rows import Rows
from weaveusd.draft.scan import MAX_BYTES, scan
from weaveusd.draft.shed import read_liftplan
from weaveusd.draft.text import one_line, quoted
from weaveusd.errors import DraftError

MAX_YARNS, MAX_YARN_TEXT = 256, 200
"""Yarns that are kept, and characters of each."""


def read_wif(path: str | os.PathLike[str]) -> Draft:
    """Return the draft in the WIF at `path`.

    Files that a patient person could read are read; every decision taken on that person's
    behalf is one of the draft's warnings.

    Raises
    ------
    DraftError
        When the file cannot be opened, exceeds a limit, or is no complete draft. The message is
        one line that names file, line, section, what was found and what was expected.
    """
    return parse_wif(load_wif(path), os.fspath(path))


def load_wif(path: str | os.PathLike[str]) -> bytes:
    """Return the bytes of the WIF at `path`, one more than the limit where it is too long.

    Raises
    ------
    DraftError
        When the file cannot be opened.
    """
    try:
        with Path(path).open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
        raise DraftError(
            f"{one_line(os.fspath(path))}: cannot be read: {one_line(reason)}"
        ) from error


def parse_wif(data: bytes, name: str) -> Draft:
    """Return the draft in the bytes of a WIF; `name` stands for the file in messages.

    Raises
    ------
    DraftError
        As `read_wif` does.
    """
    scanned = scan(data, name)
    rows = Rows(scanned)
    if not any(rows.section(s) for s in ("WEAVING", "WARP", "WEFT", "THREADING")):
        raise scanned.error(0, "found no section of a draft; expected a WIF")
    _note_head(rows)
    loom = read_loom(rows)
    threading = read_threading(rows, loom)
    liftplan = read_liftplan(rows, loom, threading)
    warp_color, weft_color, palette = read_colors(rows, loom)
    lengths = read_lengths(rows, loom)
    title = scanned.sections["TEXT"].rows.get("title") if "TEXT" in scanned.sections else None
    return Draft(
        threading=threading,
        liftplan=liftplan,
        warp_color=warp_color,
        weft_color=weft_color,
        palette=palette,
        **lengths,
        title=title[1] if title else "",
        notes=_notes(rows),
        yarns=_yarns(rows),
        warnings=scanned.warnings,
    )


def _note_head(rows: Rows) -> None:
    """Warn of lines above the first section and of an unknown version."""
    head = rows.scan.sections["WIF"]
    if head.loose:
        rows.warn(head.loose[0][0], "WIF", f"{len(head.loose)} lines that are no keys; ignored")
    version = rows.value("WIF", "Version")
    if version is not None and version[1] not in ("1", "1.0", "1.1"):
        rows.warn(version[0], "WIF", f"Version is {quoted(version[1])}; read as 1.1")


def _yarns(rows: Rows) -> tuple[str, ...]:
    """Return what a WIF 1.2 says of its yarns; nothing is computed from it, a recipe is."""
    section = rows.section("YARNS")
    if section is None:
        return ()
    kept = [one_line(value)[:MAX_YARN_TEXT] for _, value in section.rows.values()][:MAX_YARNS]
    rows.warn(section.line, "YARNS", f"{len(section.rows)} yarns; a recipe decides them")
    return tuple(kept)


def _notes(rows: Rows) -> str:
    """Return the notes: rows by number, and lines without one where they stand in the file."""
    section = rows.section("NOTES")
    if section is None:
        return ""
    lines = [(line, key, text) for key, (line, text) in section.rows.items()]
    lines += [(line, "", text) for line, text in section.loose]
    numbered: list[tuple[int, int, str]] = []
    last = 0
    for line, key, text in sorted(lines):
        number = parse_integer(key, 9)
        last = last if number is None else number
        unnumbered = key and number is None
        numbered.append((last, line, f"{key}={text}" if unnumbered else text))
    return "\n".join(text for _, _, text in sorted(numbered))
