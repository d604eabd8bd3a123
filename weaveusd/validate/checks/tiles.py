"""Whether opposite edges of the textures join."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats32 = NDArray[np.float32]

SEAM = Code("tile-seam", Status.FAIL, "A yarn that crosses an edge breaks there.")

LINES = 256
"""Borders between lines of texels inside the texture with which each edge is compared."""

CREASE = 0.05
"""A normal that turns back by more than this from texel to texel has left its yarn."""

FEWEST = 0.02
"""Least share of an edge that must be crossed by yarns for it to be judged."""

TOLERANCE = 2e-3
"""Rounding to half floats alone makes a step stand out by less."""


@check(
    id="texture/tiles",
    why="A seam repeats across the whole garment.",
    needs=("textures",),
    codes=(SEAM,),
)
def texture_tiles(asset: OpenAsset) -> Iterator[Finding]:
    """Yarns that cross an edge go on at the opposite one as smoothly as inside.

    Yarns are convex, so that along either axis the normal of one yarn only ever leans further
    forward; it turns back where the next yarn begins. Where it does not turn back, the step
    between two texels may stand out from the steps before and after it. How far it does so is
    compared, at the median, between the edge and many lines inside. The borders of yarns, sharp
    as they are, do not count on either side.
    """
    for axis, edge in ((0, "top and bottom"), (1, "left and right")):
        at_edge, inside = _jumps(asset, axis)
        if np.isnan(at_edge) or np.isnan(inside).all():
            continue
        limit = 2 * max(float(np.nanmax(inside)), 0.0) + TOLERANCE
        if at_edge > limit:
            yield SEAM(
                f"across the {edge} edges normals jump by {at_edge:.4f}, "
                f"expected at most {limit:.4f} as inside",
                f"{TEXTURE_DIR}/normal.exr",
            )


def _jumps(asset: OpenAsset, axis: int) -> tuple[float, Floats32]:
    """Return how far steps stand out at the edge, and at lines inside; NaN where unknown."""
    header = asset.textures.header("normal.exr")
    length = header.height if axis == 0 else header.width
    inside = np.unique(np.linspace(1, length - 3, min(LINES, length - 3)).astype(int))
    borders = np.append(length - 1, inside)  # the border after line k, the last being the edge
    lines = (borders[:, None] + np.arange(-1, 3)) % length
    normal, ids = _gather(asset, axis, lines)

    steps = np.diff(normal, axis=1)
    forward = -1.0 if axis == 0 else 1.0  # image rows run against y
    ahead = steps[..., 1 - axis] * forward
    one_yarn = (ids == ids[:, :1]).all(axis=1) & (ids[:, 0] > 0) & (ahead > -CREASE).all(axis=1)
    size = np.linalg.norm(steps, axis=-1)
    excess = size[:, 1] - np.maximum(size[:, 0], size[:, 2])

    counts = one_yarn.sum(axis=1)
    enough = counts >= max(8, FEWEST * excess.shape[1])
    medians = np.full(len(borders), np.nan, dtype=np.float32)
    for k in np.flatnonzero(enough):
        medians[k] = np.median(excess[k, one_yarn[k]])
    return float(medians[0]), medians[1:]


def _gather(
    asset: OpenAsset, axis: int, lines: NDArray[np.intp]
) -> tuple[Floats32, NDArray[np.uint8]]:
    """Return normals (B, 4, N, 3) and yarn ids (B, 4, N) of `lines` (B, 4) across `axis`."""
    wanted, place = np.unique(lines, return_inverse=True)
    normals, ids = [], []
    for band in asset.textures.bands("normal.exr", "yarn_id.png"):
        vectors, labels = band.vectors("normal.exr"), band.pixels["yarn_id.png"][..., 0]
        if axis == 0:
            rows = wanted[(wanted >= band.first) & (wanted < band.first + len(labels))]
            normals.append(vectors[rows - band.first])
            ids.append(labels[rows - band.first])
        else:
            normals.append(vectors[:, wanted].swapaxes(0, 1))
            ids.append(labels[:, wanted].T)
    along = 0 if axis == 0 else 1
    place = place.reshape(lines.shape)
    return np.concatenate(normals, axis=along)[place], np.concatenate(ids, axis=along)[place]
