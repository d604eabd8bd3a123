"""The levels of a cloth: cells twice as large from one to the next, packed for the BSDF.

A cell holds 16 numbers each for warp and weft: shares of flat, rising and falling texels, the box
of S of the latter two, the boxes of X and ψ, and the albedo. A box is as wide as an even
distribution of the same mean and variance, within the limits of what it holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.render import distance_moments as dm

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]
    Doubles = NDArray[np.float64]

FLAT, RISE, FALL = 0, 1, 2
RISE_LOW, RISE_HIGH, FALL_LOW, FALL_HIGH = 3, 4, 5, 6
X_LOW, X_HIGH, TWIST_LOW, TWIST_HIGH = 7, 8, 9, 10
COLOR = 11
NUMBERS = 16
"""Numbers of a system in a cell, the last two unused."""

PER_CROSSING = 4
"""Cells of the finest level along the side of a crossing, at most."""

MAX_CELLS = 1 << 18
"""Cells of the finest level; a larger cloth starts with coarser ones."""

_RARE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Levels:
    """All levels in one array, the finest first, and the optics of warp and weft."""

    numbers: Floats  # (cells of all levels, 2 · NUMBERS)
    rows: tuple[int, ...]  # of each level
    columns: tuple[int, ...]
    bend: tuple[float, float]
    flatness: tuple[float, float]
    optics: Floats  # (inputs, 2) means over the yarns of a system, in the order of the inputs


def make_levels(
    arrays: Mapping[str, NDArray[Any]],
    optics: Floats,
    threads: dm.Threads,
    crossings: tuple[int, int],
) -> Levels:
    """Return the levels of a cloth, down to one cell for all of it.

    Parameters
    ----------
    arrays
        The channels that `packing.pack` takes, valid, row 0 at v = 0.
    optics
        (inputs, yarns), as `optics.yarn_table` returns them.
    threads
        System and flatness of every yarn.
    crossings
        Picks and ends of the textures.
    """
    height, width = arrays["normal"].shape[:2]
    rows, columns = (
        min(texels, max(1, PER_CROSSING * count))
        for texels, count in zip((height, width), crossings, strict=True)
    )
    while rows * columns > MAX_CELLS:
        rows, columns = max(1, rows // 2), max(1, columns // 2)
    made = [dm.moments(arrays, threads, (rows, columns))]
    while made[-1].texels.size > 1:
        made.append(dm.coarser(made[-1]))
    return Levels(
        np.concatenate([_boxes(level) for level in made]),
        tuple(level.texels.shape[0] for level in made),
        tuple(level.texels.shape[1] for level in made),
        made[0].bend,
        made[0].flatness,
        _system_optics(arrays, optics, threads),
    )


def _boxes(level: dm.Moments) -> Floats:
    """Return the cells of a level, (rows · columns, 2 · NUMBERS)."""
    m = (level.sums / level.texels[..., None, None]).reshape(-1, dm.SYSTEMS, dm.MOMENTS)
    out = np.zeros((len(m), dm.SYSTEMS, NUMBERS))
    out[..., FLAT], out[..., RISE], out[..., FALL] = (
        m[..., i] for i in (dm.FLAT, dm.RISE, dm.FALL)
    )
    share = out[..., : FALL + 1].sum(-1)
    for low, weight, first, limits in (
        (RISE_LOW, m[..., dm.RISE], dm.RISE_S, (0.0, 1.0)),
        (FALL_LOW, m[..., dm.FALL], dm.FALL_S, (-1.0, 0.0)),
        (X_LOW, share, dm.X, (-1.0, 1.0)),
        (TWIST_LOW, share, dm.TWIST, (-np.pi / 2, np.pi / 2)),
    ):
        out[..., low], out[..., low + 1] = _box(weight, m[..., first], m[..., first + 1], limits)
    albedo = m[..., dm.COLOR : dm.COLOR + 3] / np.maximum(share, _RARE)[..., None]
    out[..., COLOR : COLOR + 3] = albedo
    return out.reshape(len(m), -1).astype(np.float32)


def _box(
    weight: Doubles, first: Doubles, second: Doubles, limits: tuple[float, float]
) -> tuple[Doubles, Doubles]:
    """Return the ends of the even distribution with the same mean and variance, in `limits`."""
    weight = np.maximum(weight, _RARE)
    mean = np.clip(first / weight, *limits)
    half = np.sqrt(3 * np.maximum(second / weight - mean**2, 0))
    return np.maximum(mean - half, limits[0]), np.minimum(mean + half, limits[1])


def _system_optics(
    arrays: Mapping[str, NDArray[Any]], optics: Floats, threads: dm.Threads
) -> Floats:
    """Return the optics of warp and weft: means over the texels that show their yarns."""
    yarn = np.rint(arrays["yarn_id"]).astype(np.int64).ravel()
    seen = np.bincount(yarn[yarn >= 0], minlength=optics.shape[1]).astype(np.float64)
    out = [_mean(optics, np.where(threads.is_weft == bool(k), seen, 0)) for k in range(dm.SYSTEMS)]
    return np.stack(out, -1).astype(np.float32)


def _mean(optics: Floats, weight: Sequence[float] | Doubles) -> Doubles:
    total = float(np.sum(weight))
    even = np.full(optics.shape[1], 1 / optics.shape[1])
    return np.asarray(optics, np.float64) @ (np.asarray(weight) / total if total else even)
