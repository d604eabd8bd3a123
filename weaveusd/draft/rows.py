"""Rows of a scanned WIF as numbers: what every part of the reader asks of a section."""

from __future__ import annotations

import re
from decimal import Decimal

from weaveusd.draft.numbers import (
    parse_boolean,
    parse_decimal_comma,
    parse_integer,
    parse_integers,
    parse_real,
)
from weaveusd.draft.scan import Row, Scan, Section
from weaveusd.draft.text import quoted
from weaveusd.errors import DraftError

Numbers = dict[int, tuple[int, tuple[int, ...]]]
"""Row number to its line and the whole numbers that it lists."""


_NUMBER_LIKE = re.compile(r"[\d+-]")


class Rows:
    """A scanned file, asked for numbers.

    Every method raises a `DraftError` that names file, line, section, what was found and what
    was expected.
    """

    def __init__(self, scan: Scan) -> None:
        self.scan = scan
        # What was read once is kept, so that its warnings are given once.
        self._counts: dict[tuple[str, str], int | None] = {}
        self._keyed: dict[str, dict[int, Row]] = {}
        self._lists: dict[tuple[str, int], Numbers] = {}

    def section(self, name: str) -> Section | None:
        """Return the section, or None when it is absent or empty: the two mean the same."""
        section = self.scan.sections.get(name)
        return section if section is not None and (section.rows or section.loose) else None

    def value(self, section: str, key: str) -> Row | None:
        """Return line and text of a key, its comment cut off; None where nothing stands."""
        found = self.scan.sections.get(section)
        row = found.rows.get(key.lower()) if found is not None else None
        if row is None:
            return None
        text = without_comment(row[1])
        return (row[0], text) if text else None

    def error(self, line: int, section: str, found: str, expected: str) -> DraftError:
        """Return the error for what stands in `section` on `line`."""
        return self.scan.error(line, f"[{section}] {found}; expected {expected}")

    def warn(self, line: int, section: str, message: str) -> None:
        """Note a decision about `section`."""
        self.scan.warn(line, f"[{section}] {message}")

    def count(self, section: str, key: str) -> int | None:
        """Return the whole number above zero under `key`; None, with a warning, for zero."""
        if (section, key) not in self._counts:
            self._counts[section, key] = self._count(section, key)
        return self._counts[section, key]

    def _count(self, section: str, key: str) -> int | None:
        row = self.value(section, key)
        if row is None:
            return None
        line, text = row
        number = parse_integer(text)
        if number is None or number < 0:
            raise self.error(line, section, f"{key} is {quoted(text)}", "a whole number above 0")
        if number == 0:
            self.warn(line, section, f"{key} is 0 and taken as not stated")
        return number or None

    def integers(self, section: str, row: Row, what: str, digits: int = 9) -> tuple[int, ...]:
        """Return the whole numbers, 0 or above, that `row` lists."""
        numbers = parse_integers(row[1], digits)
        if numbers is None or (numbers and min(numbers) < 0):
            raise self.error(
                row[0],
                section,
                f"{what} is {quoted(row[1])}",
                f"whole numbers of 0 or more in at most {digits} digits",
            )
        return numbers

    def boolean(self, section: str, key: str) -> bool | None:
        """Return true or false under `key`; None, with a warning, for any other word."""
        row = self.value(section, key)
        if row is None:
            return None
        truth = parse_boolean(row[1])
        if truth is None:
            self.warn(
                row[0], section, f"{key} is {quoted(row[1])}, neither true nor false; ignored"
            )
        return truth

    def real(self, section: str, row: Row, what: str) -> Decimal:
        """Return the real number in `row`, zero or above; a decimal comma is warned about."""
        line, text = row
        value = parse_real(text)
        if value is None and (value := parse_decimal_comma(text)) is not None:
            self.warn(line, section, f"{what} {quoted(text)} has a decimal comma; read as {value}")
        if value is None or value < 0:
            raise self.error(line, section, f"{what} is {quoted(text)}", "a number of 0 or more")
        return value

    def keyed(self, name: str) -> dict[int, Row]:
        """Return the rows of a section whose keys are numbers, comments cut off, by key."""
        if name not in self._keyed:
            self._keyed[name] = self._read_keys(name)
        return self._keyed[name]

    def _read_keys(self, name: str) -> dict[int, Row]:
        section = self.section(name)
        if section is None:
            return {}
        rows: dict[int, Row] = {}
        for key, (line, text) in section.rows.items():
            number = self._key(name, key, line)
            if number is not None:
                rows[number] = (line, without_comment(text))
        for line, text in section.loose:
            number = parse_integer(without_comment(text))
            if number is None or number < 0:
                self.warn(line, name, f"{quoted(text)} has no equals sign; ignored")
            else:
                self.warn(line, name, f"row {number} has no equals sign; read as empty")
                rows.setdefault(number, (line, ""))
        return rows

    def numbers(self, name: str, digits: int = 9) -> Numbers:
        """Return the rows of a section as lists of whole numbers, 0 or above.

        Threads, shafts, treadles and colors are told in at most 9 digits.
        """
        if (name, digits) not in self._lists:
            self._lists[name, digits] = self._parse(name, digits)
        return self._lists[name, digits]

    def _parse(self, name: str, digits: int) -> Numbers:
        seen: dict[str, tuple[int, ...]] = {}
        result: Numbers = {}
        for key, (line, text) in self.keyed(name).items():
            numbers = seen.get(text)
            if numbers is None:
                numbers = seen[text] = self.integers(name, (line, text), f"row {key}", digits)
            result[key] = (line, numbers)
        return result

    def _key(self, name: str, key: str, line: int) -> int | None:
        """Return the number of a row; None, with a warning, for a key that is a word."""
        number = parse_integer(key, 9)
        if number is not None and number >= 0:
            return number
        if key and _NUMBER_LIKE.match(key):
            raise self.error(line, name, f"a row is numbered {quoted(key)}", "a number from 1 on")
        self.warn(line, name, f"{quoted(key)} is no row number; ignored")
        return None


def without_comment(text: str) -> str:
    """Return a number's text without the comment behind it: `;…` or PixeLoom's `[len]Name`."""
    for mark in ";[":
        if mark in text:
            text = text.partition(mark)[0]
    return text.strip()
