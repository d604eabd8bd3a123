"""TOML with a memory for lines: every value can say where it stands."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

from weaveusd.errors import RecipeError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MAX_BYTES = 1 << 18
MAX_DOTS = 100
"""Dots in a line: TOML's parser takes time and memory with the square of a dotted key's parts."""
MAX_TEXT = 2000
"""Longest string of a recipe, in characters."""

_BARE = re.compile(r"[A-Za-z0-9_-]+")
_HEADER = re.compile(r"^\s*(\[\[?)\s*([A-Za-z0-9_.-]+)\s*\]\]?")
_KEY = re.compile(r"^\s*([A-Za-z0-9_-]+)\s*=")


class Table:
    """A table of a TOML file that is read key by key; what is left over is an error.

    `where` is the dotted path that messages show, `lines` the line of each key of the file.
    """

    __slots__ = ("_data", "_lines", "_read", "file", "where")

    def __init__(self, data: dict[str, Any], file: str, where: str, lines: dict[str, int]) -> None:
        self._data = dict(data)
        self._read: set[str] = set()
        self.file, self.where, self._lines = file, where, lines

    def place(self, key: str) -> str:
        """Return file, line and path of `key`, as messages begin."""
        name = key if _BARE.fullmatch(key) else shown(key)
        path = f"{self.where}.{name}" if self.where else name
        line = self._line(path)
        return f"{self.file}:{line}: {path}" if line else f"{self.file}: {path}"

    def _line(self, path: str) -> int | None:
        """Return the line of `path`, or of the nearest table or key around it."""
        while path and path not in self._lines:
            path = path[: max(path.rfind("."), path.rfind("["), 0)]
        return self._lines.get(path)

    def error(self, key: str, message: str) -> RecipeError:
        """Return the error that names file, line and key."""
        return RecipeError(f"{self.place(key)}: {message}")

    def has(self, key: str) -> bool:
        """Whether the table states `key`."""
        return key in self._data

    def one_of(self, *keys: str) -> str:
        """Return which of `keys` is stated: exactly one of them has to be."""
        stated = [key for key in keys if self.has(key)]
        self._read.update(keys)
        if not stated:
            raise self.error(keys[0], f"missing; expected exactly one of {', '.join(keys)}")
        if len(stated) > 1:
            beside = f"found beside {stated[0]}, expected exactly one of {', '.join(keys)}"
            raise self.error(stated[1], beside)
        return stated[0]

    def take(self, key: str, default: Any = ...) -> Any:
        """Return the raw value of `key`; without `default` the key is required."""
        self._read.add(key)
        if key in self._data:
            return self._data[key]
        if default is ...:
            raise self.error(key, "missing")
        return default

    def number(self, key: str, low: float, high: float, default: Any = ...) -> float:
        """Return a finite number within `low`…`high`."""
        value = self.take(key, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.error(key, f"found {shown(value)}, expected a number")
        if not low <= value <= high:
            raise self.error(key, f"found {shown(value)}, expected {low:g} to {high:g}")
        return float(value)

    def optional(self, key: str, low: float, high: float) -> float | None:
        """Return a finite number within `low`…`high`, None where `key` is absent."""
        if self.take(key, None) is None:
            return None
        return self.number(key, low, high)

    def whole(self, key: str, low: int, high: int, default: int) -> int:
        """Return a whole number within `low`…`high`."""
        value = self.take(key, default)
        if type(value) is not int:
            raise self.error(key, f"found {shown(value)}, expected a whole number")
        return int(self.number(key, low, high, default))

    def text(self, key: str, default: Any = ..., choices: tuple[str, ...] = ()) -> str:
        """Return a string on one line, one of `choices` if there are any."""
        value = self.take(key, default)
        if not isinstance(value, str):
            raise self.error(key, f"found {shown(value)}, expected text")
        if choices and value not in choices:
            raise self.error(key, f"found {shown(value)}, expected one of {', '.join(choices)}")
        if len(value) > MAX_TEXT or not value.isprintable():
            expected = f"one line of at most {MAX_TEXT} printable characters"
            raise self.error(key, f"found {shown(value)}, expected {expected}")
        return value

    def table(self, key: str, default: Any = ...) -> Table:
        """Return the sub-table `key`."""
        value = self.take(key, default)
        if not isinstance(value, dict):
            raise self.error(key, "expected a table")
        return self._child(value, key)

    def tables(self, key: str, most: int) -> list[Table]:
        """Return the array of tables `key`, one to `most` of them."""
        value = self.take(key)
        if not isinstance(value, list) or not all(isinstance(v, dict) for v in value):
            raise self.error(key, f"expected [[{key}]] tables")
        if not 1 <= len(value) <= most:
            raise self.error(key, f"found {len(value)} tables, expected 1 to {most}")
        return [self._child(v, f"{key}[{i}]") for i, v in enumerate(value)]

    def close(self) -> None:
        """Raise for a key that nothing has read."""
        for key in self._data:
            if key not in self._read:
                known = ", ".join(sorted(self._read))
                raise self.error(key, f"unknown key; known here: {known}")

    def _child(self, data: dict[str, Any], key: str) -> Table:
        where = f"{self.where}.{key}" if self.where else key
        return Table(data, self.file, where, self._lines)


def shown(value: Any) -> str:
    """Return `value` for a message: on one line and short."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list) and len(value) > 8:
        return f"a list of {len(value)}"
    try:
        text = repr(value)
    except ValueError:  # an integer too long for Python to print
        return "a huge number"
    return text if len(text) <= 60 else f"{text[:57]}…"


