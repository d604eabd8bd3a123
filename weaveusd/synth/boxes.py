"""Means over even pieces of an image, exact for any sizes: the box filter of a mip map.

Sums run in one order, so that bits are the same on every machine.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


def reduced(values: NDArray[np.floating], width: int, height: int) -> Doubles:
    """Return `values` (H, W, c) as (height, width, c): the exact means over even pieces."""
    out = np.zeros((height, width, values.shape[2]))
    add_rows(out, columns_reduced(np.asarray(values, float), width), 0, len(values))
    return out


def columns_reduced(values: Doubles, width: int) -> Doubles:
    """Return the means (rows, width, c) of `values` (rows, W, c) over even pieces of the rows."""
    full = values.shape[1]
    if full == width:
        return values
    # A sum from the left, taken at the borders: in the same order on every machine.
    before = np.zeros((len(values), full + 1, values.shape[2]))
    np.cumsum(values, axis=1, out=before[:, 1:])
    whole, part = np.divmod(np.arange(width + 1) * full, width)
    inside = values[:, np.minimum(whole, full - 1)] * (part / width)[:, None]
    return np.asarray(np.diff(before[:, whole] + inside, axis=1) * (width / full))


def add_rows(total: Doubles, rows: Doubles, first: int, full: int) -> None:
    """Add `rows`, from row `first` of `full` on, to the means `total` that they are part of."""
    height = len(total)
    for j, row in enumerate(rows, first):
        # In units of 1/height of a fine row: where this one and its coarse row end.
        r = j * height // full
        inside = min(height, (r + 1) * full - j * height)
        total[r] += row * (inside / full)
        if inside < height:
            total[r + 1] += row * ((height - inside) / full)


def columns_of(texels: int, width: int) -> tuple[NDArray[np.intp], Doubles]:
    """Return which of `width` even pieces each of `texels` lies in first, and how much of it."""
    begin = np.arange(texels) * width
    cell = begin // texels
    return cell, np.minimum(width, (cell + 1) * texels - begin) / width
