"""A small square of cloth over a ball."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from colliders import Colliders
from panels import Panel, Sewn, plane, settled
from relax import Fabric, Phase

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

SIDE = 0.074
BALL_CENTER, BALL_RADIUS = (0.0, 0.029, 0.004), 0.016
TURN = np.radians(17.0)
"""The square is turned a little, so that its corners do not fall alike."""

CLOTH = Fabric(density=0.2, stretch=3000.0, shear=30.0, bend=9e-8)
"""Softer than worsted, so that a square this small falls as a large one does."""


def drape(cells: int) -> tuple[Sewn, Doubles]:
    """Return the square, `cells`² quads, and its vertices at rest; `cells` is even."""
    solids = Colliders(0.0002).ground().ellipsoid(BALL_CENTER, (BALL_RADIUS,) * 3)
    edge = SIDE / cells
    return settled(
        lambda count: [square(count)], cells, CLOTH, solids,
        [
            Phase(0.5, 1 / 4800, drag=3.0, apart=1.2 * edge),
            Phase(0.3, 1 / 4800, drag=20.0, apart=1.2 * edge),
        ],
        [Phase(0.2, 1 / 9600, drag=20.0, apart=0.6 * edge)],
    )  # fmt: skip


def square(cells: int) -> Panel:
    """Return the flat square above the ball."""

    def place(right: Doubles, up: Doubles) -> list[Doubles]:
        a, b = SIDE * (right - 0.5), SIDE * (up - 0.5)
        x = a * np.cos(TURN) - b * np.sin(TURN)
        z = -a * np.sin(TURN) - b * np.cos(TURN)
        ripple = 1e-5 * np.sin(500 * a + 200 * b) * np.cos(300 * b - 100 * a)
        height = BALL_CENTER[1] + BALL_RADIUS + 0.0003 + ripple
        return [a + SIDE / 2, b + SIDE / 2, x + BALL_CENTER[0], height, z + BALL_CENTER[2]]

    return plane(cells, cells, place)
