"""Whether mip-mapped copies of the textures are whole, and copies."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO

from weaveusd.contract import CHANNELS, MAX_MOMENT_TEXELS, TX_SUFFIX, Channel
from weaveusd.errors import InputError
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.moment_maps import MAP_FILES
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import MAX_SIDE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

BROKEN = Code("mip-broken", Status.FAIL, "A .tx file does not open, or is not tiled.")
LEVELS = Code("mip-missing", Status.FAIL, "A .tx file does not have every level down to one texel.")
OTHER = Code("mip-disagrees", Status.FAIL, "The first level of a .tx file is not its texture.")
RANGE = Code("mip-range", Status.FAIL, "A coarse level holds what no mean of the texture can be.")

ROWS = 64
"""Rows of the first level that are compared, in each of three places."""

LARGEST = 256
"""Width and height up to which a level is looked at as a whole."""

STEP = 1 / 255 / 2 + 2.0**-10
"""Rounding of 8 bits, or of half floats."""


@check(
    id="texture/mip-chains",
    why="A renderer that finds a .tx shows nothing else: one of last week is another cloth.",
    needs=("material",),
    codes=(BROKEN, LEVELS, OTHER, RANGE),
)
def mip_chains(asset: OpenAsset) -> Iterator[Finding]:
    """Every .tx beside a texture is that texture, tiled, with every level down to one texel."""
    # The copy is of the linear file where there are two.
    channels = {channel.files[-1]: channel for channel in CHANNELS.values()}
    for file in (*channels, *MAP_FILES):
        source = asset.textures.path(file)
        path = source.with_suffix(TX_SUFFIX)
        if not path.is_file():
            continue
        where = asset.short(path)
        opened = OpenImageIO.ImageInput.open(str(path))
        if opened is None:
            yield BROKEN(" ".join(OpenImageIO.geterror().split())[:200], where)
            continue
        try:
            yield from _judge(opened, channels.get(file), asset, file, where)
        finally:
            opened.close()


def _judge(
    opened: Any, channel: Channel | None, asset: OpenAsset, file: str, where: str
) -> Iterator[Finding]:
    """Judge the copy of a texture, or of a moment map where `channel` is None."""
    spec = opened.spec()
    header = None
    with suppress(InputError):
        header = asset.textures.header(file)
    if header is None:
        return  # texture/files reports it
    if spec.tile_width < 1 or max(spec.width, spec.height) > MAX_SIDE:
        yield BROKEN("is not tiled, or too large", where)
        return
    if (spec.width, spec.height, spec.nchannels) != (header.width, header.height, header.channels):
        yield OTHER(
            f"is {spec.width} x {spec.height} of {spec.nchannels} channels, its texture "
            f"{header.width} x {header.height} of {header.channels}",
            where,
        )
        return
    sizes = _sizes(opened)
    halved = all(
        after in ((max(1, w // 2), max(1, h // 2)), ((w + 1) // 2, (h + 1) // 2))
        for (w, h), after in pairwise(sizes)
    )
    if sizes[-1] != (1, 1) or not halved:
        shown = ", ".join(f"{w} x {h}" for w, h in sizes[:16])
        yield LEVELS(f"has the levels {shown}, expected halves down to 1 x 1", where)
    if (worst := _difference(opened, asset, file)) > STEP:
        yield OTHER(f"differs from {file} by {worst:.3g}", where)
    if channel is None:
        yield from _means(opened, sizes, where)
        return
    for level, size in enumerate(sizes):
        if max(size) <= LARGEST and not _is_mean(_whole(opened, level, size), channel):
            yield RANGE(f"level {level}, {size[0]} x {size[1]}, is out of range", where)


def _means(opened: Any, sizes: list[tuple[int, int]], where: str) -> Iterator[Finding]:
    """Judge the levels of a moment map: means of even pieces all have the mean of the whole."""
    first = None
    for level, size in enumerate(sizes):
        if size[0] * size[1] > MAX_MOMENT_TEXELS:
            return  # texture/moments reports it
        mean = _whole(opened, level, size).mean(axis=(0, 1), dtype=np.float64)
        first = mean if first is None else first
        if not (np.abs(mean - first) <= STEP).all():
            yield RANGE(
                f"level {level}, {size[0]} x {size[1]}, has another mean than the first", where
            )


def _sizes(opened: Any) -> list[tuple[int, int]]:
    sizes: list[tuple[int, int]] = []
    while len(sizes) < 32 and opened.seek_subimage(0, len(sizes)):
        spec = opened.spec()
        sizes.append((spec.width, spec.height))
    opened.seek_subimage(0, 0)
    return sizes


def _difference(opened: Any, asset: OpenAsset, file: str) -> float:
    """Return the largest difference to the texture, in three bands of rows; infinite for NaN."""
    spec = opened.spec()
    path = asset.textures.path(file)
    reading = OpenImageIO.ImageInput.open(str(path))
    if reading is None:
        return 0.0  # texture/files reports it
    worst = 0.0
    last = max(0, (spec.height - ROWS) // spec.tile_height * spec.tile_height)
    middle = last // 2 // spec.tile_height * spec.tile_height
    try:
        for first in sorted({0, middle, last}):
            end = min(first + ROWS, spec.height)
            mine = _tiles(opened, 0, (spec.width, first, end))[: end - first]
            theirs = reading.read_scanlines(
                0, 0, first, end, 0, 0, spec.nchannels, OpenImageIO.FLOAT
            )
            if theirs is None or mine.size == 0:
                return float("inf")
            found = np.abs(mine - np.asarray(theirs).reshape(mine.shape)).max()
            worst = max(worst, float(found)) if np.isfinite(found) else float("inf")
    finally:
        reading.close()
    return worst


def _whole(opened: Any, level: int, size: tuple[int, int]) -> Floats:
    return _tiles(opened, level, (size[0], 0, size[1]))


def _tiles(opened: Any, level: int, rows: tuple[int, int, int]) -> Floats:
    """Return rows `first` to `end` - 1 of a level, `rows` being width, first and end."""
    width, first, end = rows
    opened.seek_subimage(0, level)
    channels = opened.spec().nchannels
    found = opened.read_tiles(0, level, 0, width, first, end, 0, 1, 0, channels, OpenImageIO.FLOAT)
    if found is None:
        return np.full((0, width, channels), np.nan, np.float32)
    return np.asarray(found, np.float32).reshape(end - first, width, channels)


def _is_mean(values: Floats, channel: Channel) -> bool:
    """Whether `values`, (h, w, c), can be means of the channel's texels."""
    if values.size == 0 or not np.isfinite(values).all():
        return False
    if channel.encoding == "vector" or channel.name == "fibre_angle":
        return bool((np.linalg.norm(values, axis=-1) <= 1 + 4 * STEP).all())
    if channel.name == "height":
        return bool((values <= STEP).all())
    return bool(((values >= -STEP) & (values <= 1 + STEP)).all())
