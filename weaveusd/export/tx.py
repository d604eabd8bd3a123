"""Tiled, mip-mapped copies of textures (.tx) for renderers that read only what they show.

They stand beside the EXR and PNG files of a cloth and no layer names them: a renderer finds them
by name, and one that does not know the format still finds the rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import OpenImageIO as oiio  # noqa: N813

from weaveusd.contract import CHANNELS, MOMENT_MAPS, SYSTEMS, TX_SUFFIX
from weaveusd.export.bands import read_bands
from weaveusd.export.mipmap import Halving, smaller_levels
from weaveusd.export.moments import moment_channel
from weaveusd.export.tiled import TiledWriter

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.contract import Channel
    from weaveusd.export.files import LookFiles
    from weaveusd.export.images import Metadata

    Floats = NDArray[np.float32]

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
    """Write all levels of `source`, weighed by the texture `opacity` where there is one."""
    width, height, channels, metadata = _like(source, channel)
    halving = Halving(width, height, channels)
    with TiledWriter(source.with_suffix(TX_SUFFIX), width, height, channels, metadata) as out:
        for values, weight in _bands(source, opacity):
            halving.add(values, weight)
            out.write(values.astype(np.float16))
        for values, _ in smaller_levels(halving):
            out.write(values.astype(np.float16))


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


def _like(source: Path, channel: Channel) -> tuple[int, int, int, dict[str, Metadata]]:
    """Return width, height and channels of the image `source`, and what a copy says as it does."""
    found = oiio.ImageInput.open(str(source))
    spec = found.spec()
    found.close()
    metadata: dict[str, Metadata] = {a.name: a.value for a in spec.extra_attribs if a.name in _KEPT}
    if channel.encoding != "color":
        metadata["oiio:ColorSpace"] = "data"
    return spec.width, spec.height, spec.nchannels, metadata
