from __future__ import annotations

import numpy as np
import pytest

from weaveusd.render.lights import panorama

ROWS = 64
SIZE = (ROWS, 2 * ROWS)

DIRECTIONS = {
    "+x": (1, 0, 0), "-x": (-1, 0, 0), "+y": (0, 1, 0), "-y": (0, -1, 0), "+z": (0, 0, 1),
    "-z": (0, 0, -1),
}  # fmt: skip


def rendered(layout: str, shape: tuple[int, int]) -> np.ndarray:
    """A picture of the layout whose color is 1 + its direction, made texel by texel.

    Written from the inside out: from a texel to the direction it shows, the inverse of what
    the module does.
    """
    height, width = shape
    y, x = np.meshgrid(np.arange(height) + 0.5, np.arange(width) + 0.5, indexing="ij")
    u, v = 2 * x / width - 1, 1 - 2 * y / height
    if layout == panorama.CROSS:
        toward = cross(height, width)
    else:
        r = np.hypot(u, v)
        angle = np.pi * r if layout == panorama.ANGULAR else 2 * np.arcsin(np.clip(r, 0, 1))
        sine = np.sin(angle) / np.maximum(r, 1e-9)
        toward = np.stack([u * sine, v * sine, np.cos(angle)], -1)
    return (1 + toward).astype(np.float32)


def cross(height: int, width: int) -> np.ndarray:
    side = width // 3
    made = np.zeros((height, width, 3))
    s = 2 * (np.arange(side) + 0.5) / side - 1
    up, right = np.meshgrid(-s, s, indexing="ij")
    faces = {  # (row, column): forward, right, up
        (1, 1): ("+z", "-x", "+y"), (1, 0): ("+x", "+z", "+y"), (1, 2): ("-x", "-z", "+y"),
        (0, 1): ("+y", "-x", "-z"), (2, 1): ("-y", "-x", "+z"), (3, 1): ("-z", "-x", "-y"),
    }  # fmt: skip
    for (row, column), names in faces.items():
        a, b, c = (np.array(DIRECTIONS[name], float) for name in names)
        toward = a + right[..., None] * b + up[..., None] * c
        toward /= np.linalg.norm(toward, axis=-1, keepdims=True)
        made[row * side : (row + 1) * side, column * side : (column + 1) * side] = toward
    return made


@pytest.mark.parametrize(
    ("layout", "shape", "worst"),
    [
        (panorama.ANGULAR, (128, 128), 0.02),
        (panorama.BALL, (256, 256), 0.05),
        (panorama.CROSS, (128, 96), 0.03),
    ],
)
def test_every_layout_shows_each_direction_where_its_definition_says(
    layout: str, shape: tuple[int, int], worst: float
) -> None:
    made = panorama.to_latlong(rendered(layout, shape), layout)
    assert made.shape[1] == 2 * made.shape[0]
    wanted = 1 + panorama.directions(made.shape[:2], np.arange(made.shape[0]))
    off = np.abs(made - wanted).max(axis=-1)
    # The rim of a ball shows what lies behind it, all in its last texels.
    behind = wanted[..., 2] - 1 < -0.98
    assert off[~behind].max() < worst


def test_a_picture_turned_by_nothing_is_itself() -> None:
    pixels = np.random.default_rng(1).random((*SIZE, 3)).astype(np.float32)
    turned = panorama.resampled(pixels, panorama.LATLONG, SIZE, np.eye(3))
    inner = slice(1, -1)  # at a pole, every column is the same direction
    assert turned[inner] == pytest.approx(pixels[inner], abs=1e-4)


def test_a_turn_about_the_pole_rolls_the_columns() -> None:
    pixels = np.random.default_rng(2).random((*SIZE, 3)).astype(np.float32)
    angle = 2 * np.pi / SIZE[1] * 5
    c, s = np.cos(angle), np.sin(angle)
    about_y = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    turned = panorama.resampled(pixels, panorama.LATLONG, SIZE, about_y)
    # A greater longitude lies to the left.
    assert turned[1:-1] == pytest.approx(np.roll(pixels, 5, axis=1)[1:-1], abs=1e-4)


def test_the_flux_of_a_picture_is_its_integral_over_the_sphere() -> None:
    """4π for 1 everywhere; ∫ (1 + d) dω = 4π in every channel, the direction's mean being 0."""
    toward = panorama.directions(SIZE, np.arange(ROWS))
    assert panorama.flux(np.ones((*SIZE, 3), np.float32)) == pytest.approx(4 * np.pi, rel=1e-6)
    assert panorama.flux((1 + toward).astype(np.float32)) == pytest.approx(4 * np.pi, rel=1e-5)
    squares = panorama.flux((toward**2).astype(np.float32))
    assert squares == pytest.approx(4 * np.pi / 3, rel=1e-3)


def test_a_cross_of_another_shape_is_refused() -> None:
    with pytest.raises(ValueError, match="is 64 x 64 texels, expected a cross of 3 x 4 squares"):
        panorama.to_latlong(np.zeros((64, 64, 3), np.float32), panorama.CROSS)
