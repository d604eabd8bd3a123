"""Tiled, mip-mapped copies of textures (.tx) for renderers that read only what they show.

They stand beside the EXR and PNG files of a cloth and no layer names them: a renderer finds them
by name, and one that does not know the format still finds the rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813

from weaveusd.contract import CHANNELS, MOMENT_MAPS, SYSTEMS, TX_SUFFIX
from weaveusd.errors import WeaveusdError
from weaveusd.export.bands import read_bands
from weaveusd.export.mipmap import Halving, smaller_levels
from weaveusd.export.moments import moment_channel

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.contract import Channel
    from weaveusd.export.files import LookFiles

    Floats = NDArray[np.float32]

TILE = 64

OPACITY = "opacity.png"
FILTERED: tuple[str, ...] = (
    *(file for channel in CHANNELS.values() for file in channel.files if file.endswith(".exr")),
    OPACITY,
)
"""Textures that have a mean: all but the labels. Moment maps have one too."""

_KEPT = (
    "oiio:ColorSpace", "chromaticities", "ResolutionUnit", "XResolution", "YResolution",
    "PixelAspectRatio",
)  # fmt: skip


def write_tx(asset: Path, files: LookFiles) -> None:
    """Write a ``.tx`` beside each texture of `FILTERED` that the look `files` has for its own.

    So it does beside each of the look's own moment maps.
    Each is an OpenEXR file of half floats in tiles of 64, periodic, with all levels down to one
    texel. A level is the mean of the one above, weighed by opacity, so that no gap tints a color
    or tilts a normal; colors are linear. Moment maps hold what opacity has been multiplied into,
    so that theirs are plain means. Means of vectors are not brought to length 1: a renderer
    does that after it has filtered between levels, and the length says how much they differ. The
    same textures give the same bytes.

    Raises
    ------
    InputError
        A texture is missing or broken.
    WeaveusdError
        A file could not be written.
    """
    opacity = asset / files.texture(OPACITY)
    for channel in CHANNELS.values():
        for name in channel.files:
            if name in FILTERED and (not files.colorway or name in files.own):
                _copy(asset / files.texture(name), channel, opacity)
    for system in SYSTEMS:
        for channel in (moment_channel(system, name) for name in MOMENT_MAPS):
            source = asset / files.folder / channel.files[0]
            if source.is_file():
                _copy(source, channel, None)


def _copy(source: Path, channel: Channel, opacity: Path | None) -> None:
    target = source.with_suffix(TX_SUFFIX)
    _write(source, opacity, channel, target)
    _check_written(target)


def _write(source: Path, opacity: Path | None, channel: Channel, target: Path) -> None:
    """Write all levels; the file is whole when this has returned and its writer is gone."""
    writer = oiio.ImageOutput.create("openexr")
    spec = _spec(source, channel)
    if not writer.open(str(target), spec):
        raise _failure(target, writer)
    halving = Halving(spec.width, spec.height, spec.nchannels)
    rest = np.zeros((0, spec.width, spec.nchannels), np.float32)
    first = 0
    for values, weight in _bands(source, opacity):
        halving.add(values, weight)
        rest = np.concatenate([rest, values])
        whole = len(rest) // TILE * TILE
        if first + len(rest) == spec.height:
            whole = len(rest)
        _write_tiles(writer, target, first, rest[:whole])
        first, rest = first + whole, rest[whole:]
    for values, _ in smaller_levels(halving):
        spec.height, spec.width = values.shape[:2]
        spec.full_height, spec.full_width = spec.height, spec.width
        if not writer.open(str(target), spec, "AppendMIPLevel"):
            raise _failure(target, writer)
        _write_tiles(writer, target, 0, values)
    if not writer.close():
        raise _failure(target, writer)


def _bands(source: Path, opacity: Path | None) -> Iterator[tuple[Floats, Floats]]:
    """Yield values and weights of all rows of the texture `source`, in bands.

    The weights are those of the texture `opacity`; all are alike without it.
    """
    if opacity is None:
        for rows in read_bands({"values": source}):
            values: Floats = rows["values"]
            yield values, np.ones(values.shape[:2], np.float32)
        return
    for rows in read_bands({"values": source, "opacity": opacity}):
        weight = rows["opacity"][..., 0].astype(np.float32) / np.float32(255)
        if source == opacity:
            yield weight[..., None], np.ones_like(weight)
        else:
            yield rows["values"], weight


def _spec(source: Path, channel: Channel) -> Any:
    found = oiio.ImageInput.open(str(source))
    like = found.spec()
    found.close()
    spec = oiio.ImageSpec(like.width, like.height, like.nchannels, oiio.HALF)
    spec.channelnames = like.channelnames if source.suffix == ".exr" else ("Y",)
    for attribute in like.extra_attribs:
        if attribute.name in _KEPT:
            spec.attribute(attribute.name, attribute.type, attribute.value)
    if channel.encoding != "color":
        spec.attribute("oiio:ColorSpace", "data")
    spec.tile_width = spec.tile_height = TILE
    spec.attribute("compression", "zip")
    spec.attribute("wrapmodes", "periodic,periodic")
    spec.attribute("textureformat", "Plain Texture")
    spec.attribute("DateTime", "2000:01:01 00:00:00")
    spec.attribute("openexr:levelmode", 1)
    spec.attribute("openexr:roundingmode", 0)
    return spec


def _write_tiles(writer: Any, target: Path, first: int, values: Floats) -> None:
    if not len(values):
        return
    height, width = values.shape[:2]
    halves = np.ascontiguousarray(values, np.float16)
    if not writer.write_tiles(0, width, first, first + height, 0, 1, halves):
        raise _failure(target, writer)


def _check_written(target: Path) -> None:
    """Raise WeaveusdError unless the last tile of the first level and the last level are there.

    A full disk goes unnoticed by OpenImageIO at the end of an EXR.
    """
    written = oiio.ImageInput.open(str(target))
    if written is not None:
        spec = written.spec()
        corner = ((side - 1) // TILE * TILE for side in (spec.width, spec.height))
        tile = written.read_tile(*corner, 0, oiio.FLOAT)
        level = 0
        while written.seek_subimage(0, level + 1):
            level += 1
        last = written.read_image(0, level, 0, spec.nchannels, oiio.FLOAT)
        written.close()
        if tile is not None and last is not None:
            return
    raise WeaveusdError(f"{target}: cannot be written, is the disk full?")


def _failure(target: Path, writer: Any) -> WeaveusdError:
    reason = " ".join((writer.geterror() or oiio.geterror()).split()) or "no reason given"
    return WeaveusdError(f"{target}: cannot be written: {reason}")
