"""Whether normals and tangents are unit vectors on the right side of the cloth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.validate.checks._texels import Tally
from weaveusd.validate.compiled import compiled
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import TEXTURE_FILES, OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band, vector_table

if TYPE_CHECKING:
    from weaveusd.validate.checks._texels import Mask
    from weaveusd.validate.textures import Floats32, Words

LENGTH = Code("vector-not-unit", Status.FAIL, "A normal or tangent is not of unit length.")
SIDE = Code("normal-below", Status.FAIL, "A normal points below the cloth.")

TOLERANCE = 2e-3
"""Rounding each component to a half float changes the length by at most 8.5e-4."""


@check(
    id="texture/unit-vectors",
    why="A vector of another length was filtered, gamma-encoded or stored in other limits.",
    needs=("textures",),
    codes=(LENGTH, SIDE),
)
class UnitVectors:
    """Normals and tangents have unit length, and normals point out of the face."""

    def __init__(self, asset: OpenAsset) -> None:
        files = [f for f, channel in TEXTURE_FILES.items() if channel.encoding == "vector"]
        self._lengths = {file: Tally() for file in files}
        self._sides = {f: Tally() for f in files if TEXTURE_FILES[f].name == "normal"}

    def look(self, band: Band) -> None:
        """Count the vectors of another length, and the normals that point down."""
        for file, tally in self._lengths.items():
            words, table = band.words(file), vector_table(file)
            long, down = np.empty((2, *words.shape[:2]), np.bool_)
            _judge(words, table, np.float32(2 * TOLERANCE), np.float32(-TOLERANCE), long, down)
            tally.add(band.first, long, words, table)
            if file in self._sides:
                self._sides[file].add(band.first, down, words, table)

    def findings(self) -> Iterator[Finding]:
        """Report every file that holds such vectors."""
        for file, tally in self._lengths.items():
            yield from tally.report(LENGTH, file, "no unit vector")
            if file in self._sides:
                yield from self._sides[file].report(SIDE, file, "below the cloth")


@compiled
def _judge(
    words: Words,
    table: Floats32,
    tolerance: np.float32,
    lowest: np.float32,
    long: Mask,
    down: Mask,
) -> None:
    """Fill in where |v|² differs from 1 by more than `tolerance`, and where z is below `lowest`.

    What is not a number is no length at all, but texture/finite reports it.
    """
    one = np.float32(1)
    for row in range(words.shape[0]):
        for column in range(words.shape[1]):
            x = table[words[row, column, 0]]
            y = table[words[row, column, 1]]
            z = table[words[row, column, 2]]
            long[row, column] = abs(x * x + y * y + z * z - one) > tolerance
            down[row, column] = z < lowest
