"""The texture files of a cloth: encoded, flipped and written band by band.

In memory, row 0 lies at y = 0 and rows grow with y; in a file the top row has the highest y.
Rows are turned over here, and those of moment maps in `export.moments`; nowhere else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import CHANNELS, GAP, Channel, ColorSpace
from weaveusd.export.encode import encode
from weaveusd.export.images import ImageWriter, Metadata, density
from weaveusd.export.lobe_texels import fill_of_yarns
from weaveusd.synth.rows import thread_count

if TYPE_CHECKING:
    from weaveusd.export.lobes import YarnLobes
    from weaveusd.synth.model import Band, Floats32, TextureSet

Progress = Callable[[float], None]
"""Told the share of the work done, 0…1, never falling."""

BAND_TEXELS = 2**19


@dataclass(frozen=True, slots=True, eq=False)
class _Sink:
    """A texture file under way, and the channel that it carries."""

    channel: Channel
    suffix: str
    color_space: ColorSpace
    writer: ImageWriter

    def append(self, values: Floats32) -> None:
        """Write rows of the channel, the top one first, below those written so far."""
        self.writer.write(encode(self.channel, self.suffix, values, self.color_space))


def write_textures(
    textures: TextureSet,
    folder: Path,
    lobes: YarnLobes,
    *,
    color_space: ColorSpace = "lin_rec709",
    also: Sequence[Callable[[Band], object]] = (),
    jobs: int | None = None,
    progress: Progress | None = None,
) -> float:
    """Write every channel of `textures` into `folder` and return the mean of the opacity.

    `lobes` are those of the yarns. Loose hairs, where the opacity is neither 0 nor 1, scatter
    without direction: roughness 1. What
    else is made of the texels, `also`, is called with the rows of each band, the highest y first.

    Each band of rows is computed once and goes to all files, so that memory depends on
    `BAND_TEXELS` alone and not on the height. `jobs` threads, by default one for each core,
    encode a band, each one file at a time, while the next band is computed; one job does either.
    A thread calls one of `also`, bands in their order.
    Any number of jobs gives the same bytes.

    Files hold: EXR half floats, zip, wrap modes periodic, colors in `color_space`, which is that
    of `textures`, and vectors signed; `base_color.png` what a display shows of the EXR, clipped
    to Rec.709, 8 bits under the sRGB curve (IEC 61966-2-1); vectors in PNG 16 bits,
    `round((q/2 + 1/2) · 65534)`; opacity 8 bits; yarn ids 8 bits, index plus one.
    All state the physical size as pixels per inch.

    Raises
    ------
    ValueError
        A band lacks a channel, or has another shape, a value that is not finite or a yarn
        index that 8 bits do not hold; or there is less than one job.
    WeaveusdError
        A file could not be written.
    """
    opaque = 0.0
    threads = thread_count(jobs)
    with ExitStack() as stack:
        sinks = _open_all(textures, folder, color_space, stack)
        pool = stack.enter_context(ThreadPoolExecutor(threads))
        encoding: list[Future[object]] = []
        for first, last in _bands(textures.width, textures.height):
            rows = _rows(textures, first, last, lobes)
            opaque += float(np.sum(rows["opacity"], dtype=np.float64))
            _finish(encoding)
            encoding = [pool.submit(take, rows) for take in also]
            for sink in sinks:
                encoding.append(pool.submit(sink.append, rows[sink.channel.name]))
            if threads == 1:
                _finish(encoding)
            if progress is not None:
                progress((textures.height - first) / textures.height)
        _finish(encoding)
    return opaque / (textures.width * textures.height)


def _open_all(
    textures: TextureSet, folder: Path, color_space: ColorSpace, stack: ExitStack
) -> list[_Sink]:
    """Open the files of all channels in `stack`, those that take longest to encode first."""
    files = [(channel, name) for channel in CHANNELS.values() for name in channel.files]
    files.sort(key=lambda file: (file[0].encoding != "vector", not file[1].endswith(".png")))
    return [
        _Sink(
            channel,
            Path(name).suffix,
            color_space,
            stack.enter_context(
                open_texture(
                    folder / name,
                    channel,
                    (textures.width, textures.height),
                    textures.repeat_mm,
                    color_space,
                )
            ),
        )
        for channel, name in files
    ]


def _rows(textures: TextureSet, first: int, last: int, lobes: YarnLobes) -> dict[str, Floats32]:
    """Return rows `first` to `last` - 1 of every channel, the highest y first."""
    band = textures.band(first, last)
    rows = {
        name: _checked(band, name, last - first, textures.width)[::-1]
        for name, channel in CHANNELS.items()
        if not channel.per_yarn
    }
    return rows | _of_yarns(rows, lobes)


def _finish(tasks: Sequence[Future[object]]) -> None:
    """Wait for all of `tasks`, and raise what the first to fail has raised."""
    for task in tasks:
        task.result()


def _of_yarns(rows: Mapping[str, Floats32], lobes: YarnLobes) -> dict[str, Floats32]:
    """Return the channels that follow from the yarns' lobes; gaps are as loose hairs."""
    yarn, count = rows["yarn_id"], len(lobes.stretch)
    if yarn.min() < GAP or yarn.max() >= count:
        raise ValueError(f"yarn_id: {yarn.min()}…{yarn.max()} leaves the {count} yarns")
    roughness, rotation = np.empty_like(rows["opacity"]), np.empty_like(rows["normal"])
    fill_of_yarns(
        *(rows[name] for name in ("normal", "tangent", "opacity", "yarn_id")),
        lobes.roughness, lobes.stretch, roughness, rotation,
    )  # fmt: skip
    return {"roughness": roughness, "rotation": rotation}


