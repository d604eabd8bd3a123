"""A small WIF to change section by section."""

from __future__ import annotations

from weaveusd.draft.model import Draft
from weaveusd.draft.wif import parse_wif

TWILL = {
    "WIF": "Version=1.1",
    "WEAVING": "Shafts=4\nTreadles=4\nRising Shed=yes",
    "WARP": "Threads=4\nColor=1",
    "WEFT": "Threads=4\nColor=2",
    "COLOR PALETTE": "Entries=2\nRange=0,255",
    "COLOR TABLE": "1=0,0,0\n2=255,255,255",
    "THREADING": "1=1\n2=2\n3=3\n4=4",
    "TIEUP": "1=1,2\n2=2,3\n3=3,4\n4=1,4",
    "TREADLING": "1=1\n2=2\n3=3\n4=4",
}

TWILL_ROWS = ["##..", ".##.", "..##", "#..#"]
"""The drawdown, first pick first."""


def wif(changes: dict[str, str | None] | None = None) -> str:
    """The twill with sections replaced, added, or (None) left out."""
    sections = {**TWILL, **(changes or {})}
    return "".join(f"[{name}]\n{body}\n" for name, body in sections.items() if body is not None)


def read(text: str | bytes) -> Draft:
    """The draft in a WIF named test.wif."""
    return parse_wif(text.encode() if isinstance(text, str) else text, "test.wif")


def rows(draft: Draft) -> list[str]:
    """The drawdown, first pick first, # where the end is up."""
    return ["".join("#" if up else "." for up in row) for row in draft.drawdown()]


def warned(draft: Draft, *words: str) -> bool:
    """Whether one warning holds all the words."""
    return any(all(word in str(w) for word in words) for w in draft.warnings)
