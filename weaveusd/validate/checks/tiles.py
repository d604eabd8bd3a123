"""Whether opposite edges of the textures join."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.checks._texels import SOLID, solid_ids
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import decode_vectors

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats32 = NDArray[np.float32]

SEAM = Code("tile-seam", Status.FAIL, "A yarn that crosses an edge breaks there.")
CUT = Code(
    "tile-cut", Status.FAIL, "The side of a yarn at an edge is cut off before it bends down."
)

COARSE = Code(
    "tile-unread", Status.SKIP, "The textures are too coarse to tell a seam from a border of yarns."
)

NORMAL, TANGENT = "normal.png", "tangent.png"
"""The 16 bits of the PNG resolve steps that half floats round away."""

LINES = 128
"""Borders between lines of texels inside the texture with which each edge is compared."""

CREASE = 0.05
"""A normal that turns back by more than this from texel to texel has left its yarn."""

TEXELS_PER_THREAD = 8
"""In coarser textures what looks like one yarn may be two threads."""

FEWEST = 0.02
"""Least share of a line that must be of a kind before its median counts."""

TOLERANCE = 3e-4
"""Rounding to 16 bits alone makes a step stand out by less."""


@dataclass(frozen=True, slots=True, eq=False)
class Strips:
    """Lines of texels on both sides of several borders; the border 0 is the edge.

    Lines 0 to 2 lie before a border and lines 3 to 5 after it, in the order of the axis.
    """

    axis: int  # 0 across rows, 1 across columns
    normal: Floats32  # (B, 6, N, 3)
    tangent: Floats32  # (B, 6, N, 3)
    ids: NDArray[np.uint8]  # (B, 6, N)

    def lean(self) -> Floats32:
        """Return (B, 6, N): how far normals lean forward along the axis."""
        # Image rows run against y.
        return self.normal[..., 1] * np.float32(-1) if self.axis == 0 else self.normal[..., 0]


@check(
    id="texture/tiles",
    why="A seam repeats across the whole garment.",
    needs=("material", "textures"),
    codes=(SEAM, CUT, COARSE),
)
def texture_tiles(asset: OpenAsset) -> Iterator[Finding]:
    """Yarns that cross an edge go on at the opposite one, and the sides of others bend down there.

    Yarns are convex, so that along either axis the normal of one yarn only ever leans further
    forward; it turns back where the next yarn begins. The borders of yarns, sharp as they are,
    are thus told from seams. Where the normal does not turn back, the step between two texels
    may stand out from the steps before and after it: by how much is compared, at the median,
    between the edge and many lines inside. Where the side of a yarn lies at the edge, it must
    lean, at the median, at least as far as two texels before its sides inside; the ends of
    floats do not count, since they bend down as steeply as each float is short.
    """
    for axis, edge in ((0, "top and bottom"), (1, "left and right")):
        if asset.texels_per_thread[1 - axis] < TEXELS_PER_THREAD:
            yield COARSE(f"there are too few texels for each thread across the {edge} edges")
            continue
        strips = _gather(asset, axis, _even_borders(asset, axis))
        for file, vectors in ((NORMAL, strips.normal), (TANGENT, strips.tangent)):
            at_edge, inside = _standing_out(strips, vectors)
            limit = 2 * max(inside, 0.0) + TOLERANCE
            if at_edge > limit:
                yield SEAM(
                    f"across the {edge} edges vectors jump by {at_edge:.5f}, "
                    f"expected at most {limit:.5f} as inside",
                    f"{TEXTURE_DIR}/{file}",
                )
        strips = _gather(asset, axis, _yarn_borders(asset, axis))
        for number in _side_by_side(asset, axis):
            at_edge, inside = _lean_at_sides(strips, number)
            if inside > 0 and at_edge < inside - TOLERANCE:
                yield CUT(
                    f"at the {edge} edges the yarn of id {number} leans by {at_edge:.3f}, "
                    f"expected at least {inside:.3f} as inside",
                    f"{TEXTURE_DIR}/{NORMAL}",
                )


def _standing_out(strips: Strips, vectors: Floats32) -> tuple[float, float]:
    """Return by how much steps between `vectors` stand out, at the edge and at most inside.

    NaN at the edge means that too few yarns cross it; so does it inside.
    """
    ids = strips.ids[:, 1:5]
    ahead = np.diff(strips.lean()[:, 1:5], axis=1)
    one_yarn = (ids == ids[:, :1]).all(axis=1) & (ids[:, 0] > 0) & (ahead > -CREASE).all(axis=1)
    size = np.linalg.norm(np.diff(vectors[:, 1:5], axis=1), axis=-1)
    medians = _medians(size[:, 1] - np.maximum(size[:, 0], size[:, 2]), one_yarn)
    return float(medians[0]), _largest(medians[1:])


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
    ids, lean = strips.ids, strips.lean()
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


def _length(asset: OpenAsset, axis: int) -> int:
    header = asset.textures.header(NORMAL)
    return header.height if axis == 0 else header.width


def _even_borders(asset: OpenAsset, axis: int) -> NDArray[np.intp]:
    """Return the edge, then borders evenly spread inside, each by the line before it."""
    length = _length(asset, axis)
    inside = np.linspace(2, length - 4, max(0, min(LINES, length - 5)))
    return np.concatenate([[length - 1], np.unique(inside.astype(int))])


def _yarn_borders(asset: OpenAsset, axis: int) -> NDArray[np.intp]:
    """Return the edge, then the borders at which most texels change their yarn."""
    length = _length(asset, axis)
    changes = np.zeros(length, dtype=int)
    last = None
    for band in asset.textures.bands(*SOLID):
        ids = solid_ids(band)
        if axis == 1:
            changes[:-1] += (ids[:, 1:] != ids[:, :-1]).sum(axis=0)
            continue
        changes[band.first : band.first + len(ids) - 1] = (ids[1:] != ids[:-1]).sum(axis=1)
        if last is not None:
            changes[band.first - 1] = (ids[0] != last).sum()
        last = ids[-1]
    changes[:2], changes[length - 3 :] = 0, 0
    inside = np.sort(np.argsort(-changes, kind="stable")[: LINES // 2])
    return np.concatenate([[length - 1], inside[changes[inside] > 0]])


def _gather(asset: OpenAsset, axis: int, borders: NDArray[np.intp]) -> Strips:
    """Read the lines next to `borders`."""
    lines = (borders[:, None] + np.arange(-2, 4)) % _length(asset, axis)
    wanted, place = np.unique(lines, return_inverse=True)
    place = place.reshape(lines.shape)

    def chosen(values: NDArray[Any], first: int) -> NDArray[Any]:
        if axis == 1:
            return np.swapaxes(values[:, wanted], 0, 1)
        rows = wanted[(wanted >= first) & (wanted < first + len(values))]
        return np.asarray(values[rows - first])

    parts: list[tuple[NDArray[Any], ...]] = []
    for band in asset.textures.bands(NORMAL, TANGENT, *SOLID):
        arrays = band.pixels[NORMAL], band.pixels[TANGENT], solid_ids(band)
        parts.append(tuple(chosen(values, band.first) for values in arrays))
    normal, tangent, ids = (
        np.concatenate(part, axis=axis)[place] for part in zip(*parts, strict=True)
    )
    return Strips(axis, decode_vectors(normal), decode_vectors(tangent), ids)
