"""Small TOML files of people: tables whose keys and types are all known."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from weaveusd.errors import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MAX_BYTES = 1 << 18
MAX_DOTS = 100
"""Dots in a line: TOML's parser takes time with the square of a dotted key's parts."""


def read_toml(path: Path) -> dict[str, Any]:
    """Return the TOML file at `path`.

    Raises
    ------
    InputError
        When it cannot be read, is too large or no TOML.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > MAX_BYTES or any(line.count(b".") > MAX_DOTS for line in data.splitlines()):
        raise InputError(f"{path}: expected a TOML file of at most {MAX_BYTES} bytes")
    try:
        return tomllib.loads(data.decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"{path}: no TOML: {' '.join(str(error).split())}") from None


def known_keys(where: str, table: Any, types: Mapping[str, type | tuple[type, ...]]) -> None:
    """Raise InputError unless `table` is one whose keys are among `types`, each of its type."""
    if not isinstance(table, dict):
        raise InputError(f"{where}: expected a table")
    for key, value in table.items():
        if key not in types:
            raise InputError(f"{where}: unknown key {key!r}, expected {', '.join(types)}")
        # A truth value is an integer to Python.
        if not isinstance(value, types[key]) or isinstance(value, bool):
            raise InputError(f"{where}: {key} is {value!r}, expected {_name(types[key])}")


def _name(kind: type | tuple[type, ...]) -> str:
    names = {str: "text", int: "a whole number", float: "a number", list: "a list"}
    kinds = kind if isinstance(kind, tuple) else (kind,)
    return names.get(kinds[-1], kinds[-1].__name__)
