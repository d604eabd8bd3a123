"""A circle skirt of silk, four gores, on a dress form of half size."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from colliders import Colliders
from panels import Panel, Sewn, plane, settled
from relax import Fabric, Phase

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

GORES = 4
WAIST, LENGTH = 0.052, 0.26
"""Radius of the waist and length of the skirt in metres."""

HEIGHT = 0.38
"""Of the waist above the floor."""

HIPS_CENTER = (0.0, HEIGHT - 0.080, 0.0)
HIPS_HALF = (0.072, 0.1155, 0.072)
"""An ellipsoid, in metres, as wide as the waist at the waist."""

CLOTH = Fabric(density=0.09, stretch=3000.0, shear=60.0, bend=1.2e-5)


def skirt(cells: int) -> tuple[Sewn, Doubles]:
    """Return the skirt, `cells`² quads a gore, and its vertices at rest; `cells` is even."""
    solids = Colliders(0.0015).ground().ellipsoid(HIPS_CENTER, HIPS_HALF)
    edge = 2 * np.pi * (WAIST + LENGTH) / GORES / cells
    return settled(
        gores, cells, CLOTH, solids,
        [Phase(1.2, drag=2.0, apart=edge), Phase(0.5, drag=12.0, apart=edge)],
        [
            Phase(0.3, 1 / 2400, drag=4.0, apart=0.5 * edge),
            Phase(0.3, 1 / 2400, drag=25.0, apart=0.5 * edge),
        ],
        pinned=waist,
    )  # fmt: skip


def gores(cells: int) -> list[Panel]:
    """Return the gores, laid out as a ring; the warp of each runs down its middle."""

    def place(right: Doubles, up: Doubles, middle: float) -> list[Doubles]:
        angle = (right - 0.5) * 2 * np.pi / GORES
        radius = WAIST + LENGTH * (1 - up)
        around = angle + middle
        # A ripple of half a millimetre lets the ring decide where to fold.
        ripple = 5e-4 * (1 - up) * (np.sin(9 * around + 1) + np.sin(14 * around + 2))
        return [
            radius * np.sin(angle), -radius * np.cos(angle),
            radius * np.sin(around), HEIGHT + ripple, radius * np.cos(around),
        ]  # fmt: skip

    turns = [2 * np.pi * (k + 0.5) / GORES for k in range(GORES)]
    return [plane(cells, cells, lambda r, u, t=turn: place(r, u, t)) for turn in turns]


def waist(sewn: Sewn) -> NDArray[np.bool_]:
    """Return which vertices are held by the waistband."""
    held = np.zeros(len(sewn.start), bool)
    for ids in sewn.ids:
        held[ids[-1]] = True
    return held


def waistband() -> Panel:
    """Return the band around the waist."""
    radius, low, height = WAIST + 0.0015, HEIGHT - 0.004, 0.024

    def place(right: Doubles, up: Doubles) -> list[Doubles]:
        around = 2 * np.pi * right
        return [
            radius * around, height * up,
            radius * np.sin(around), low + height * up, radius * np.cos(around),
        ]  # fmt: skip

    return plane(6, 128, place)


def form() -> Panel:
    """Return the surface of the dress form: hips, waist, and a bust cut level."""
    low, top = -0.49 * np.pi, np.arcsin((HEIGHT - HIPS_CENTER[1]) / HIPS_HALF[1])
    turn, rise = np.linspace(low, top, 33), np.linspace(0, 1, 12)[1:]
    radius = np.concatenate((np.cos(turn) * HIPS_HALF[0], WAIST - 0.001 + 0.014 * rise**2))
    height = np.concatenate((HIPS_CENTER[1] + np.sin(turn) * HIPS_HALF[1], HEIGHT + 0.075 * rise))
    radius = np.concatenate((radius, radius[-1] - (0.001, 0.003, 0.02, 0.06)))
    height = np.concatenate((height, height[-1] + (0.002, 0.003, 0.004, 0.004)))
    arc = np.concatenate(((0.0,), np.cumsum(np.hypot(np.diff(radius), np.diff(height)))))

    def place(right: Doubles, up: Doubles) -> list[Doubles]:
        row, around = np.rint(up * (len(arc) - 1)).astype(int), 2 * np.pi * right
        return [
            HIPS_HALF[0] * around, arc[row],
            radius[row] * np.sin(around), height[row], radius[row] * np.cos(around),
        ]  # fmt: skip

    return plane(len(arc) - 1, 48, place)
