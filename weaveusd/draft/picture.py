"""Pictures of a draft as weavers draw it: threading above, tie-up in the corner, drawdown."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weaveusd.errors import DraftError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.draft.model import Bools, Draft

    Pixels = NDArray[np.uint8]

MAX_PIXELS = 2**26
MAX_TIEUP = 64
"""Shafts, and different lifts, of the largest tie-up that is drawn; then a liftplan."""

_PAPER = np.array([255, 255, 255], dtype=np.uint8)
_LINE = np.array([205, 205, 205], dtype=np.uint8)
_INK = np.array([20, 20, 20], dtype=np.uint8)

_Cells = tuple["Pixels", "Bools"]
"""Colors of the cells (rows, columns, 3), row 0 on top, and which cells have a border."""


def draft_picture(draft: Draft, cell: int = 8) -> Pixels:
    """Return a picture of the draft (H, W, 3) uint8, top row first.

    The threading stands above the drawdown with shaft 1 lowest, each thread's color between
    them; to the right the tie-up and the treadling, or the liftplan where there are too many
    treadles. As in the cloth, the first pick is the lowest row and the first end the left
    column. The drawdown shows the color of the thread on top. A cell is `cell` pixels square,
    with a line around it from 4 pixels on.

    Raises
    ------
    DraftError
        When the picture would have more than 2**26 pixels.
    ValueError
        When `cell` is below 1.
    """
    if cell < 1:
        raise ValueError("a cell has at least one pixel")
    pressed, tied = _treadles(draft)
    width = draft.ends + 3 + pressed.shape[1]
    height = draft.picks + 3 + draft.shafts
    if width * height * cell**2 > MAX_PIXELS:
        raise DraftError(
            f"a picture of {width * cell} × {height * cell} pixels; expected at most {MAX_PIXELS}"
        )
    colors, inside = _layout(draft, pressed, tied)
    picture = np.repeat(np.repeat(colors, cell, axis=0), cell, axis=1)
    if cell >= 4:
        rows = np.repeat(np.repeat(inside, cell, axis=0), cell, axis=1)
        picture[0::cell][rows[0::cell]] = _LINE
        picture[:, 0::cell][rows[:, 0::cell]] = _LINE
    return picture


def draft_text(draft: Draft, width: int = 80) -> str:
    """Return the draft as text for a terminal of `width` columns that knows 24-bit color.

    Each character is a half block that shows two rows. What does not fit to the right is cut
    off, and so is what goes beyond `width` rows; a last line says so.
    """
    pressed, tied = _treadles(draft)
    ends, picks = min(draft.ends, width), min(draft.picks, width)
    colors, _ = _layout(draft, pressed, tied, ends=ends, picks=picks)
    colors = colors[:, :width]
    if colors.shape[0] % 2:
        colors = np.concatenate([colors, np.broadcast_to(_PAPER, (1, *colors.shape[1:]))])
    lines = [
        "".join(_half_block(over, under) for over, under in zip(upper, lower, strict=True))
        + "\x1b[0m"
        for upper, lower in zip(colors[0::2].tolist(), colors[1::2].tolist(), strict=True)
    ]
    if ends < draft.ends or picks < draft.picks:
        lines.append(f"the first {ends} of {draft.ends} ends, {picks} of {draft.picks} picks")
    return "\n".join(lines)


def cloth_colors(draft: Draft) -> Pixels:
    """Return the color on top of each crossing (picks, ends, 3), row 0 the first pick."""
    palette = np.rint(draft.palette * 255).astype(np.uint8)
    warp, weft = palette[draft.warp_color], palette[draft.weft_color]
    return np.where(draft.drawdown()[:, :, None], warp[None, :, :], weft[:, None, :])


def _treadles(draft: Draft) -> tuple[Bools, Bools | None]:
    """Return treadling (picks, treadles) and tie-up (treadles, shafts), or liftplan and None."""
    lifts, which = np.unique(draft.liftplan, axis=0, return_inverse=True)
    which = which.ravel()
    if draft.shafts > MAX_TIEUP or len(lifts) > MAX_TIEUP:
        return draft.liftplan, None
    order = np.argsort([int(np.argmax(which == n)) for n in range(len(lifts))])
    rank = np.argsort(order)
    pressed = rank[which][:, None] == np.arange(len(lifts))
    return pressed, lifts[order]


def _layout(
    draft: Draft,
    pressed: Bools,
    tied: Bools | None,
    *,
    ends: int | None = None,
    picks: int | None = None,
) -> _Cells:
    """Return the cells of the whole picture of the first `ends` ends and `picks` picks."""
    ends, picks = ends or draft.ends, picks or draft.picks
    shafts, right = draft.shafts, ends + 3
    height, width = shafts + 3 + picks, right + pressed.shape[1]
    colors = np.broadcast_to(_PAPER, (height, width, 3)).copy()
    inside = np.zeros((height, width), dtype=np.bool_)
    palette = np.rint(draft.palette * 255).astype(np.uint8)

    # Upwards: shaft 1 and pick 1 are the lowest rows of their fields.
    threading = draft.threading[:ends].T[::-1]
    colors[:shafts, :ends][threading] = _INK
    colors[shafts + 1, :ends] = palette[draft.warp_color[:ends]]
    colors[shafts + 3 :, :ends] = cloth_colors(draft)[:picks, :ends][::-1]
    colors[shafts + 3 :, ends + 1] = palette[draft.weft_color[:picks]][::-1]
    colors[shafts + 3 :, right:][pressed[:picks][::-1]] = _INK
    inside[:shafts, :ends] = inside[shafts + 1, :ends] = True
    inside[shafts + 3 :, :ends] = inside[shafts + 3 :, ends + 1] = True
    inside[shafts + 3 :, right:] = True
    if tied is not None:
        colors[:shafts, right:][tied.T[::-1]] = _INK
        inside[:shafts, right:] = True
    return colors, inside


def _half_block(over: list[int], under: list[int]) -> str:
    upper, lower = (";".join(map(str, color)) for color in (over, under))
    return f"\x1b[38;2;{upper};48;2;{lower}m▀"