_ACESCG: dict[str, Metadata] = {
    "oiio:ColorSpace": "lin_ap1_scene",
    # An EXR that states none is Rec.709.
    "chromaticities": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767),
}


def open_texture(
    path: Path,
    channel: Channel,
    size: tuple[int, int],
    repeat_mm: tuple[float, float],
    color_space: ColorSpace,
) -> ImageWriter:
    """Return a writer of `channel` in `size` texels, width and height, to the new file `path`.

    The file states what `write_textures` says of its kind.
    """
    width, height = size
    metadata = density(width, height, repeat_mm)
    if path.suffix == ".exr":
        dtype, space = "float16", "lin_rec709"
        metadata["wrapmodes"] = "periodic,periodic"
    else:
        dtype, space = "uint8", "srgb_rec709_scene"
    if channel.encoding != "color":
        space = "data"
    if channel.encoding == "vector" and path.suffix == ".png":
        dtype = "uint16"
        # The filter SUB: as small as libpng's own choice, in two thirds of the time.
        metadata["png:filter"] = 0x10
    if channel.name == "rotation" and path.suffix == ".png":
        # No filter: the codes repeat themselves, but no neighbor tells them.
        metadata["png:filter"] = 0x08
    metadata["oiio:ColorSpace"] = space
    if space == "lin_rec709" and color_space == "acescg":
        metadata |= _ACESCG
    return ImageWriter(path, width, height, channel.components, dtype, metadata)


def _bands(width: int, height: int) -> Iterator[tuple[int, int]]:
    """Yield (first, last) rows of all bands, the highest y first."""
    rows = max(1, BAND_TEXELS // width)
    for last in range(height, 0, -rows):
        yield max(0, last - rows), last


def _checked(band: Band, name: str, rows: int, width: int) -> Floats32:
    if name not in band:
        raise ValueError(f"the band lacks channel {name}")
    values = band[name]
    expected = (rows, width, CHANNELS[name].components)
    if values.shape != expected:
        raise ValueError(f"channel {name} has shape {values.shape}, expected {expected}")
    if not np.isfinite(values).all():
        raise ValueError(f"channel {name} holds values that are not finite")
    return values
