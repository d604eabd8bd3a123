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

MAX_BYTES = 1 << 20

_HEADER = re.compile(r"^\s*(\[\[?)\s*([A-Za-z0-9_.-]+)\s*\]\]?")
_KEY = re.compile(r"^\s*([A-Za-z0-9_-]+)\s*=")


class Table:
    """A table of a TOML file that is read key by key; what is left over is an error.

    `where` is the dotted path that messages show, `lines` the line of each key of the file.
    """

    def __init__(self, data: dict[str, Any], file: str, where: str, lines: dict[str, int]) -> None:
        self._data = dict(data)
        self._read: set[str] = set()
        self.file, self.where, self._lines = file, where, lines

    def error(self, key: str, message: str) -> RecipeError:
        """Return the error that names file, line and key."""
        path = f"{self.where}.{key}" if self.where else key
        line = self._lines.get(path) or self._lines.get(self.where)
        at = f"{self.file}:{line}" if line else self.file
        return RecipeError(f"{at}: {path}: {message}")

    def has(self, key: str) -> bool:
        """Whether the table states `key`."""
        return key in self._data

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
            raise self.error(key, f"found {value!r}, expected a number")
        if not low <= value <= high:
            raise self.error(key, f"found {value}, expected {low:g} to {high:g}")
        return float(value)

    def text(self, key: str, default: Any = ..., choices: tuple[str, ...] = ()) -> str:
        """Return a string, one of `choices` if there are any."""
        value = self.take(key, default)
        if not isinstance(value, str):
            raise self.error(key, f"found {value!r}, expected text")
        if choices and value not in choices:
            raise self.error(key, f"found {value!r}, expected one of {', '.join(choices)}")
        return value

    def table(self, key: str) -> Table:
        """Return the sub-table `key`."""
        value = self.take(key)
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


def read_table(path: Path, file: str | None = None) -> Table:
    """Return the root table of the TOML file `path`, called `file` in messages.

    Raises RecipeError when the file is missing, larger than `MAX_BYTES`, not UTF-8 or no TOML.
    """
    file = file or str(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise RecipeError(f"{file}: larger than {MAX_BYTES} bytes")
        text = path.read_bytes().decode("utf-8")
        data = tomllib.loads(text)
    except OSError as error:
        raise RecipeError(f"{file}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise RecipeError(f"{file}: not UTF-8 at byte {error.start}") from error
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        found = re.search(r"\(at line (\d+)", str(error))
        at = f"{file}:{found[1]}" if found else file
        raise RecipeError(f"{at}: not valid TOML: {error}") from error
    return Table(data, file, "", _lines_of(text))


def _lines_of(text: str) -> dict[str, int]:
    """Return the line of each table and key, by the paths that `Table` uses."""
    lines: dict[str, int] = {}
    counts: dict[str, int] = {}
    where = ""
    for number, line in enumerate(text.splitlines(), 1):
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
