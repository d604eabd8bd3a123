"""Numbers as WIF writes them, and nothing else that Python would take for one.

Every function answers None for what it does not accept: `nan`, `inf`, `1_000`, digits other
than 0 to 9, numbers beyond the range of a double, and endless ones.
"""

from __future__ import annotations

import re
from decimal import Decimal

INTEGER_DIGITS = 18
REAL_LENGTH = 64

_INTEGER = re.compile(r"[+-]?[0-9]+")
_REAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_DECIMAL_COMMA = re.compile(r"[+-]?[0-9]+,[0-9]+")
_LARGEST = Decimal("1e308")

_TRUE = frozenset({"true", "yes", "on", "1", "t", "y"})
_FALSE = frozenset({"false", "no", "off", "0", "f", "n"})


def parse_integer(text: str, digits: int = INTEGER_DIGITS) -> int | None:
    """Return the whole number that `text` is, of at most `digits` digits, else None."""
    text = text.strip()
    if len(text) > digits + 1 or not _INTEGER.fullmatch(text):
        return None
    return int(text)


def parse_real(text: str) -> Decimal | None:
    """Return the finite decimal number that `text` is, else None."""
    text = text.strip()
    if len(text) > REAL_LENGTH or not _REAL.fullmatch(text):
        return None
    value = Decimal(text)
    return value if abs(value) <= _LARGEST else None


def parse_decimal_comma(text: str) -> Decimal | None:
    """Return the number that `text` is with its one comma as decimal sign, else None."""
    text = text.strip()
    if len(text) > REAL_LENGTH or not _DECIMAL_COMMA.fullmatch(text):
        return None
    return parse_real(text.replace(",", "."))


def parse_integers(text: str, digits: int = INTEGER_DIGITS) -> tuple[int, ...] | None:
    """Return the whole numbers in `text`, set apart by commas or blanks, else None.

    An empty text holds none; an empty place between commas counts for nothing.
    """
    numbers = []
    for part in text.replace(",", " ").split():
        number = parse_integer(part, digits)
        if number is None:
            return None
        numbers.append(number)
    return tuple(numbers)


def parse_boolean(text: str) -> bool | None:
    """Return what `text` says of true and false in any of WIF's words, else None."""
    word = text.strip().lower()
    if word in _TRUE:
        return True
    return False if word in _FALSE else None
