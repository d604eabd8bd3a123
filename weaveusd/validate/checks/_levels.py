"""EXR files in tiles with mip levels: what they hold, read level by level in bounded pieces."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO

from weaveusd.errors import InputError
from weaveusd.validate.textures import MAX_SIDE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

ROWS = 64
"""Rows of the first level that are looked at, in each of three places."""

LARGEST = 256
"""Width and height up to which a level is looked at as a whole."""

MAX_LEVELS = 32

MAX_TILE = 256
"""Rows of a tile that are read at once."""


class Chain:
    """The levels of a file that is open; `sizes` are width and height of each, the finest first."""

    def __init__(self, source: Any) -> None:
        self._source = source
        spec = source.spec()
        self.channels: int = spec.nchannels
        self.tile_height: int = spec.tile_height
        self.sizes: list[tuple[int, int]] = []
        while len(self.sizes) < MAX_LEVELS and source.seek_subimage(0, len(self.sizes)):
            spec = source.spec()
            self.sizes.append((spec.width, spec.height))

    def fault(self) -> str | None:
        """Return how the levels are not halves down to one texel, or None when they are."""
        halved = all(
            after in ((max(1, w // 2), max(1, h // 2)), ((w + 1) // 2, (h + 1) // 2))
            for (w, h), after in pairwise(self.sizes)
        )
        if self.sizes[-1] == (1, 1) and halved:
            return None
        shown = ", ".join(f"{w} x {h}" for w, h in self.sizes[:16])
        return f"has the levels {shown}, expected halves down to 1 x 1"

    def places(self) -> list[tuple[int, int]]:
        """Return first row and the one behind the last of three bands of the first level.

        They begin where tiles do.
        """
        height, tile = self.sizes[0][1], self.tile_height
        rows = -(-ROWS // tile) * tile
        last = max(0, (height - rows) // tile * tile)
        middle = last // 2 // tile * tile
        return [(first, min(first + rows, height)) for first in sorted({0, middle, last})]

    def rows(self, level: int, first: int, end: int) -> Floats:
        """Return rows `first` to `end` - 1 of a level, (rows, width, c); none if not readable."""
        width = self.sizes[level][0]
        self._source.seek_subimage(0, level)
        found = self._source.read_tiles(
            0, level, 0, width, first, end, 0, 1, 0, self.channels, OpenImageIO.FLOAT
        )
        if found is None:
            return np.zeros((0, width, self.channels), np.float32)
        return np.asarray(found, np.float32).reshape(end - first, width, self.channels)

    def small(self) -> Iterator[tuple[int, Floats]]:
        """Yield number and texels of each level that is looked at as a whole."""
        for level, size in enumerate(self.sizes):
            if max(size) <= LARGEST:
                yield level, self.rows(level, 0, size[1])


@contextmanager
def opened_chain(path: Path) -> Iterator[Chain]:
    """Open the file at `path`.

    Raises
    ------
    InputError
        It is no image in tiles, or one too large; the message is without the path.
    """
    source = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        raise InputError(" ".join(OpenImageIO.geterror().split())[:200])
    try:
        spec = source.spec()
        has_tiles = spec.tile_width > 0 and 0 < spec.tile_height <= MAX_TILE
        if not has_tiles or max(spec.width, spec.height) > MAX_SIDE:
            raise InputError(f"is not in tiles of at most {MAX_TILE} rows, or too large")
        yield Chain(source)
    finally:
        source.close()
