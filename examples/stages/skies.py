"""Skies of the examples, as lat-long pictures: +y up, the horizon in the middle row.

The middle column lies on +z, one a quarter to the left on +x, as UsdLux has it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import OpenImageIO as oiio  # noqa: N813

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

CLEAR_SIZE, EVENING_SIZE = (64, 128), (128, 256)
GROUND = np.array((0.16, 0.15, 0.13))

SUN = np.array((-0.62, 0.48, 0.62)) / np.linalg.norm((-0.62, 0.48, 0.62))
"""Direction of the evening's sun: left, low, behind the camera."""

SUN_WIDTH = 0.045
"""Radians; a haze makes the sun wide enough for a picture of this size."""

SUN_RADIANCE = np.array((230.0, 165.0, 95.0))


def write_clear_sky(path: Path) -> None:
    """Write a clear sky without a sun."""
    up = _directions(*CLEAR_SIZE)[..., 1:2]
    zenith, horizon = np.array((0.16, 0.30, 0.62)), np.array((0.62, 0.70, 0.80))
    sky = zenith + (horizon - zenith) * (1 - np.clip(up, 0, 1)) ** 4
    _write(path, np.where(up > 0, sky, GROUND))


def write_evening_sky(path: Path) -> None:
    """Write a sky that is blue overhead and warm towards a hazy sun."""
    way = _directions(*EVENING_SIZE)
    up, facing = way[..., 1:2], (way @ SUN)[..., None]
    zenith, horizon = np.array((0.17, 0.26, 0.46)), np.array((0.58, 0.60, 0.64))
    sky = zenith + (horizon - zenith) * (1 - np.clip(up, 0, 1)) ** 5
    glow = np.exp((facing - 1) / 0.12) * np.array((0.9, 0.55, 0.25))
    disk = np.exp((facing - 1) / SUN_WIDTH**2 * 2) * SUN_RADIANCE
    # Haze below the horizon, so that a floor ends in it without a dark line.
    below = GROUND + (horizon - GROUND) * np.clip(1 + 4 * up, 0, 1)
    _write(path, np.where(up > 0, sky + glow + disk, below))


def _directions(rows: int, columns: int) -> Doubles:
    """Return the unit vector (rows, columns, 3) of each pixel's middle."""
    elevation = (0.5 - (np.arange(rows) + 0.5) / rows)[:, None] * np.pi
    # Columns run from -z over +x, +z and -x back to -z as seen from inside.
    around = ((np.arange(columns) + 0.5) / columns - 0.5)[None, :] * 2 * np.pi
    level = np.cos(elevation)
    parts = (-level * np.sin(around), np.sin(elevation), level * np.cos(around))
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def _write(path: Path, pixels: Doubles) -> None:
    rows, columns = pixels.shape[:2]
    spec = oiio.ImageSpec(columns, rows, 3, oiio.HALF)
    spec.attribute("DateTime", "1980:01:01 00:00:00")
    spec.attribute("compression", "zip")
    writer = oiio.ImageOutput.create(str(path))
    if not (
        writer
        and writer.open(str(path), spec)
        and writer.write_image(np.ascontiguousarray(pixels, np.float32))
        and writer.close()
    ):
        raise SystemExit(f"{path}: {oiio.geterror()}")
