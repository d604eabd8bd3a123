"""Whether opposite edges of the textures join."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.checks._strips import (
    CREASE,
    NORMAL,
    TANGENT,
    StripReader,
    Strips,
    even_borders,
    yarn_borders,
)
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.validate.textures import Floats32

SEAM = Code("tile-seam", Status.FAIL, "A yarn that crosses an edge breaks there.")
CUT = Code(
    "tile-cut", Status.FAIL, "The side of a yarn at an edge is cut off before it bends down."
)
FLOAT = Code("float-cut", Status.FAIL, "A float that crosses an edge ends there and begins anew.")
COARSE = Code(
    "tile-unread", Status.SKIP, "The textures are too coarse to tell a seam from a border of yarns."
)

TEXELS_PER_THREAD = 8
"""In coarser textures what looks like one yarn may be two threads."""

FEWEST = 0.02
"""Least share of a line that must be of a kind before its median counts."""

CREASED = 0.15
"""Share of the texels of threads that cross a line of which so many more turn back at the edge."""

TOLERANCE = 3e-4
"""Rounding to 16 bits alone makes a step stand out by less."""


@check(
    id="texture/tiles",
    why="A seam repeats across the whole garment.",
    needs=("material", "textures"),
    codes=(SEAM, CUT, FLOAT, COARSE),
)
class Tiles:
    """Yarns that cross an edge go on at the opposite one, and the sides of others bend down there.

    Yarns are convex, so that along either axis the normal of one yarn only ever leans further
    forward; it turns back where the next yarn begins. The borders of yarns, sharp as they are,
    are thus told from seams. Where the normal does not turn back, the step between two texels
    may stand out from the steps before and after it: by how much is compared, at the median,
    between the edge and many lines inside. Where the side of a yarn lies at the edge, it must
    lean, at the median, at least as far as two texels before its sides inside; the ends of
    floats do not count, since they bend down as steeply as each float is short. A float that
    crosses the edge must not turn back there, as it does where it was drawn without its other half.
    """

    def __init__(self, asset: OpenAsset) -> None:
        header = asset.textures.header(NORMAL)
        lengths = header.height, header.width
        self._even = [even_borders(length) for length in lengths]
        self._between = yarn_borders(asset.textures)
        self._numbers = [_side_by_side(asset, axis) for axis in (0, 1)]
        self._readers = {
            axis: StripReader(
                axis, lengths[axis], np.concatenate([self._even[axis], self._between[axis]])
            )
            for axis in (0, 1)
            if asset.texels_per_thread[1 - axis] >= TEXELS_PER_THREAD
        }

    def look(self, band: Band) -> None:
        """Take the lines next to the edges and to the borders that they are compared with."""
        for reader in self._readers.values():
            reader.look(band)

    def findings(self) -> Iterator[Finding]:
        """Report edges across which vectors jump, and yarns that are cut off there."""
        for axis, edge in ((0, "top and bottom"), (1, "left and right")):
            if axis in self._readers:
                yield from self._seams(axis, edge)
                yield from self._cuts(axis, edge)
                yield from self._floats(axis, edge)
            else:
                yield COARSE(f"there are too few texels for each thread across the {edge} edges")

    def _seams(self, axis: int, edge: str) -> Iterator[Finding]:
        strips = self._readers[axis].strips(self._even[axis])
        of_normal, of_tangent, one_yarn = strips.standing_out()
        for file, excess in ((NORMAL, of_normal), (TANGENT, of_tangent)):
            # NaN where too few yarns cross the edge, or lines inside.
            medians = _medians(excess, one_yarn)
            at_edge, inside = float(medians[0]), _largest(medians[1:])
            limit = 2 * max(inside, 0.0) + TOLERANCE
            if at_edge > limit:
                yield SEAM(
                    f"across the {edge} edges vectors jump by {at_edge:.5f}, "
                    f"expected at most {limit:.5f} as inside",
                    f"{TEXTURE_DIR}/{file}",
                )

    def _cuts(self, axis: int, edge: str) -> Iterator[Finding]:
        strips = self._readers[axis].strips(self._between[axis])
        for number in self._numbers[axis]:
            at_edge, inside = _lean_at_sides(strips, number)
            if inside > 0 and at_edge < inside - TOLERANCE:
                yield CUT(
                    f"at the {edge} edges the yarn of id {number} leans by {at_edge:.3f}, "
                    f"expected at least {inside:.3f} as inside",
                    f"{TEXTURE_DIR}/{NORMAL}",
                )

    def _floats(self, axis: int, edge: str) -> Iterator[Finding]:
        strips = self._readers[axis].strips(self._even[axis])
        at_edge, inside = _turning_back(strips, self._numbers[1 - axis])
        if at_edge > inside + CREASED:
            yield FLOAT(
                f"at the {edge} edges {at_edge:.0%} of the threads that cross turn back, "
                f"expected at most {inside:.0%} as inside",
                f"{TEXTURE_DIR}/{NORMAL}",
            )


def _turning_back(strips: Strips, numbers: list[int]) -> tuple[float, float]:
    """Return the share of texels of the yarns `numbers` that turn back across a border.

    First at the edge, then the largest inside; 0 where too few texels are of one yarn.
    """
    ids, lean = strips.ids[strips.places], strips.lean()
    crossing = np.isin(ids[:, 1], numbers) & (ids[:, 1:5] == ids[:, 1:2]).all(axis=1)
    back = crossing & (lean[:, 3] - lean[:, 2] < -CREASE)
    count = crossing.sum(axis=1)
    enough = count >= max(8, FEWEST * ids.shape[2])
    shares = np.where(enough, back.sum(axis=1) / np.maximum(count, 1), 0.0)
    return float(shares[0]), float(shares[1:].max(initial=0.0))


def _side_by_side(asset: OpenAsset, axis: int) -> list[int]:
    """Return the ids of the yarns that lie side by side along `axis`: weft across rows."""
    system = "weft" if axis == 0 else "warp"
    return [
        number
        for number, yarn in enumerate(asset.yarns, start=1)
        if asset.yarn(yarn, "system") == system
    ]


def _lean_at_sides(strips: Strips, number: int) -> tuple[float, float]:
    """Return how far the yarn of id `number` leans at its sides.

    First the least median of both sides of the edge, at the last texel there, then the least
    one inside, two texels before the last. NaN where no side is seen.
    """
    ids, lean = strips.ids[strips.places], strips.lean()
    before = (ids[:, :3] == number).all(axis=1) & (ids[:, 3] != number)
    after = (ids[:, 3:] == number).all(axis=1) & (ids[:, 2] != number)
    at_edge = [_medians(lean[:1, 2], before[:1]), _medians(-lean[:1, 3], after[:1])]
    inside = [_medians(lean[1:, 0], before[1:]), _medians(-lean[1:, 5], after[1:])]
    return -_largest(-np.concatenate(at_edge)), -_largest(-np.concatenate(inside))


def _medians(values: Floats32, chosen: NDArray[np.bool_]) -> Floats32:
    """Return (B,): the median of the `chosen` of each line of `values`, (B, N).

    NaN where fewer are chosen than `FEWEST` asks for.
    """
    enough = chosen.sum(axis=1) >= max(8, FEWEST * values.shape[1])
    medians = np.full(len(values), np.nan, dtype=np.float32)
    for k in np.flatnonzero(enough):
        medians[k] = np.median(values[k, chosen[k]])
    return medians


def _largest(values: Floats32) -> float:
    """Return the largest of `values` that is a number, or NaN when none is."""
    numbers = values[~np.isnan(values)]
    return float(numbers.max()) if len(numbers) else float("nan")
