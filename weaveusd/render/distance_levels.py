"""The levels of a cloth: cells twice as large from one to the next, packed for the BSDF.

A yarn's frame follows from three numbers: the inclination u of its spine, the place X = sin v on
its section, and the sine P of the twist of its fibres. With ρ its thickness over its width and
w² = ρ² X² + 1 − X²,

    n = (ρ X/w, cos v/w · sin u, cos v/w · cos u)
    t = √(1 − P²) (0, cos u, −sin u) − P (cos v/w, −ρ X/w · sin u, −ρ X/w · cos u)

in the frame x across the yarn, y along, z out of the cloth. Along a round bend sin u depends on X
too, S = sin u (1 + k cos v)/(1 + k) does not; k is the yarn's thickness over its bend. The moment
maps of an asset, `contract.MOMENT_MAPS`, hold means of S, |X| and P and of their squares. All are
linear, so each level follows from the one before.

A cell holds 16 numbers each for warp and weft: shares of flat, rising and falling yarn, the box of
S of the latter two, the box of |X|, how much of the yarn lies where X is positive, the box of P,
and the albedo. A box is as wide as an even distribution of the same mean and variance, within the
limits of what it holds.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import KINDS, MAX_KINDS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

FLAT, RISE, FALL = 0, 1, 2
RISE_LOW, RISE_HIGH, FALL_LOW, FALL_HIGH = 3, 4, 5, 6
ASIDE_LOW, ASIDE_HIGH, RIGHT = 7, 8, 9
TWIST_LOW, TWIST_HIGH = 10, 11
COLOR = 12
NUMBERS = 16
"""Numbers of a system in a cell, the last unused."""

_RARE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class SystemMaps:
    """The moment maps of warp or weft, row 0 at v = 0, and what they are written in.

    `maps` are those of `contract.MOMENT_MAPS`, all within what their numbers can mean; `kinds` is
    among them where `yarns` are more than one.
    """

    maps: Mapping[str, Floats]  # (rows, columns, 4) each
    flatness: float  # ρ
    bend: float  # k
    yarns: tuple[int, ...]  # indices of the yarns that stand for the kinds


@dataclass(frozen=True, slots=True, eq=False)
class Levels:
    """All levels in one array, the finest first, and the yarns of warp and weft."""

    numbers: Floats  # (cells of all levels, 2 · NUMBERS)
    kinds: Floats | None  # (cells, 2 · MAX_KINDS) up to which number a kind is drawn, each system
    rows: tuple[int, ...]  # of each level
    columns: tuple[int, ...]
    flatness: tuple[float, float]
    bend: tuple[float, float]
    yarns: tuple[tuple[int, ...], tuple[int, ...]]


def make_levels(warp: SystemMaps, weft: SystemMaps) -> Levels:
    """Return the levels of a cloth, down to one cell for all of it; maps are of one size."""
    systems = (warp, weft)
    has_kinds = any(len(system.yarns) > 1 for system in systems)
    shown = [_shown(system) for system in systems]
    sizes, cells, kinds = [], [], []
    while True:
        sizes.append(shown[0]["slopes"].shape[:2])
        cells.append(np.concatenate([_cells(maps) for maps in shown], -1))
        if has_kinds:
            kinds.append(np.concatenate([_drawn(maps) for maps in shown], -1))
        if sizes[-1] == (1, 1):
            break
        shown = [{name: coarser(a) for name, a in maps.items()} for maps in shown]
    return Levels(
        np.concatenate(cells),
        np.concatenate(kinds) if has_kinds else None,
        tuple(rows for rows, _ in sizes),
        tuple(columns for _, columns in sizes),
        (warp.flatness, weft.flatness),
        (warp.bend, weft.bend),
        (warp.yarns, weft.yarns),
    )


def coarser(values: Floats) -> Floats:
    """Return `values` (rows, columns, c) of half the size, whole cells: the exact means."""
    return _halved(_halved(values, 0), 1)


def _halved(values: Floats, axis: int) -> Floats:
    """Return the means over n // 2 even pieces of an axis of n, or over the axis of one."""
    v = np.moveaxis(values, axis, 0)
    count = len(v) // 2
    if count == 0:
        return values
    if len(v) % 2 == 0:
        means = 0.5 * (v[0::2] + v[1::2])
    else:
        # A piece is 2 + 1/count long: it starts within one cell and ends in the next but one.
        within = (np.arange(count, dtype=np.float32) / count).reshape(-1, *[1] * (v.ndim - 1))
        ends = within + np.float32(1 / count)
        means = ((1 - within) * v[0:-1:2] + v[1::2] + ends * v[2::2]) / (2 + np.float32(1 / count))
    return np.moveaxis(means, 0, axis)


def _shown(system: SystemMaps) -> Mapping[str, Floats]:
    """Return the maps of a system that its levels need."""
    has_kinds = len(system.yarns) > 1
    return {name: a for name, a in system.maps.items() if has_kinds or name != KINDS}


def _cells(maps: Mapping[str, Floats]) -> Floats:
    """Return the cells of one system and level, (rows · columns, NUMBERS)."""
    slopes, along, across, albedo = (
        maps[name].reshape(-1, 4) for name in ("slopes", "along", "across", "albedo")
    )
    share = slopes[:, : FALL + 1].sum(-1)
    aside, mean = across[:, 0], slopes[:, 3]
    out = np.zeros((len(slopes), NUMBERS), np.float32)
    out[:, : FALL + 1] = slopes[:, : FALL + 1]
    for low, weight, first, second, limits in (
        (RISE_LOW, slopes[:, RISE], along[:, 0], along[:, 1], (0.0, 1.0)),
        (FALL_LOW, slopes[:, FALL], along[:, 2], along[:, 3], (-1.0, 0.0)),
        (ASIDE_LOW, share, aside, across[:, 1], (0.0, 1.0)),
        (TWIST_LOW, share, across[:, 2], across[:, 3], (-1.0, 1.0)),
    ):
        out[:, low], out[:, low + 1] = _box(weight, first, second, limits)
    out[:, RIGHT] = np.clip(0.5 * (1 + mean / np.maximum(aside, _RARE)), 0, 1)
    out[:, COLOR : COLOR + 3] = albedo[:, :3] / np.maximum(share, _RARE)[:, None]
    return out


def _box(
    weight: Floats, first: Floats, second: Floats, limits: tuple[float, float]
) -> tuple[Floats, Floats]:
    """Return the ends of the even distribution with the same mean and variance, in `limits`."""
    weight = np.maximum(weight, _RARE)
    mean = np.clip(first / weight, *limits)
    half = np.sqrt(3 * np.maximum(second / weight - mean**2, 0))
    return np.maximum(mean - half, limits[0]), np.minimum(mean + half, limits[1])


def _drawn(maps: Mapping[str, Floats]) -> Floats:
    """Return up to which number each kind is drawn, (rows · columns, MAX_KINDS) from 0 to 1."""
    if KINDS not in maps:
        return np.ones((maps["slopes"][..., 0].size, MAX_KINDS), np.float32)
    sums = np.cumsum(maps[KINDS].reshape(-1, MAX_KINDS), axis=1)
    return np.asarray(sums / np.maximum(sums[:, -1:], _RARE), np.float32)
