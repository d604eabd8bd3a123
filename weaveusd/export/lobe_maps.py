"""The lobe maps of a cloth: roughness and direction of its highlights, at every distance.

The finest level is each yarn's fit. A coarser texel is one lobe for all yarns below it: the mean
of their lobes as matrices, led to the fit of the whole tile by as much of the variance of the
tile's normals as lies below the texel. The coarsest texel is that fit (docs/decisions/0018).
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from itertools import pairwise
from pathlib import Path
from typing import IO, TYPE_CHECKING

import numpy as np

from weaveusd.contract import LOBE_MAPS, lobe_file
from weaveusd.export.images import density
from weaveusd.export.lobe_texels import MOMENTS, fill_lobes, fill_moments, halve_rows
from weaveusd.export.lobes import towards, yarn_lobes
from weaveusd.export.tiled import TILE, TiledWriter, level_sizes
from weaveusd.synth.boxes import columns_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.shading.material import ClothMaterial, StandardFits
    from weaveusd.synth.model import Band

    Floats = NDArray[np.float32]


@contextmanager
def lobe_maps(material: ClothMaterial, folder: Path) -> Iterator[Callable[[Band], None]]:
    """Give what takes the bands of `material`, the top one first, and makes its maps in `folder`.

    Bands are those that `write_textures` hands on: with the channels of the yarns' fits.

    Levels are halves of the one above, rounded down; a texel is the mean of what it covers,
    weighed by opacity. While bands come, the moments of all coarser levels, a third as many texels
    as the textures have, go to files without a name in `folder`; on leaving the context maps are
    made of them. So memory holds a band. The same texels give the same bytes, for any bands.

    Raises
    ------
    ValueError
        A fit of the cloth is out of range.
    WeaveusdError
        A file could not be written.
    """
    textures = material.textures
    size = textures.width, textures.height
    metadata = density(*size, textures.repeat_mm) | {"oiio:ColorSpace": "data"}
    with ExitStack() as stack:
        writers = {
            name: stack.enter_context(
                TiledWriter(folder / lobe_file(name), *size, lobe_map.components, metadata)
            )
            for name, lobe_map in LOBE_MAPS.items()
        }
        levels = [
            _Level(above, below, stack.enter_context(tempfile.TemporaryFile(dir=folder)))
            for above, below in pairwise(level_sizes(*size))
        ]
        maps = _Maps(material.fits, writers, levels)
        yield maps.add
        maps.write_coarse()


class _Maps:
    """The maps of a cloth under way: files that are open, and the levels below the finest."""

    def __init__(
        self, fits: StandardFits, writers: Mapping[str, TiledWriter], levels: Sequence[_Level]
    ) -> None:
        self._fits, self._writers, self._levels = fits, writers, levels
        self._lobes = yarn_lobes(fits)
        self._moments: Floats = np.empty((0, 0, len(MOMENTS)), np.float32)

    def add(self, band: Band) -> None:
        """Write a band of the finest level, below those written, and add it to all others."""
        rows, width = band["opacity"].shape[:2]
        if len(self._moments) < rows:
            # One piece of memory for all bands: new pages cost more than what fills them.
            self._moments = np.empty((rows, width, len(MOMENTS)), np.float32)
        moments, even = self._moments[:rows], np.empty((rows, width, 1), np.float32)
        lobes = self._lobes
        fill_moments(
            *(band[name] for name in ("normal", "opacity", "yarn_id", "rotation")),
            lobes.mean, lobes.even, lobes.preview_roughness, moments, even,
        )  # fmt: skip
        self._write({n: band[n] for n in ("roughness", "rotation")} | {"preview_roughness": even})
        for level in self._levels:
            moments = level.add(moments)

    def write_coarse(self) -> None:
        """Write all levels but the finest."""
        (top,) = self._levels[-1].bands()
        target = towards(top[0, 0], self._fits)
        for level in self._levels:
            for moments in level.bands():
                made = {
                    name: np.zeros((*moments.shape[:2], lobe_map.components), np.float32)
                    for name, lobe_map in LOBE_MAPS.items()
                }
                fill_lobes(moments, target, *made.values())
                self._write(made)

    def _write(self, texels: Mapping[str, Floats]) -> None:
        for name, writer in self._writers.items():
            writer.write(texels[name].astype(np.float16))


class _Level:
    """The moments of a level, made from the rows of the level above, and kept in `file`.

    `above` and `below` are the sizes of both, width and height.
    """

    def __init__(self, above: tuple[int, int], below: tuple[int, int], file: IO[bytes]) -> None:
        self._full, self._width, self._file = above[1], below[0], file
        self._cell, self._inside = columns_of(above[0], below[0])
        self._open, self._line = np.zeros((2, below[0], len(MOMENTS)))
        self._added = 0

    def add(self, rows: Floats) -> Floats:
        """Add rows of the level above; return those of this one that are complete by it."""
        done = np.empty((len(rows) // 2 + 2, self._width, len(MOMENTS)), np.float32)
        count = halve_rows(
            rows, self._added, self._full, self._cell, self._inside, self._line, self._open, done
        )
        self._added += len(rows)
        self._file.write(done[:count].tobytes())
        return done[:count]

    def bands(self) -> Iterator[Floats]:
        """Yield all rows, in bands of the height of a tile."""
        self._file.seek(0)
        size = TILE * self._width * len(MOMENTS) * np.dtype(np.float32).itemsize
        while data := self._file.read(size):
            yield np.frombuffer(data, np.float32).reshape(-1, self._width, len(MOMENTS))
