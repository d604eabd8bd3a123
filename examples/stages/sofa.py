"""A sofa for two: an upholstered frame, four cushions, and the cord in their seams."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from colliders import Colliders
from cushions import FACES, Box, cord, rim, stuffed

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from panels import Panel, Sewn

    Doubles = NDArray[np.float64]

FOOT, SEAT, CUSHION, BACK, ARM = 0.15, 0.30, 0.45, 0.80, 0.60
"""Heights in metres: where the frame begins, its deck, the cushions on it, the back, the arms."""

INNER, OUTER = 0.66, 0.80
FRONT, MEET, WALL, REAR = 0.40, -0.10, -0.28, -0.42
"""Half widths between and over the arms; depths of the frame's front, of where the cushions of
seat and back meet, and of the back."""

CORD = 0.0045


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A cover at rest, and the cords in its seams."""

    name: str
    sewn: Sewn
    rest: Doubles
    cords: tuple[Panel, ...]


FRAME = {
    "Deck": Box.of((-INNER, FOOT, REAR), (INNER, SEAT, FRONT)),
    "Back": Box.of((-INNER, SEAT, REAR), (INNER, BACK, WALL)),
    "ArmLeft": Box.of((-OUTER, FOOT, REAR), (-INNER, ARM, FRONT)),
    "ArmRight": Box.of((INNER, FOOT, REAR), (OUTER, ARM, FRONT)),
}
CUSHIONS = {
    "SeatLeft": Box.of((-INNER, SEAT, MEET), (0, CUSHION, FRONT + 0.02)),
    "SeatRight": Box.of((0, SEAT, MEET), (INNER, CUSHION, FRONT + 0.02)),
    "BackLeft": Box.of((-INNER, SEAT, WALL), (0, BACK + 0.06, MEET)),
    "BackRight": Box.of((0, SEAT, WALL), (INNER, BACK + 0.06, MEET)),
}
_ARM, _SEAT, _BACK = ("front",), ("top", "bottom"), ("front", "back")
CORDED = {
    "ArmLeft": _ARM, "ArmRight": _ARM, "SeatLeft": _SEAT, "SeatRight": _SEAT,
    "BackLeft": _BACK, "BackRight": _BACK,
}  # fmt: skip
"""Faces with a cord around them."""


def sofa(cell: float) -> list[Piece]:
    """Return the pieces of the sofa, of quads about `cell` metres wide."""
    pieces = [_frame_piece(name, box, cell) for name, box in FRAME.items()]
    for name, box in CUSHIONS.items():
        solids = Colliders(0.001)
        for other in FRAME.values():
            solids.box(other.center, other.half)
        # A cushion knows its neighbors as boxes: the one beside it, and the one behind or before.
        side = -1 if name.endswith("Left") else 1
        solids.box((-0.5 * side * OUTER, 0.6, 0), (0.5 * OUTER, 0.6, 1))
        if name.startswith("Back"):
            solids.box((0, 0.5 * CUSHION, MEET + 0.5), (1, 0.5 * CUSHION, 0.5))
        else:
            solids.box((0, 0.5, MEET - 0.5), (1, 0.5, 0.5))
        fill = 1.16 if name.startswith("Back") else 1.04
        sewn, rest = stuffed(box, cell, solids, fill=fill, pressure=2500.0, gravity=9.81)
        pieces.append(_piece(name, sewn, rest))
    return pieces


def _frame_piece(name: str, box: Box, cell: float) -> Piece:
    """Return a cover over a board: it crowns a little, and does not hang."""
    core = Colliders(0.0).box(box.center, box.half - 0.002)
    sewn, rest = stuffed(box, cell, core, fill=1.03, pressure=800.0, gravity=0.0)
    return _piece(name, sewn, rest)


def _piece(name: str, sewn: Sewn, rest: Doubles) -> Piece:
    faces = CORDED.get(name, ())
    rims = (rest[rim(sewn.ids[FACES.index(face)])] for face in faces)
    return Piece(name, sewn, rest, tuple(cord(path, CORD) for path in rims))
