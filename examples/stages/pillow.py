"""A pillow of linen, 40 cm square, on a wedge."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from colliders import Colliders
from panels import Panel, Sewn, plane, settled
from relax import Fabric, Phase

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

SIDE = 0.40
TAPER = 0.03
"""Share by which the corners are drawn in, so that they do not stand out as ears."""

FILLING = 0.0089
"""Cubic metres of down: some 70 % of what the empty cover could hold."""

CLOTH = Fabric(density=0.26, stretch=4000.0, shear=250.0, bend=4.5e-5)
SLANT = np.radians(38.0)
WEDGE = (0.34, 0.27)
"""Width and depth in metres of the wedge that the pillow lies on; it rises to the back."""

WEDGE_FRONT = 0.11
"""Where the wedge meets the floor, in z."""

_COSINE, _SINE = (round(float(f(SLANT)), 9) for f in (np.cos, np.sin))
SLANTED = np.array(((1, 0, 0), (0, _COSINE, _SINE), (0, -_SINE, _COSINE)))
"""Right, out of the slope, and down it, as rows."""


def pillow(cells: int) -> tuple[Sewn, Doubles]:
    """Return the pillow of `cells`² quads a side, an even number, and its vertices at rest."""
    below = wedge()[0][:4].mean(axis=0) - 0.05 * SLANTED[1]
    slope = (0.5 * WEDGE[0], 0.05, 0.5 * WEDGE[1] / SLANTED[1, 1])
    solids = Colliders(0.002).ground().box(below, slope, SLANTED)
    fill = {"pressure": 300.0, "volume": FILLING}
    return settled(
        covers, cells, CLOTH, solids,
        [
            Phase(0.5, gravity=0.0, drag=80.0, **fill),
            Phase(1.0, drag=8.0, **fill),
            Phase(0.4, drag=20.0, **fill),
        ],
        [Phase(0.3, 1 / 2400, drag=6.0, **fill), Phase(0.2, 1 / 2400, drag=30.0, **fill)],
        friction=1.0,
    )  # fmt: skip


def covers(cells: int) -> list[Panel]:
    """Return the front and the back of the empty pillow, side by side in the pattern."""
    return [
        plane(cells, cells, lambda right, up: _place(right, up, 1)),
        plane(cells, cells, lambda right, up: _place(right, up, -1)),
    ]


def wedge() -> tuple[Doubles, list[tuple[int, ...]]]:
    """Return points of the wedge and its faces: slope, rear, bottom, left and right."""
    half, height = 0.5 * WEDGE[0], WEDGE[1] * SLANTED[1, 2] / SLANTED[1, 1]
    rear = WEDGE_FRONT - WEDGE[1]
    points = [(x, y, z) for y, z in ((0, WEDGE_FRONT), (height, rear), (0, rear))
              for x in (-half, half)]  # fmt: skip
    return np.array(points), [(0, 1, 3, 2), (2, 3, 5, 4), (4, 5, 1, 0), (0, 2, 4), (1, 5, 3)]


def _place(right: Doubles, up: Doubles, facing: int) -> list[Doubles]:
    a, b = 2 * right - 1, 2 * up - 1
    x = 0.5 * SIDE * a * (1 - TAPER * b**2)
    y = 0.5 * SIDE * b * (1 - TAPER * a**2)
    # The two lie some millimetres apart; a ripple lets the seam decide where to pucker.
    bulge = (1 - a**2) * (1 - b**2) * (1 + 0.3 * np.sin(19 * a + 7 * b) * np.cos(17 * b - 5 * a))
    z = facing * 0.004 * bulge
    back = facing * x
    flat = np.stack(np.broadcast_arrays(back, z + 0.10, -y), axis=-1)
    middle = wedge()[0][:4].mean(axis=0)
    placed = flat @ SLANTED + middle
    return [x + facing, y, *np.moveaxis(placed, -1, 0)]
