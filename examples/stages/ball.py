"""A ball in cloth that is true to scale where the camera looks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from panels import Panel, plane

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

RADIUS = 0.015
REACH = 0.995 * np.pi
"""Angle from the foremost point at which the cloth ends, a small hole on the hidden side."""


def ball_facing_z(cells: int) -> Panel:
    """Return a ball that stands on y = 0, of `cells`² quads around its foremost point.

    st is the distance along the surface in the direction of the vertex (azimuthal equidistant):
    true to scale around that point, stretched on the hidden side. The quads are those of a square
    drawn onto a disk (Shirley and Chiu 1997).
    """

    def place(right: Doubles, up: Doubles) -> list[Doubles]:
        a, b = 2 * right - 1, 2 * up - 1
        wide = np.abs(a) > np.abs(b)
        share = np.where(wide, a, b)
        lesser = np.where(wide, b, a) / np.where(share == 0, 1, share)
        turn = np.where(wide, np.pi / 4 * lesser, np.pi / 2 - np.pi / 4 * lesser)
        polar = REACH * share
        x, y = np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn)
        return [
            RADIUS * polar * np.cos(turn), RADIUS * polar * np.sin(turn),
            RADIUS * x, RADIUS * (1 + y), RADIUS * np.cos(polar),
        ]  # fmt: skip

    return plane(cells, cells, place)
