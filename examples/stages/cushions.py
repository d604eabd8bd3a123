"""Box cushions: six panels sewn along the edges of a box, filled, and the cord in their seams."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from panels import MICRON, Panel, Sewn, plane, settled
from relax import Fabric, Phase

if TYPE_CHECKING:
    from colliders import Colliders
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

CLOTH = Fabric(density=0.35, stretch=6000.0, shear=400.0, bend=1.8e-4)
SPOKES = 8
"""Vertices around a cord."""

# Right and up of each face, as seen from outside, in the axes of the box.
_FACES = {
    "top": ((1, 0, 0), (0, 0, -1)),
    "bottom": ((1, 0, 0), (0, 0, 1)),
    "front": ((1, 0, 0), (0, 1, 0)),
    "back": ((-1, 0, 0), (0, 1, 0)),
    "left": ((0, 0, 1), (0, 1, 0)),
    "right": ((0, 0, -1), (0, 1, 0)),
}
FACES = tuple(_FACES)


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """An upright box: its middle and half its size along x, y and z, in metres."""

    center: Doubles
    half: Doubles

    @classmethod
    def of(cls, low: tuple[float, ...], high: tuple[float, ...]) -> Box:
        """Return the box between two corners."""
        return cls(0.5 * np.add(high, low), 0.5 * np.subtract(high, low))


def box_panels(box: Box, counts: Indices) -> list[Panel]:
    """Return the panels of a box in the order of `FACES`, of `counts` quads along x, y and z."""

    def face(k: int, right: Doubles, up: Doubles) -> list[Doubles]:
        across, along = (np.array(way, float) for way in _FACES[FACES[k]])
        out = np.cross(across, along)
        a, b = 2 * right - 1, 2 * up - 1
        at = a[..., None] * across + b[..., None] * along + out
        # A ripple of a millimetre lets the seams decide where to pucker.
        ripple = 1e-3 * (1 - a**2) * (1 - b**2) * np.sin(9 * a + 5 * b + k)
        placed = at * box.half + ripple[..., None] * out + box.center
        size = np.abs(np.stack((across, along)) @ box.half)
        return [a * size[0] + 2 * k, b * size[1], *np.moveaxis(placed, -1, 0)]

    panels = []
    for k, (across, along) in enumerate(_FACES.values()):
        columns, rows = (int(np.abs(way) @ counts) for way in (across, along))
        panels.append(plane(rows, columns, lambda r, u, k=k: face(k, r, u)))
    return panels


def stuffed(
    box: Box, cell: float, solids: Colliders, *, fill: float, pressure: float, gravity: float
) -> tuple[Sewn, Doubles]:
    """Return the cover of a box, filled to `fill` of its volume, and its vertices at rest.

    Quads are about `cell` wide; `pressure` and `gravity` are those of `Phase`.
    """
    conditions = {
        "pressure": pressure, "volume": fill * float(np.prod(2 * box.half)), "gravity": gravity
    }  # fmt: skip
    counts = 4 * np.maximum(np.rint(box.half / cell / 2).astype(int), 1)
    return settled(
        lambda cells: box_panels(box, cells), counts, CLOTH, solids,
        [Phase(0.7, drag=10.0, **conditions), Phase(0.3, drag=30.0, **conditions)],
        [Phase(0.25, drag=30.0, **conditions)],
    )  # fmt: skip


def rim(grid: Indices) -> Indices:
    """Return the vertices along the border of a panel's grid, once around to the left."""
    return np.concatenate((grid[0, :-1], grid[:-1, -1], grid[-1, :0:-1], grid[:0:-1, 0]))


def cord(path: Doubles, radius: float) -> Panel:
    """Return a cord in a seam: a tube around the closed path (N, 3), a little outside of it.

    Its cloth is cut on the bias. Columns run along the path and rows around it.
    """
    ahead = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    out = path - path.mean(axis=0)
    out -= ahead * np.sum(out * ahead, axis=1, keepdims=True)
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    side = np.cross(ahead, out)
    turn = np.linspace(0, 2 * np.pi, SPOKES + 1)[:, None, None]
    rings = path + radius * (0.4 * out + np.cos(turn) * out - np.sin(turn) * side)
    rings = np.concatenate((rings, rings[:, :1]), axis=1)
    steps = np.linalg.norm(np.roll(path, -1, axis=0) - path, axis=1)
    along = np.concatenate(((0.0,), np.cumsum(steps)))[None, :]
    around = radius * np.linspace(0, 2 * np.pi, SPOKES + 1)[:, None]
    st = np.stack((along - around, along + around), axis=-1) * np.sqrt(0.5)
    # Rounded, so that first and last column, and row, are sewn to each other.
    return Panel(np.rint(st / MICRON) * MICRON, np.rint(rings / MICRON) * MICRON)
