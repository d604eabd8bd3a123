"""A draft from a drawdown: the fewest shafts that weave it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft.model import Draft, DraftWarning

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.draft.model import Bools, Doubles, Indices


def from_drawdown(
    up: Bools,
    warp_color: Indices,
    weft_color: Indices,
    palette: Doubles,
    *,
    title: str = "",
    notes: str = "",
    warnings: tuple[DraftWarning, ...] = (),
    yarns: tuple[str, ...] = (),
    lengths: dict[str, Doubles | None] | None = None,
) -> Draft:
    """Return the draft that weaves the drawdown `up` (picks, ends), row 0 the first pick.

    Ends that move alike share a shaft; shafts are numbered by their first end. `lengths` holds
    those of the Draft's four length fields that are known.
    """
    first, shaft = _alike(up)
    threading = np.zeros((up.shape[1], first.size), dtype=np.bool_)
    threading[np.arange(up.shape[1]), shaft] = True
    return Draft(
        threading=threading,
        liftplan=up[:, first],
        warp_color=warp_color,
        weft_color=weft_color,
        palette=palette,
        title=title,
        notes=notes,
        warnings=warnings,
        yarns=yarns,
        **(lengths or {}),
    )


def _alike(up: Bools) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first end of each kind of column, in order, and the kind of every column."""
    packed = np.ascontiguousarray(np.packbits(up, axis=0).T)
    whole = packed.view(np.dtype((np.void, packed.shape[1]))).ravel()
    _, first, kind = np.unique(whole, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(order.size)
    return first[order], rank[kind]
