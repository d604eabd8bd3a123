"""Texture coordinates and the like on subdivision surfaces, with the seams of their own.

Corners of a vertex that hold different values part the values' surface there. How its borders
behave is USD's `faceVaryingLinearInterpolation`; inside, values follow the rule of the vertices.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from weaveusd.render import subdivision
from weaveusd.render.subdivision import Refined
from weaveusd.render.topology import Topology, connect

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

Interpolation = Literal[
    "none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"
]  # fmt: skip
INTERPOLATIONS: tuple[str, ...] = get_args(Interpolation)


def carry_corners(refined: Refined, values: Doubles, interpolation: Interpolation) -> Doubles:
    """Return values (C, k) of a cage's corners at the corners of the refined faces.

    `all` interpolates linearly everywhere, `boundaries` along every seam and smoothly inside;
    `cornersOnly` keeps the corners of single faces, `cornersPlus1` also the points where three
    or more regions meet, `cornersPlus2` also the ends of seams and concave corners; `none` keeps
    nothing.
    """
    cage = refined.levels[0]
    table = np.concatenate((cage.corners[:, None].astype(np.float64), values), axis=1)
    distinct, seam_corners = np.unique(table, axis=0, return_inverse=True)
    seam_corners = seam_corners.reshape(-1)
    seams = connect(
        cage.counts,
        seam_corners,
        len(distinct),
        np.stack((seam_corners, seam_corners[cage.following]), axis=1),
        cage.edge_sharpness[cage.edge_of] * _joined(cage, seam_corners),
        cage.vertex_sharpness[distinct[:, 0].astype(np.int64)],
    )
    kept = _kept(cage, seams, distinct, interpolation)
    seams = replace(seams, vertex_sharpness=np.where(kept, np.inf, seams.vertex_sharpness))
    own = subdivision.refine(seams, refined.scheme, len(refined.levels))
    carried = own.carry(distinct[:, 1:], smooth=interpolation != "all")
    return np.asarray(carried[own.topology.corners])


def _joined(cage: Topology, seam_corners: Indices) -> NDArray[np.bool_]:
    """Return (C,) whether the edge from each corner has one pair of values for both faces."""
    ends = np.sort(np.stack((seam_corners, seam_corners[cage.following]), axis=1), axis=1)
    keys = ends[:, 0] * (seam_corners.max(initial=0) + 1) + ends[:, 1]
    least = np.full(len(cage.ends), np.iinfo(np.int64).max)
    most = np.zeros(len(cage.ends), np.int64)
    np.minimum.at(least, cage.edge_of, keys)
    np.maximum.at(most, cage.edge_of, keys)
    return np.asarray((least == most)[cage.edge_of])


def _kept(
    cage: Topology, seams: Topology, distinct: Doubles, interpolation: Interpolation
) -> NDArray[np.bool_]:
    """Return which values stay as they are, (distinct,)."""
    border = np.zeros(seams.vertices, bool)
    border[seams.ends[seams.shared == 1].ravel()] = True
    if interpolation == "boundaries":
        return border
    faces = np.bincount(seams.corners, minlength=seams.vertices)
    kept = np.zeros(seams.vertices, bool)
    if interpolation in ("cornersOnly", "cornersPlus1", "cornersPlus2"):
        kept |= faces == 1
    vertex = distinct[:, 0].astype(np.int64)
    regions = np.bincount(vertex, minlength=cage.vertices)
    if interpolation in ("cornersPlus1", "cornersPlus2"):
        kept |= border & (regions[vertex] > 2)
    if interpolation == "cornersPlus2":
        rim = np.zeros(cage.vertices, bool)
        rim[cage.ends[cage.shared == 1].ravel()] = True
        single = np.zeros(cage.vertices, bool)
        single[vertex[faces == 1]] = True
        seam_end = border & (regions[vertex] == 1) & ~rim[vertex]
        kept |= seam_end | (border & (regions[vertex] == 2) & single[vertex])
    return kept
