"""Whether mip-mapped copies of the textures are whole, and copies."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import OpenImageIO

from weaveusd.contract import CHANNELS, MAX_MOMENT_TEXELS, TX_SUFFIX, Channel
from weaveusd.errors import InputError
from weaveusd.validate.checks._levels import Chain, opened_chain
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.moment_maps import MAP_FILES
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

BROKEN = Code("mip-broken", Status.FAIL, "A .tx file does not open, or is not tiled.")
LEVELS = Code("mip-missing", Status.FAIL, "A .tx file does not have every level down to one texel.")
OTHER = Code("mip-disagrees", Status.FAIL, "The first level of a .tx file is not its texture.")
RANGE = Code("mip-range", Status.FAIL, "A coarse level holds what no mean of the texture can be.")

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
        path = asset.textures.path(file).with_suffix(TX_SUFFIX)
        if not path.is_file():
            continue
        try:
            header = asset.textures.header(file)
        except InputError:
            continue  # texture/files or texture/moments reports it
        where = asset.short(path)
        try:
            with opened_chain(path) as chain:
                size = header.width, header.height, header.channels
                yield from _judge(chain, channels.get(file), asset.textures.path(file), size, where)
        except InputError as error:
            yield BROKEN(str(error), where)


def _judge(
    chain: Chain, channel: Channel | None, texture: Path, size: tuple[int, int, int], where: str
) -> Iterator[Finding]:
    """Judge the copy of a texture, or of a moment map where `channel` is None."""
    width, height = chain.sizes[0]
    if (width, height, chain.channels) != size:
        yield OTHER(
            f"is {width} x {height} of {chain.channels} channels, its texture "
            f"{size[0]} x {size[1]} of {size[2]}",
            where,
        )
        return
    if fault := chain.fault():
        yield LEVELS(fault, where)
    if (worst := _difference(chain, texture)) > STEP:
        yield OTHER(f"differs from {texture.name} by {worst:.3g}", where)
    if channel is None:
        yield from _means(chain, where)
        return
    for level, texels in chain.small():
        if not _is_mean(texels, channel):
            yield RANGE(f"level {level}, {_size(chain, level)}, is out of range", where)


def _means(chain: Chain, where: str) -> Iterator[Finding]:
    """Judge the levels of a moment map: means of even pieces all have the mean of the whole."""
    first = None
    for level, (width, height) in enumerate(chain.sizes):
        if width * height > MAX_MOMENT_TEXELS:
            return  # texture/moments reports it
        texels = chain.rows(level, 0, height)
        mean = texels.sum(axis=(0, 1), dtype=np.float64) / max(1, texels[..., 0].size)
        first = mean if first is None else first
        if texels.size == 0 or not (np.abs(mean - first) <= STEP).all():
            yield RANGE(f"level {level}, {_size(chain, level)}, has not the mean of all", where)


def _size(chain: Chain, level: int) -> str:
    return "{} x {}".format(*chain.sizes[level])


def _difference(chain: Chain, texture: Path) -> float:
    """Return the largest difference to the texture, in three bands of rows; infinite for NaN."""
    reading = OpenImageIO.ImageInput.open(str(texture))
    if reading is None:
        return 0.0  # texture/files reports it
    worst = 0.0
    try:
        for first, end in chain.places():
            mine = chain.rows(0, first, end)
            theirs = reading.read_scanlines(
                0, 0, first, end, 0, 0, chain.channels, OpenImageIO.FLOAT
            )
            if theirs is None or mine.size == 0:
                return float("inf")
            found = np.abs(mine - np.asarray(theirs).reshape(mine.shape)).max()
            worst = max(worst, float(found)) if np.isfinite(found) else float("inf")
    finally:
        reading.close()
    return worst


def _is_mean(values: Floats, channel: Channel) -> bool:
    """Whether `values`, (h, w, c), can be means of the channel's texels."""
    if values.size == 0 or not np.isfinite(values).all():
        return False
    if channel.encoding == "vector" or channel.name == "fibre_angle":
        return bool((np.linalg.norm(values, axis=-1) <= 1 + 4 * STEP).all())
    if channel.name == "height":
        return bool((values <= STEP).all())
    return bool(((values >= -STEP) & (values <= 1 + STEP)).all())
