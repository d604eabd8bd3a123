"""Whether fibres lie in the surface of their yarn."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.validate.checks._texels import Tally
from weaveusd.validate.compiled import compiled
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band, vector_table

if TYPE_CHECKING:
    from weaveusd.validate.textures import Floats32, Words

NOT_ORTHOGONAL = Code(
    "frame-not-orthogonal",
    Status.FAIL,
    "The tangent of a texel is not at right angles to its normal.",
)

TOLERANCE = 4e-3
"""Half floats of both vectors change their product by at most 1.7e-3."""


@check(
    id="texture/orthogonal",
    why="The highlight follows the tangent: one that leaves the surface lies.",
    needs=("textures",),
    codes=(NOT_ORTHOGONAL,),
)
class OrthogonalFrames:
    """Tangents are at right angles to normals."""

    def __init__(self, asset: OpenAsset) -> None:
        self._tallies = {suffix: Tally() for suffix in (".exr", ".png")}

    def look(self, band: Band) -> None:
        """Count the texels whose vectors are not at right angles."""
        for suffix, tally in self._tallies.items():
            normal, tangent = band.words(f"normal{suffix}"), band.words(f"tangent{suffix}")
            products = np.empty(normal.shape[:2], np.float32)
            _multiply(normal, tangent, vector_table(suffix), products)
            tally.add(band.first, products > TOLERANCE, products)

    def findings(self) -> Iterator[Finding]:
        """Report the tangents of either file."""
        for suffix, tally in self._tallies.items():
            law = "not at right angles to the normal"
            yield from tally.report(NOT_ORTHOGONAL, f"tangent{suffix}", law)


@compiled
def _multiply(normal: Words, tangent: Words, table: Floats32, products: Floats32) -> None:
    """Fill in |n · t| of each texel."""
    for row in range(normal.shape[0]):
        for column in range(normal.shape[1]):
            product = np.float32(0)
            for k in range(3):
                product += table[normal[row, column, k]] * table[tangent[row, column, k]]
            products[row, column] = abs(product)
