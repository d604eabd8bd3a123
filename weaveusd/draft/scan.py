"""The scanner: bytes of a WIF become sections of rows with line numbers, at bounded cost."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from weaveusd.draft.model import DraftWarning
from weaveusd.draft.text import one_line, quoted
from weaveusd.errors import DraftError

MAX_BYTES = 8 * 2**20
MAX_LINES = 2**19
MAX_LINE = 64 * 2**10
MAX_SECTIONS = 512
MAX_WARNINGS = 100

SECTIONS = frozenset({
    "WIF", "TEXT", "NOTES", "WEAVING", "WARP", "WEFT", "THREADING", "TIEUP", "TREADLING",
    "LIFTPLAN", "COLOR PALETTE", "COLOR TABLE", "WARP COLORS", "WEFT COLORS", "WARP SPACING",
    "WEFT SPACING", "WARP THICKNESS", "WEFT THICKNESS", "WARP SPACING ZOOM",
    "WEFT SPACING ZOOM", "WARP THICKNESS ZOOM", "WEFT THICKNESS ZOOM", "YARNS",
})  # fmt: skip
"""The sections that are read; rows of every other section are passed over."""

_PROSE = frozenset({"WIF", "TEXT", "NOTES"})

Row = tuple[int, str]
"""Line number and value."""

# A number alone in brackets is no header: PixeLoom marks stretches of thread `[length]Name`.
_HEADER = re.compile(r"\[(?!\d+\])([^\]]*)\]\s*(?:;.*)?")


@dataclass(slots=True)
class Section:
    """Rows of a section, all its repetitions together, by key in lower case.

    `loose` holds the lines without an equals sign. `line` is that of the first header, 0 for
    the lines above any header.
    """

    name: str
    line: int
    rows: dict[str, Row] = field(default_factory=dict)
    loose: list[Row] = field(default_factory=list)


@dataclass(slots=True)
class Scan:
    """A file as scanned: its name for messages, its sections, and the warnings so far."""

    name: str
    sections: dict[str, Section]
    _warnings: list[DraftWarning] = field(default_factory=list)
    _unsaid: int = 0

    def warn(self, line: int, message: str) -> None:
        """Note a decision; beyond `MAX_WARNINGS` only their number is kept."""
        if len(self._warnings) < MAX_WARNINGS:
            self._warnings.append(DraftWarning(line, message))
        else:
            self._unsaid += 1

    @property
    def warnings(self) -> tuple[DraftWarning, ...]:
        """The warnings in order of line, and last the number of those not kept."""
        said = sorted(self._warnings, key=lambda w: w.line)
        if self._unsaid:
            said.append(DraftWarning(0, f"{self._unsaid} more warnings"))
        return tuple(said)

    def error(self, line: int, message: str) -> DraftError:
        """Return the error that names this file and `line` (0 for none) before `message`."""
        where = f"{self.name}:{line}" if line else self.name
        return DraftError(f"{where}: {message}")


def scan(data: bytes, name: str) -> Scan:
    """Split the bytes of a WIF into sections.

    Keys above the first header belong to `WIF`. Sections that occur twice are joined, and the
    last of two rows with one key stays unless it is empty.

    Raises
    ------
    DraftError
        When the file, a line of it or the number of its sections or lines exceeds its limit.
    """
    result = Scan(one_line(name), {})
    if len(data) > MAX_BYTES:
        raise result.error(0, f"found more than {MAX_BYTES} bytes; expected at most that")
    text = _decode(data).replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") >= MAX_LINES:
        raise result.error(0, f"found more than {MAX_LINES} lines; expected at most that")
    lines = text.split("\n")
    if max(map(len, lines)) > MAX_LINE:
        long = next(i for i, line in enumerate(lines, 1) if len(line) > MAX_LINE)
        raise result.error(long, f"found a line of more than {MAX_LINE} characters")
    _fill(result, lines)
    return result


def _decode(data: bytes) -> str:
    """Return the text: by its byte order mark, else UTF-8, else Latin-1."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.removeprefix(b"\xef\xbb\xbf").decode("latin-1")


def _fill(result: Scan, lines: list[str]) -> None:
    """Sort the lines into the sections of `result`."""
    sections = result.sections
    section: Section | None = sections.setdefault("WIF", Section("WIF", 0))
    headers = 0
    for number, raw in enumerate(lines, 1):
        line = raw.strip()
        if not line or line[0] == ";":
            continue
        if line[0] == "[" and (header := _HEADER.fullmatch(line)):
            headers += 1
            if headers > MAX_SECTIONS:
                raise result.error(number, f"found more than {MAX_SECTIONS} sections")
            section = _enter(result, header[1], number)
        elif section is not None:
            key, equals, value = line.partition("=")
            if equals:
                _put(result, section, key.strip().lower(), (number, value.strip()))
            else:
                section.loose.append((number, line))


def _enter(result: Scan, title: str, number: int) -> Section | None:
    """Return the section named `title`, new or met before; None for one that is not read."""
    name = " ".join(title.upper().split())
    if name not in SECTIONS:
        return None
    if (known := result.sections.get(name)) is not None:
        if known.line:
            result.warn(number, f"[{name}] occurs twice; both are read as one")
        else:
            known.line = number
        return known
    return result.sections.setdefault(name, Section(name, number))


def _put(result: Scan, section: Section, key: str, row: Row) -> None:
    """Add a row; of two with one key the last stays, unless it is empty."""
    known = section.rows.get(key)
    if known is None:
        section.rows[key] = row
    elif known[1] != row[1]:
        kept = row if row[1] else known
        section.rows[key] = kept
        if section.name not in _PROSE:
            what = f"[{section.name}] {quoted(key)}"
            result.warn(row[0], f"{what} stands on line {known[0]} too; line {kept[0]} holds")
