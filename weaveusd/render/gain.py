"""From a yarn's color to the albedo of its fibres."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.contract import SHADER_ALBEDO_GAIN

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_GAIN = 1e3
_ROWS = 256


def albedos(
    color: NDArray[np.floating[Any]], yarn_id: NDArray[Any], gains: Sequence[float], yarns: int
) -> NDArray[np.float32]:
    """Return A = min(1, gain · color) (H, W, 3), the gain being that of the texel's yarn.

    Parameters
    ----------
    color
        (H, W, 3) linear base color, not negative.
    yarn_id
        (H, W, 1) index of the yarn, counted from 0; `contract.GAP` where there is none.
    gains
        `contract.SHADER_ALBEDO_GAIN`, one for each yarn.
    yarns
        Number of yarns that the shader describes. An index beyond is left to others to report.

    Raises
    ------
    ValueError
        There is not one gain a yarn, or one is out of 0 to `MAX_GAIN`.
    """
    table = np.asarray(gains, np.float32).reshape(-1)
    if table.size != yarns:
        raise ValueError(f"{SHADER_ALBEDO_GAIN}: has {table.size} values, but eta has {yarns}")
    wrong = ~((table >= 0) & (table <= MAX_GAIN))
    if wrong.any():
        found = f"{table[wrong][0]:g}"
        raise ValueError(f"{SHADER_ALBEDO_GAIN}: is {found}, expected 0 to {MAX_GAIN:g}")
    out = np.empty(color.shape, np.float32)
    for first in range(0, len(color), _ROWS):
        rows = slice(first, first + _ROWS)
        gain = table[np.clip(yarn_id[rows, :, 0], 0, yarns - 1).astype(np.intp)]
        out[rows] = np.minimum(color[rows] * gain[..., None], 1)
    return out
