"""A flat swatch with pinked edges, and what lies beside it: a rule and three gray chips."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from panels import Sewn, plane, sew

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

SIDE = 0.05
TOOTH = 0.0025
THICKNESS = 0.0006
RULE_LENGTH, RULE_WIDTH = 0.06, 0.0085
CHIPS = {"Black": 0.03, "Gray": 0.18, "White": 0.90}
CHIP_SIDE = 0.009


def swatch() -> tuple[Sewn, Doubles]:
    """Return a square of 5 cm that lies flat, warp away from the camera, and its vertices."""
    teeth = round(SIDE / TOOTH)

    def place(right: Doubles, up: Doubles) -> list[Doubles]:
        # Every other vertex of an edge is drawn in.
        row, column = np.rint(2 * teeth * up).astype(int), np.rint(2 * teeth * right).astype(int)
        s = SIDE * right + np.where(row % 2 == 1, _drawn_in(column, 2 * teeth), 0.0)
        t = SIDE * up + np.where(column % 2 == 1, _drawn_in(row, 2 * teeth), 0.0)
        return [s, t, s - SIDE / 2, np.full_like(s, THICKNESS), SIDE / 2 - t]

    sewn = sew([plane(2 * teeth, 2 * teeth, place)])
    return sewn, sewn.start


def rule() -> dict[str, tuple[Doubles, Indices]]:
    """Return points and quads of a rule before the swatch, and of its marks every millimetre.

    A mark is 2 mm long, at 5 mm 3.5 and at a centimetre 5.
    """
    near = SIDE / 2 + 0.003
    board = _rectangle(-RULE_LENGTH / 2, RULE_LENGTH / 2, near, near + RULE_WIDTH, THICKNESS)
    marks = []
    for k in range(round(1000 * RULE_LENGTH) + 1):
        x = 0.001 * k - RULE_LENGTH / 2
        length = 0.005 if k % 10 == 0 else 0.0035 if k % 5 == 0 else 0.002
        left, right = max(x - 8e-5, -RULE_LENGTH / 2), min(x + 8e-5, RULE_LENGTH / 2)
        marks.append(_rectangle(left, right, near, near + length, 1.02 * THICKNESS))
    return {
        "Rule": (board, np.array([(0, 1, 2, 3)])),
        "Marks": (np.concatenate(marks), np.arange(4 * len(marks)).reshape(-1, 4)),
    }


def chips() -> dict[str, tuple[Doubles, Indices]]:
    """Return points and quads of the gray chips, in a row behind the swatch."""
    far = -SIDE / 2 - 0.003
    result = {}
    for k, name in enumerate(CHIPS):
        left = -SIDE / 2 + k * (CHIP_SIDE + 0.002)
        points = _rectangle(left, left + CHIP_SIDE, far - CHIP_SIDE, far, THICKNESS)
        result[name] = (points, np.array([(0, 1, 2, 3)]))
    return result


def _drawn_in(index: Indices, last: int) -> Doubles:
    return np.where(index == 0, 0.3 * TOOTH, np.where(index == last, -0.3 * TOOTH, 0.0))


def _rectangle(left: float, right: float, far: float, near: float, height: float) -> Doubles:
    return np.array(((left, height, near), (right, height, near),
                     (right, height, far), (left, height, far)))  # fmt: skip
