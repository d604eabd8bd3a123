"""Ambient occlusion: how much of the sky a texel sees past the yarns around it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.synth.compiled import compiled
from weaveusd.synth.rows import share_out

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats32 = NDArray[np.float32]

STEPS = 10
"""Places looked at in each direction, evenly up to the radius."""

# Unit vectors of twelve directions, as numbers: no library's sine may differ.
_C30 = 0.8660254037844386
DIRECTIONS = np.array(
    [(1, 0), (_C30, 0.5), (0.5, _C30), (0, 1), (-0.5, _C30), (-_C30, 0.5),
     (-1, 0), (-_C30, -0.5), (-0.5, -_C30), (0, -1), (0.5, -_C30), (_C30, -0.5)]
)  # fmt: skip


def occlusion(
    height_mm: Floats32, texel_mm: tuple[float, float], radius_mm: float, threads: int = 1
) -> Floats32:
    """Return the visible share (H, W) of a sky over a periodic field of heights (H, W).

    Along each direction the horizon's slope is t = max (z' − z) / distance, and the share of the
    cosine-weighted sky above it cos² of its elevation, 1 / (1 + t²); the mean over directions.
    `texel_mm` is the size of a texel along x and y; so many `threads` compute.
    """
    out = np.empty_like(height_mm)
    reach = DIRECTIONS[:, None, :] * np.linspace(radius_mm / STEPS, radius_mm, STEPS)[:, None]
    offset = np.rint(reach / texel_mm).astype(np.int32)
    distance = np.sqrt(((offset * texel_mm) ** 2).sum(-1))
    inverse = np.divide(1.0, distance, out=np.zeros_like(distance), where=distance > 0)

    def fill(first: int, last: int) -> None:
        slope = np.empty(out.shape[1])
        _fill(first, height_mm, offset, inverse, slope, out[first:last])

    share_out(fill, len(out), threads)
    return out


def upsampled(field: Floats32, rows: NDArray[np.float64], width: int) -> Floats32:
    """Return a periodic `field` (h, w) at `rows` (n,) in 0…1 and `width` columns, bilinear."""
    h, w = field.shape
    y, x = rows * h - 0.5, (np.arange(width) + 0.5) / width * w - 0.5
    i, j = np.floor(y).astype(int), np.floor(x).astype(int)
    v, u = (y - i)[:, None].astype(np.float32), (x - j).astype(np.float32)
    low, high = field[i % h], field[(i + 1) % h]
    line = low + v * (high - low)
    left, right = line[:, j % w], line[:, (j + 1) % w]
    return np.asarray(left + u * (right - left))


@compiled
def _fill(first, height, offset, inverse, slope, out):  # type: ignore[no-untyped-def]
    # Directions outside, texels inside: that loop becomes vector instructions.
    rows, columns = height.shape
    directions, steps = inverse.shape
    for k in range(len(out)):
        i = first + k
        out[k, :] = 0.0
        for d in range(directions):
            slope[:] = 0.0
            for s in range(steps):
                other = height[(i + offset[d, s, 1]) % rows]
                shift = offset[d, s, 0] % columns
                split = columns - shift
                for j in range(split):
                    slope[j] = max(slope[j], (other[j + shift] - height[i, j]) * inverse[d, s])
                for j in range(split, columns):
                    slope[j] = max(slope[j], (other[j - split] - height[i, j]) * inverse[d, s])
            for j in range(columns):
                out[k, j] += 1.0 / (1.0 + slope[j] * slope[j])
        for j in range(columns):
            out[k, j] /= directions


def texels_for(pitch_mm: float, texel_mm: float) -> int:
    """Return how many fine texels one coarse texel of the occlusion may span, 1 or more.

    Occlusion is smooth on the scale of a yarn: sixteen texels a pitch are enough.
    """
    return max(1, math.floor(pitch_mm / (16 * texel_mm)))
