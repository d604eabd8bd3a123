"""Lines of texels on both sides of borders: of the edge, and of others inside to compare with."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.validate.compiled import compiled
from weaveusd.validate.textures import VECTOR_LEVELS, Band, TextureFolder

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.validate.checks._texels import Mask
    from weaveusd.validate.textures import Floats32, Words

    Bytes = NDArray[np.uint8]
    Places = NDArray[np.intp]

NORMAL, TANGENT = "normal.png", "tangent.png"
"""The 16 bits of the PNG resolve steps that half floats round away."""

IDS, OPACITY = "yarn_id.png", "opacity.png"

LINES = 128
"""Borders between lines of texels inside the texture with which each edge is compared."""

CREASE = 0.05
"""A normal that turns back by more than this from texel to texel has left its yarn."""


@dataclass(frozen=True, slots=True, eq=False)
class Strips:
    """Lines of texels on both sides of several borders; the border 0 is the edge.

    `places` says which line of the arrays lies where: 0 to 2 before a border and 3 to 5 after it,
    in the order of the axis.
    """

    axis: int  # 0 across rows, 1 across columns
    normal: Words  # (W, N, 3) as stored
    tangent: Words  # (W, N, 3) as stored
    ids: Bytes  # (W, N)
    places: Places  # (B, 6)

    def lean(self) -> Floats32:
        """Return (B, 6, N): how far normals lean forward along the axis."""
        # Image rows run against y.
        sign = np.float32(-1 if self.axis == 0 else 1)
        return sign * VECTOR_LEVELS[self.normal[self.places, :, 1 - self.axis]]

    def standing_out(self) -> tuple[Floats32, Floats32, Mask]:
        """Return by how much steps across each border exceed those before and after it.

        For normals, then for tangents, (B, N); and where that means something, (B, N): where the
        texels are of one yarn and the normal does not turn back.
        """
        shape = len(self.places), self.ids.shape[1]
        of_normal, of_tangent = np.zeros((2, *shape), np.float32)
        one_yarn = np.empty(shape, np.bool_)
        _stand_out(
            self.normal, self.tangent, self.ids, self.places[:, 1:5], self.axis, VECTOR_LEVELS,
            of_normal, of_tangent, one_yarn,
        )  # fmt: skip
        return of_normal, of_tangent, one_yarn


class StripReader:
    """Takes from each band the lines next to `borders`, places in `length` lines of `axis`."""

    def __init__(self, axis: int, length: int, borders: Places) -> None:
        self._axis, self._length = axis, length
        self._wanted = np.unique(self._beside(borders))
        self._parts: list[tuple[NDArray[Any], ...]] = []

    def look(self, band: Band) -> None:
        """Keep the lines that lie in `band`."""
        wanted = self._wanted
        if self._axis == 0:
            here = (wanted >= band.first) & (wanted < band.first + len(band.pixels[IDS]))
            wanted = wanted[here] - band.first
        normal, tangent, ids, opacity = (
            np.take(band.pixels[file], wanted, axis=self._axis)
            for file in (NORMAL, TANGENT, IDS, OPACITY)
        )
        self._parts.append((normal, tangent, solid_ids(ids, opacity)))

    def strips(self, borders: Places) -> Strips:
        """Return the lines next to `borders`, which are among those that were asked for."""
        places = np.searchsorted(self._wanted, self._beside(borders))
        return Strips(self._axis, *self._lines, places)

    @cached_property
    def _lines(self) -> tuple[Words, Words, Bytes]:
        """Normals, tangents and ids of the lines wanted, (W, N, …)."""
        normal, tangent, ids = (
            np.ascontiguousarray(np.swapaxes(np.concatenate(parts), 0, self._axis))
            for parts in zip(*self._parts, strict=True)
        )
        return normal, tangent, ids

    def _beside(self, borders: Places) -> Places:
        """Return (B, 6): three lines before and three after each border, beyond the edge too."""
        return (borders[:, None] + np.arange(-2, 4)) % self._length


def solid_ids(ids: Bytes, opacity: Bytes) -> Bytes:
    """Return (rows, width): the yarn `ids`, 0 in gaps and where there are but hairs.

    Loose hairs are half transparent and have no surface: their normal is up.
    """
    return np.where(opacity[..., 0] == 255, ids[..., 0], np.uint8(0))


def even_borders(length: int) -> Places:
    """Return the edge, then borders evenly spread inside, each by the line before it."""
    inside = np.linspace(2, length - 4, max(0, min(LINES, length - 5)))
    return np.concatenate([[length - 1], np.unique(inside.astype(int))])


def yarn_borders(textures: TextureFolder) -> tuple[Places, Places]:
    """Return, across rows and across columns, the edge and where most texels change their yarn.

    Raises InputError when the ids do not decode.
    """
    header = textures.header(IDS)
    by_row, by_column = np.zeros(header.height, np.int64), np.zeros(header.width, np.int64)
    above = np.empty((0, header.width), np.uint8)
    for band in textures.bands(IDS, OPACITY):
        ids = np.concatenate([above, solid_ids(band.pixels[IDS], band.pixels[OPACITY])])
        _count_changes(ids, by_row[band.first - len(above) :], by_column, len(above))
        above = ids[-1:]
    return _most(by_row), _most(by_column)


def _most(changes: NDArray[np.int64]) -> Places:
    length = len(changes)
    changes[:2], changes[length - 3 :] = 0, 0
    inside = np.sort(np.argsort(-changes, kind="stable")[: LINES // 2])
    return np.concatenate([[length - 1], inside[changes[inside] > 0]])


@compiled
def _count_changes(
    ids: Bytes, by_row: NDArray[np.int64], by_column: NDArray[np.int64], known: int
) -> None:
    """Count the texels whose id is not that of the next, by their row and by their column.

    The first `known` rows, those of the band before, have been counted along columns.
    """
    rows, width = ids.shape
    for row in range(rows):
        if row + 1 < rows:
            changes = 0
            for column in range(width):
                changes += ids[row, column] != ids[row + 1, column]
            by_row[row] = changes
        if row >= known:
            for column in range(width - 1):
                by_column[column] += ids[row, column] != ids[row, column + 1]


@compiled
def _stand_out(
    normal: Words,
    tangent: Words,
    ids: Bytes,
    places: Places,
    axis: int,
    table: Floats32,
    of_normal: Floats32,
    of_tangent: Floats32,
    one_yarn: Mask,
) -> None:
    """Fill in what `Strips.standing_out` returns; `places` are two lines on either side, (B, 4)."""
    sign = np.float32(-1 if axis == 0 else 1)
    for border in range(places.shape[0]):
        for n in range(ids.shape[1]):
            one = ids[places[border, 0], n] > 0
            for k in range(3):
                here, there = places[border, k], places[border, k + 1]
                ahead = table[normal[there, n, 1 - axis]] - table[normal[here, n, 1 - axis]]
                one &= ids[there, n] == ids[here, n] and sign * ahead > -CREASE
            one_yarn[border, n] = one
            if not one:
                continue
            for vectors, excess in ((normal, of_normal), (tangent, of_tangent)):
                beside, across = np.float32(0), np.float32(0)
                for k in range(3):
                    here, there = places[border, k], places[border, k + 1]
                    squared = np.float32(0)
                    for c in range(3):
                        step = table[vectors[there, n, c]] - table[vectors[here, n, c]]
                        squared += step * step
                    if k == 1:
                        across = np.sqrt(squared)
                    else:
                        beside = max(beside, np.sqrt(squared))
                excess[border, n] = across - beside
