"""Where the objects of the examples stand: a Cornell box, a ground under a sky, a studio."""

from __future__ import annotations

from typing import TYPE_CHECKING

import author
import numpy as np

if TYPE_CHECKING:
    from pxr import Usd

SIDE = 0.56
"""Of the Cornell box in metres, that of the original."""


def cornell_box(stage: Usd.Stage, side: float = SIDE) -> None:
    """Add a box open to the front, its floor at y = 0, with a light in its ceiling and a camera."""
    half, top = side / 2, side
    walls = {
        "Floor": ("White", [(-half, 0, half), (half, 0, half), (half, 0, -half),
                            (-half, 0, -half)]),
        "Ceiling": ("White", [(-half, top, -half), (half, top, -half), (half, top, half),
                              (-half, top, half)]),
        "Back": ("White", [(-half, 0, -half), (half, 0, -half), (half, top, -half),
                           (-half, top, -half)]),
        "Left": ("Red", [(-half, 0, half), (-half, 0, -half), (-half, top, -half),
                         (-half, top, half)]),
        "Right": ("Green", [(half, 0, -half), (half, 0, half), (half, top, half),
                            (half, top, -half)]),
    }  # fmt: skip
    for name, color in (("White", author.WHITE), ("Red", author.RED), ("Green", author.GREEN)):
        author.add_look(stage, name, color)
    room = author.add_group(stage, "Room")
    for name, (look, corners) in walls.items():
        author.add_mesh(stage, f"{room}/{name}", np.array(corners), [(0, 1, 2, 3)], look)
    author.add_panel_light(
        stage, "Light", (0, 0.998 * top, 0.1 * top), (0, 0, 0.1 * top),
        (0.4 * top, 0.32 * top), 14.0, (1, 0.86, 0.68),
    )  # fmt: skip
    author.add_camera(stage, "Camera", (0, 0.53 * top, 2.2 * top), (0, 0.47 * top, 0), 1.14 * top)


def ground(
    stage: Usd.Stage, sky: str = "evening.exr", reach: float = 20.0, exposure: float = 0.6
) -> None:
    """Add a wide floor under the sky of a picture beside the stage."""
    author.add_look(stage, "Ground", (0.30, 0.29, 0.27))
    author.add_look(stage, "White", author.WHITE)
    corners = np.array([(-reach, 0, reach), (reach, 0, reach), (reach, 0, -reach),
                        (-reach, 0, -reach)])  # fmt: skip
    author.add_mesh(stage, "/World/Ground", corners, [(0, 1, 2, 3)], "Ground")
    author.add_dome(stage, sky, exposure)


def studio(stage: Usd.Stage) -> None:
    """Add a floor that curves up into a wall, lit by two panels and a little from all around."""
    author.add_look(stage, "Sweep", (0.42, 0.41, 0.39))
    bend, wall, width, front, top = 1.2, -1.6, 5.0, 4.0, 4.0
    turn = np.linspace(0, np.pi / 2, 25)
    profile = [(0.0, front), *zip(bend * (1 - np.cos(turn)), wall + bend - bend * np.sin(turn),
                                  strict=True), (top, wall)]  # fmt: skip
    rows = np.array([[(x, y, z) for x in (-width, width)] for y, z in profile])
    grid = np.arange(2 * len(profile)).reshape(-1, 2)
    quads = np.stack((grid[:-1, 0], grid[:-1, 1], grid[1:, 1], grid[1:, 0]), axis=1)
    author.add_mesh(stage, "/World/Sweep", rows.reshape(-1, 3), quads, "Sweep")
    author.add_panel_light(
        stage, "KeyLight", (-1.9, 2.3, 1.9), (0, 0.4, 0), (1.4, 1.4), 26.0, (1, 0.95, 0.88)
    )
    author.add_panel_light(
        stage, "FillLight", (2.4, 1.4, 1.4), (0, 0.4, 0), (1.2, 1.6), 7.0, (0.85, 0.92, 1)
    )
