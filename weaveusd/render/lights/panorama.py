"""Pictures of a whole environment: where a layout shows a direction, and how one becomes another.

Directions are those of a dome before it is placed, its top +Y. The lat-long layout has rows from
pole to pole, row r at the angle π r / (H - 1) from +Y, and columns that start at longitude +π,
longitude 0 being +Z and +π/2 being +X, as OpenEXR lays it out and Mitsuba's `envmap` reads it.

For the other layouts USD says no more than their names. A mirrored ball is taken as photographed
by a camera of USD on +Z: its middle shows +Z, its right side +X. An angular map is laid out the
same with the angle from +Z along its radius. A vertical cross unfolds the cube as seen from its
inside, +Z in the middle, +X to its left, +Y above and -Z upside down at the bottom.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Pixels = NDArray[np.float32]

LATLONG, BALL, ANGULAR, CROSS = "latlong", "mirroredBall", "angular", "cubeMapVerticalCross"

MAX_ROWS = 4096
"""Rows of a lat-long picture that is made from another one."""

_BLOCK = 32
"""Rows that are resampled at once."""

_Lookup = Callable[["Doubles", int, int], "tuple[Doubles, Doubles]"]


def to_latlong(pixels: Pixels, layout: str) -> Pixels:
    """Return a picture (H, W, 3) of the layout as lat-long, about as fine as it was.

    Raises
    ------
    ValueError
        For a cross that is not three faces wide and four high; the message is one line.
    """
    height, width = pixels.shape[:2]
    if layout == LATLONG:
        return pixels
    if layout == CROSS and height * 3 != width * 4:
        raise ValueError(f"is {width} x {height} texels, expected a cross of 3 x 4 squares")
    rows = 2 * height // 4 if layout == CROSS else height
    rows = min(max(rows, 16), MAX_ROWS)
    return resampled(pixels, layout, (rows, 2 * rows), np.eye(3))


def resampled(
    pixels: Pixels, layout: str, size: tuple[int, int], source_from_target: Doubles
) -> Pixels:
    """Return a lat-long picture of `size` (rows, columns), looked up bilinearly.

    `source_from_target` (3, 3) turns a direction of the new picture into one of `pixels`.
    """
    made = np.empty((*size, 3), np.float32)
    for begin in range(0, size[0], _BLOCK):
        rows = np.arange(begin, min(begin + _BLOCK, size[0]))
        toward = directions(size, rows) @ source_from_target.T
        y, x = _LOOKUPS[layout](toward, *pixels.shape[:2])
        made[rows] = _bilinear(pixels, y, x, wrap=layout == LATLONG)
    return made


def directions(size: tuple[int, int], rows: NDArray[np.int64]) -> Doubles:
    """Return the unit vectors (rows, columns, 3) that texels of a lat-long picture show."""
    theta = (math.pi * rows / (size[0] - 1))[:, None]
    longitude = math.pi - 2 * math.pi * (np.arange(size[1]) + 0.5) / size[1]
    across = np.sin(theta)
    parts = (across * np.sin(longitude), np.cos(theta), across * np.cos(longitude))
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def flux(pixels: Pixels) -> Doubles:
    """Return the integral of a lat-long picture over the sphere, (3,).

    Rows are interpolated linearly, so each counts by the integral of its hat: 2π times
    ``2 sin θ (1 - cos Δ) / Δ``, and ``1 - sin Δ / Δ`` at the poles.
    """
    count = pixels.shape[0]
    step = math.pi / (count - 1)
    weights = 2 * np.sin(step * np.arange(count)) * (1 - math.cos(step)) / step
    weights[[0, -1]] = 1 - math.sin(step) / step
    return np.asarray(2 * math.pi * weights @ pixels.mean(axis=1, dtype=np.float64))


def _latlong(toward: Doubles, height: int, width: int) -> tuple[Doubles, Doubles]:
    theta = np.arccos(np.clip(toward[..., 1], -1, 1))
    longitude = np.arctan2(toward[..., 0], toward[..., 2])
    x = (math.pi - longitude) / (2 * math.pi) * width - 0.5
    return theta / math.pi * (height - 1), x


def _ball(toward: Doubles, height: int, width: int) -> tuple[Doubles, Doubles]:
    # The normal halves the angle between the camera on +Z and the direction that is mirrored.
    doubled = toward + np.array((0.0, 0.0, 1.0))
    normal = doubled / np.maximum(np.linalg.norm(doubled, axis=-1, keepdims=True), 1e-9)
    return (1 - normal[..., 1]) / 2 * height - 0.5, (1 + normal[..., 0]) / 2 * width - 0.5


def _angular(toward: Doubles, height: int, width: int) -> tuple[Doubles, Doubles]:
    angle = np.arccos(np.clip(toward[..., 2], -1, 1))
    across = np.hypot(toward[..., 0], toward[..., 1])
    stretch = angle / math.pi / np.maximum(across, 1e-9)
    x, y = toward[..., 0] * stretch, toward[..., 1] * stretch
    return (1 - y) / 2 * height - 0.5, (1 + x) / 2 * width - 0.5


def _cross(toward: Doubles, height: int, width: int) -> tuple[Doubles, Doubles]:
    x, y, z = np.moveaxis(toward, -1, 0)
    depth = np.abs(toward).max(axis=-1)
    faces = (  # column and row of the face, where it is seen, its right and its up
        (1, 1, z == depth, -x, y), (0, 1, x == depth, z, y), (2, 1, -x == depth, -z, y),
        (1, 0, y == depth, -x, -z), (1, 2, -y == depth, -x, z), (1, 3, -z == depth, -x, -y),
    )  # fmt: skip
    side = width // 3
    down, across = np.zeros(x.shape), np.zeros(x.shape)
    for column, row, seen, right, up in faces:
        # Kept within the face, so that no texel of a neighbor is mixed in.
        u = np.clip((1 + right / depth) / 2 * side - 0.5, 0, side - 1) + column * side
        v = np.clip((1 - up / depth) / 2 * side - 0.5, 0, side - 1) + row * side
        down, across = np.where(seen, v, down), np.where(seen, u, across)
    return down, across


_LOOKUPS: dict[str, _Lookup] = {
    LATLONG: _latlong,
    BALL: _ball,
    ANGULAR: _angular,
    CROSS: _cross,
}


def _bilinear(pixels: Pixels, y: Doubles, x: Doubles, *, wrap: bool) -> Pixels:
    """Return texels at fractional rows and columns; columns wrap around or are clamped."""
    height, width = pixels.shape[:2]
    y = np.clip(y, 0, height - 1)
    if not wrap:
        x = np.clip(x, 0, width - 1)
    top, left = np.floor(y).astype(np.int64), np.floor(x).astype(np.int64)
    fy, fx = (y - top)[..., None].astype(np.float32), (x - left)[..., None].astype(np.float32)
    below, right = np.minimum(top + 1, height - 1), (left + 1) % width
    if not wrap:
        right = np.minimum(left + 1, width - 1)
    left = left % width
    upper = pixels[top, left] * (1 - fx) + pixels[top, right] * fx
    lower = pixels[below, left] * (1 - fx) + pixels[below, right] * fx
    return np.asarray(upper * (1 - fy) + lower * fy, np.float32)