def read_text(path: Path, most: int, place: str, encoding: str = "utf-8") -> str:
    """Return the text of `path`, of which no more than `most` + 1 bytes are taken to memory.

    Raises RecipeError, which begins with `place`, when the file cannot be read, has more than
    `most` bytes, or is no `encoding`, a kind of UTF-8.
    """
    try:
        with path.open("rb") as file:
            data = file.read(most + 1)
        if len(data) > most:
            raise RecipeError(f"{place}: larger than {most} bytes")
        return data.decode(encoding)
    except OSError as error:
        raise RecipeError(f"{place}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise RecipeError(f"{place}: not UTF-8 at byte {error.start}") from error


def parse_table(text: str, file: str) -> Table:
    """Return the root table of the TOML `text`, called `file` in messages.

    Raises RecipeError when it is no TOML, or has a line of more than `MAX_DOTS` dots.
    """
    for number, line in enumerate(text.split("\n"), 1):
        if (dots := line.count(".")) > MAX_DOTS:
            expected = f"expected at most {MAX_DOTS}"
            raise RecipeError(f"{file}:{number}: found {dots} dots in a line, {expected}")
    try:
        data = tomllib.loads(text)
    # A ValueError that is no TOMLDecodeError: an integer of more digits than Python reads.
    except (ValueError, RecursionError) as error:
        found = re.search(r"\(at line (\d+)", str(error))
        at = f"{file}:{found[1]}" if found else file
        raise RecipeError(f"{at}: not valid TOML: {' '.join(str(error).split())}") from error
    return Table(data, file, "", _lines_of(text))


def _lines_of(text: str) -> dict[str, int]:
    """Return the line of each table and key, by the paths that `Table` uses."""
    lines: dict[str, int] = {}
    counts: dict[str, int] = {}
    where = ""
    for number, line in enumerate(text.split("\n"), 1):
        header = _HEADER.match(line)
        if header:
            name = header[2]
            if header[1] == "[[":
                counts[name] = counts.get(name, -1) + 1
                where = f"{name}[{counts[name]}]"
            else:
                head, dot, rest = name.partition(".")
                where = f"{head}[{counts[head]}]{dot}{rest}" if head in counts else name
            lines.setdefault(where, number)
            lines.setdefault(name, number)
            continue
        key = _KEY.match(line)
        if key:
            lines.setdefault(f"{where}.{key[1]}" if where else key[1], number)
    return lines
