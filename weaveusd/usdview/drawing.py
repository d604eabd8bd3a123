"""The draft of a cloth as a picture, where this Python can draw one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from weaveusd.errors import WeaveusdError

SIDE = 900
"""Pixels that the longer side of a picture has at most, if its threads are no more."""

LARGEST_CELL = 12


@dataclass(frozen=True, slots=True)
class Drawing:
    """A picture of 3 bytes a pixel, the top row first; `reason` says why there is none."""

    width: int = 0
    height: int = 0
    pixels: bytes = b""
    reason: str = ""


def draw_draft(path: str) -> Drawing:
    """Return the picture of the WIF file `path`, as weavers draw it: threading, tie-up, drawdown.

    The first pick is the lowest row. It needs NumPy, which the Python of a usdview may lack.
    """
    if not path:
        return Drawing(reason="This cloth has no draft beside it.")
    if not Path(path).is_file():
        return Drawing(reason=f"{path}: no such file")
    try:
        from weaveusd.draft.picture import draft_picture
        from weaveusd.draft.wif import read_wif
    except ImportError as error:
        return Drawing(reason=f"The draft cannot be drawn here: {error}")
    try:
        draft = read_wif(path)
        longest = max(draft.ends, draft.picks) + draft.shafts + 3
        picture = draft_picture(draft, min(LARGEST_CELL, max(1, SIDE // longest)))
    except WeaveusdError as error:
        return Drawing(reason=str(error))
    height, width, _ = picture.shape
    return Drawing(width, height, picture.tobytes())
