"""The maps of a U3M material: RGB, which every reader has to know, and the mean of each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.export.bands import across_fibre, codes_of, per_yarn, read_bands, size_of, vectors
from weaveusd.export.images import ImageWriter, density
from weaveusd.yarn.color import decode_srgb

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.export.bands import Floats, Rows
    from weaveusd.export.files import LookFiles
    from weaveusd.shading.material import StandardFit

    Bytes = NDArray[np.uint8]
    Counts = NDArray[np.int64]

Triple = tuple[float, float, float]

ALPHA, ROUGHNESS = "alpha", "roughness"
ANISOTROPY, ROTATION = "anisotropy_value", "anisotropy_rotation"
MAPS = (ALPHA, ROUGHNESS, ANISOTROPY, ROTATION)
"""Maps that a U3M has for itself; its base color and normals are the cloth's own textures."""

_SOURCES = {
    "base_color": "base_color.png",
    "opacity": "opacity.png",
    "normal": "normal.png",
    "tangent": "tangent.png",
    "yarn_id": "yarn_id.png",
}
_DIGITS = 6


@dataclass(frozen=True, slots=True)
class Means:
    """Means over a map: of the numbers of `MAPS`, of the linear color, of the normal (unit)."""

    numbers: dict[str, float]
    color: Triple
    normal: Triple


@dataclass(frozen=True, slots=True)
class PrincipledLobe:
    """Roughness r and anisotropy a of the principled shader (Burley 2012).

    ``α_across = r² / k`` and ``α_along = r² k`` with ``k = sqrt(1 - 0.9 a)``; more than a tenfold
    stretch is beyond it.
    """

    roughness: float
    anisotropy: float


def principled_lobe(fit: StandardFit) -> PrincipledLobe:
    """Return the lobe whose GGX roughnesses are those of `fit`, or nearest to them."""
    stretch = fit.alpha_along / fit.alpha_across
    return PrincipledLobe(
        (fit.alpha_along * fit.alpha_across) ** 0.25, min(1.0, (1 - stretch) / 0.9)
    )


def write_maps(
    asset: Path,
    files: LookFiles,
    fits: Sequence[StandardFit],
    size_mm: tuple[float, float],
    maps: dict[str, Path],
) -> Means:
    """Write `maps`, a path for each of `MAPS`, of the look `files` of the asset in `asset`.

    The rotation is that of the direction across the fibre, counter-clockwise from x, 1 being a
    whole turn. Half a turn is none, so values lie from 3/8 to 7/8: no fibre of warp or weft is
    near the ends, and a filter finds no jump.

    Raises
    ------
    InputError
        A texture is missing or broken.
    WeaveusdError
        A map could not be written.
    """
    sources = {key: asset / files.texture(name) for key, name in _SOURCES.items()}
    width, height = size_of(sources["opacity"])
    lobes = [principled_lobe(fit) for fit in fits]
    totals = dict.fromkeys(MAPS, 0)
    colors = np.zeros((3, 256), np.int64)
    levels = np.zeros(3, np.int64)
    metadata = {**density(width, height, size_mm), "oiio:ColorSpace": "data"}
    with ExitStack() as stack:
        writers = {
            name: stack.enter_context(ImageWriter(path, width, height, 3, "uint8", metadata))
            for name, path in maps.items()
        }
        for rows in read_bands(sources):
            for name, codes in _made(rows, lobes):
                totals[name] += int(codes.sum(dtype=np.int64))
                writers[name].write(np.repeat(codes[..., None], 3, axis=-1))
            colors += _histograms(rows["base_color"])
            levels += rows["normal"].sum((0, 1), dtype=np.int64)
    texels = width * height
    numbers = {name: round(total / texels / 255, _DIGITS) for name, total in totals.items()}
    return Means(numbers, _mean_color(colors), _mean_normal(levels, texels))


def _made(rows: Rows, lobes: Sequence[PrincipledLobe]) -> Iterator[tuple[str, Bytes]]:
    yield ALPHA, rows["opacity"][..., 0]
    yield ROUGHNESS, codes_of(per_yarn(rows, [lobe.roughness for lobe in lobes], 1.0))
    yield ANISOTROPY, codes_of(per_yarn(rows, [lobe.anisotropy for lobe in lobes], 0.0))
    across = across_fibre(vectors(rows["normal"]), vectors(rows["tangent"]))
    yield ROTATION, codes_of(half_turns(across))


def half_turns(directions: Floats) -> Floats:
    """Return the angles (…) of `directions` (…, 2) to x in turns, 3/8 to 7/8, modulo 1/2.

    By polynomial (Abramowitz & Stegun 4.4.49, within 1e-5 radians), for the arc tangents of
    different machines differ in their last bit.
    """
    x, y = directions[..., 0].astype(np.float64), directions[..., 1].astype(np.float64)
    steep = np.abs(y) > np.abs(x)
    q = np.where(steep, x, y) / np.where(steep, y, x)
    square = q * q
    series = square * 0.0208351 - 0.0851330
    for term in (0.1801410, -0.3302995, 0.9998660):
        series = series * square + term
    turns = q * series / (2 * math.pi)
    return (np.where(steep, 0.25 - turns, turns) + 0.5).astype(np.float32)


def _histograms(codes: Bytes) -> Counts:
    return np.stack([np.bincount(codes[..., k].ravel(), minlength=256) for k in range(3)])


def _mean_color(counts: Counts) -> Triple:
    """Return the mean of the linear colors that 8-bit codes under the sRGB curve stand for."""
    linear = [decode_srgb(code / 255) for code in range(256)]
    texels = int(counts[0].sum())
    red, green, blue = (
        math.fsum(int(n) * value for n, value in zip(channel, linear, strict=True)) / texels
        for channel in counts
    )
    return red, green, blue


def _mean_normal(levels: Counts, texels: int) -> Triple:
    x, y, z = (2 * int(level) / texels / 65535 - 1 for level in levels)
    length = math.hypot(x, y, z)
    return round(x / length, _DIGITS), round(y / length, _DIGITS), round(z / length, _DIGITS)
