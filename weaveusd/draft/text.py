"""Text from outside: made harmless, and quoted in messages of one line."""

from __future__ import annotations

import unicodedata

LONGEST_LINE = 16_000
"""Characters kept of a title or of one line of notes."""

_UNSAFE = frozenset({"Cc", "Cs", "Zl", "Zp"})  # control, lone surrogate, line and paragraph


def _plain(text: str) -> str:
    """Return `text` with a space for every character that breaks lines or cannot be encoded."""
    if text.isascii() and text.isprintable():
        return text
    return "".join(" " if unicodedata.category(c) in _UNSAFE else c for c in text)


def one_line(text: str) -> str:
    """Return `text` as one line: control characters and runs of blanks become one space."""
    return " ".join(_plain(text).split())[:LONGEST_LINE].rstrip()


def tidy_lines(text: str) -> str:
    """Return the lines of `text`, blanks cut from their ends, without blank outer lines."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return "\n".join(_plain(line).strip()[:LONGEST_LINE].rstrip() for line in lines).strip("\n")


def quoted(text: str, longest: int = 40) -> str:
    """Return `text` in quotes on one line, cut after `longest` characters, for a message."""
    return repr(text if len(text) <= longest else f"{text[: longest - 1]}…")
