"""EXR files in tiles with all mip levels, written from the top row down, the finest level first."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813

from weaveusd.errors import WeaveusdError
from weaveusd.export.images import CONSTANT_TIME, state

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.export.images import Metadata

    Halves = NDArray[np.float16]

TILE = 64

_FORMAT: dict[str, Metadata] = {
    "compression": "zip",
    "wrapmodes": "periodic,periodic",
    "textureformat": "Plain Texture",
    "DateTime": CONSTANT_TIME,
    "openexr:levelmode": 1,  # mip maps
    "openexr:roundingmode": 0,  # down
}


def level_sizes(width: int, height: int) -> list[tuple[int, int]]:
    """Return width and height of every level, halves rounded down, to one texel."""
    sizes = [(width, height)]
    while sizes[-1] != (1, 1):
        width, height = max(1, width // 2), max(1, height // 2)
        sizes.append((width, height))
    return sizes


class TiledWriter:
    """A file of half floats in tiles of `TILE`, zip, periodic, with `level_sizes`.

    The rows of all levels are written one level after the other; the same rows give the same
    bytes. Readers that know no levels find the finest.

    Parameters
    ----------
    path
        The new file.
    width, height, channels
        Size of the finest level.
    metadata
        OpenImageIO attributes.

    Raises
    ------
    WeaveusdError
        The file could not be opened, written or, on leaving the context, closed whole.
    """

    __slots__ = ("_level", "_out", "_path", "_rest", "_row", "_sizes", "_spec")

    def __init__(
        self, path: Path, width: int, height: int, channels: int, metadata: Mapping[str, Metadata]
    ) -> None:
        spec = oiio.ImageSpec(width, height, channels, oiio.HALF)
        spec.tile_width = spec.tile_height = TILE
        state(spec, {**metadata, **_FORMAT})
        self._path, self._spec = path, spec
        self._sizes = level_sizes(width, height)
        self._level = self._row = 0
        self._rest: Halves = np.zeros((0, width, channels), np.float16)
        self._out: Any = oiio.ImageOutput.create("openexr")
        if not self._out.open(str(path), spec):
            raise self._failure()

    def write(self, rows: Halves) -> None:
        """Append `rows`, (n, width, channels), below those of the same level written so far."""
        width, height = self._sizes[self._level]
        if rows.dtype != np.float16 or rows.shape[1:] != (width, self._spec.nchannels):
            raise ValueError(f"{self._path}: unexpected rows {rows.shape} {rows.dtype}")
        rest = np.concatenate([self._rest, rows]) if len(self._rest) else rows
        ready = len(rest) // TILE * TILE
        if self._row + len(rest) == height:
            ready = len(rest)
        if ready:
            first, last = self._row, self._row + ready
            tiles = np.ascontiguousarray(rest[:ready])
            if not self._out.write_tiles(0, width, first, last, 0, 1, tiles):
                raise self._failure()
            self._row = last
        self._rest = rest[ready:]
        if self._row == height:
            self._next_level()

    def __enter__(self) -> TiledWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        closed = self._out.close()
        self._out = None  # the file is whole when its writer is gone
        if kind is not None:
            return
        if self._level < len(self._sizes):
            raise ValueError(f"{self._path}: {self._level} of {len(self._sizes)} levels written")
        if not closed or not _is_whole(self._path, len(self._sizes) - 1):
            raise WeaveusdError(f"{self._path}: cannot be written, is the disk full?")

    def _next_level(self) -> None:
        self._level += 1
        if self._level == len(self._sizes):
            return
        spec = self._spec
        spec.width, spec.height = spec.full_width, spec.full_height = self._sizes[self._level]
        if not self._out.open(str(self._path), spec, "AppendMIPLevel"):
            raise self._failure()
        self._row = 0
        self._rest = np.zeros((0, spec.width, spec.nchannels), np.float16)

    def _failure(self) -> WeaveusdError:
        reason = " ".join((self._out.geterror() or oiio.geterror()).split()) or "no reason given"
        return WeaveusdError(f"{self._path}: cannot be written: {reason}")


def _is_whole(path: Path, last: int) -> bool:
    """Whether the last tile of the first level and the `last` level can be read.

    A full disk goes unnoticed by OpenImageIO at the end of an EXR.
    """
    written = oiio.ImageInput.open(str(path))
    if written is None:
        return False
    try:
        spec = written.spec()
        corner = ((side - 1) // TILE * TILE for side in (spec.width, spec.height))
        if written.read_tile(*corner, 0, oiio.FLOAT) is None:
            return False
        return written.read_image(0, last, 0, spec.nchannels, oiio.FLOAT) is not None
    finally:
        written.close()
