"""Drafts turned over, round and into repeats. The cloth's threads keep colors and lengths."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from weaveusd.draft.loom import MAX_CELLS
from weaveusd.draft.resolve import from_drawdown
from weaveusd.errors import DraftError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.draft.model import Draft

    Kind = TypeVar("Kind", bound=np.generic)


def mirror(draft: Draft) -> Draft:
    """Return the draft with the last end first: a Z twill becomes S."""
    return replace(
        draft,
        threading=draft.threading[::-1],
        warp_color=draft.warp_color[::-1],
        warp_pitch_mm=_reversed(draft.warp_pitch_mm),
        warp_thickness_mm=_reversed(draft.warp_thickness_mm),
    )


def rotate(draft: Draft) -> Draft:
    """Return the draft of the cloth turned a quarter to the left: warp becomes weft.

    End c becomes pick c, and pick r end picks - 1 - r. Four turns give the same cloth.
    """
    up = np.ascontiguousarray(~draft.drawdown()[::-1].T)
    return from_drawdown(
        up,
        draft.weft_color[::-1],
        draft.warp_color,
        draft.palette,
        title=draft.title,
        notes=draft.notes,
        warnings=draft.warnings,
        yarns=draft.yarns,
        lengths={
            "warp_pitch_mm": _reversed(draft.weft_pitch_mm),
            "weft_pitch_mm": draft.warp_pitch_mm,
            "warp_thickness_mm": _reversed(draft.weft_thickness_mm),
            "weft_thickness_mm": draft.warp_thickness_mm,
        },
    )


def invert(draft: Draft) -> Draft:
    """Return the draft with warp and weft on top exchanged at every crossing."""
    if (draft.threading.sum(axis=1) == 1).all():
        return replace(draft, liftplan=~draft.liftplan)
    return from_drawdown(
        ~draft.drawdown(),
        draft.warp_color,
        draft.weft_color,
        draft.palette,
        title=draft.title,
        notes=draft.notes,
        warnings=draft.warnings,
        yarns=draft.yarns,
        lengths={
            "warp_pitch_mm": draft.warp_pitch_mm,
            "weft_pitch_mm": draft.weft_pitch_mm,
            "warp_thickness_mm": draft.warp_thickness_mm,
            "weft_thickness_mm": draft.weft_thickness_mm,
        },
    )


def repeat(draft: Draft, across: int, along: int) -> Draft:
    """Return the draft repeated `across` times along the weft and `along` times along the warp.

    Raises
    ------
    DraftError
        When the result has more than 2**26 crossings, or as many threads by shafts.
    ValueError
        When a number of repeats is below 1.
    """
    if across < 1 or along < 1:
        raise ValueError("a draft is repeated at least once")
    ends, picks = draft.ends * across, draft.picks * along
    if max(ends * picks, max(ends, picks) * draft.shafts) > MAX_CELLS:
        raise DraftError(
            f"found {ends} ends, {picks} picks and {draft.shafts} shafts; expected products up to "
            f"{MAX_CELLS}"
        )
    return replace(
        draft,
        threading=np.tile(draft.threading, (across, 1)),
        liftplan=np.tile(draft.liftplan, (along, 1)),
        warp_color=np.tile(draft.warp_color, across),
        weft_color=np.tile(draft.weft_color, along),
        warp_pitch_mm=_tiled(draft.warp_pitch_mm, across),
        weft_pitch_mm=_tiled(draft.weft_pitch_mm, along),
        warp_thickness_mm=_tiled(draft.warp_thickness_mm, across),
        weft_thickness_mm=_tiled(draft.weft_thickness_mm, along),
    )


def _reversed(values: NDArray[Kind] | None) -> NDArray[Kind] | None:
    return None if values is None else values[::-1]


def _tiled(values: NDArray[Kind] | None, times: int) -> NDArray[Kind] | None:
    return None if values is None else np.tile(values, times)
