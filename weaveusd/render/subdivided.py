"""What a UsdGeom mesh says of its subdivision, and the surface that follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np
from pxr import Usd, UsdGeom

from weaveusd.render import subdivision
from weaveusd.render.face_varying import INTERPOLATIONS, Interpolation, carry_corners
from weaveusd.render.model import Losses
from weaveusd.render.reading import UnreadableError, integers, rows, token
from weaveusd.render.subdivision import Refined, Scheme
from weaveusd.render.topology import Topology, connect, fans, gather_sum

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

_INFINITE = 10.0
"""USD's sharpness of what stays sharp at every level."""


@dataclass(frozen=True, slots=True, eq=False)
class Cage:
    """A refined control cage, and how authored values reach its corners."""

    refined: Refined
    kept_corners: Indices  # authored corners that the cage is made of
    kept_faces: Indices  # authored faces
    hidden: NDArray[np.bool_]  # (authored faces,)
    seams: Interpolation
    counts: Indices  # as authored

    def corners(self) -> Indices:
        """Return the refined vertex of each refined corner, (C,)."""
        return self.refined.topology.corners

    def face_of_triangles(self) -> Indices:
        """Return the authored face of each triangle, (T,)."""
        per_face = int(self.refined.topology.counts[0]) - 2
        return np.repeat(self.kept_faces[self.refined.parent], per_face)

    def triangles(self) -> Indices:
        """Return the refined faces as triangles of corners, (T, 3)."""
        count = int(self.refined.topology.counts[0])
        corners = np.arange(self.corners().size).reshape(-1, count)
        fan = [(0, k, k + 1) for k in range(1, count - 1)]
        return corners[:, fan].reshape(-1, 3)

    def carry_vertices(self, values: Doubles) -> Doubles:
        """Return values (P, k) of the authored points at the refined vertices, smoothly."""
        return self.refined.carry(values, smooth=True)

    def normals(self, points: Doubles, reverse: bool) -> Doubles:
        """Return unit normals at the refined corners, (C, 3), of refined points on the limit.

        Each is the mean over the faces of its vertex that no sharp edge parts from it, weighed
        by their angles' sines; authored normals have no place on a subdivision surface.
        """
        topology = self.refined.topology
        placed = points[topology.corners]
        ahead = placed[topology.following] - placed
        behind = placed[topology.preceding] - placed
        own = np.cross(ahead, behind)
        label = fans(topology)
        total = gather_sum(own, label, label.size)[label]
        length = np.linalg.norm(total, axis=1, keepdims=True)
        unit = np.where(length > 0, total / np.where(length > 0, length, 1), (0.0, 0.0, 1.0))
        return np.asarray(-unit if reverse else unit)

    def spread(self, values: Doubles, interpolation: str) -> Doubles:
        """Return authored values (n, k) at the refined corners; ValueError if n does not fit."""
        cage = self.refined.levels[0]
        expected = {
            "constant": 1,
            "uniform": self.counts.size,
            "vertex": int(cage.corners.max()) + 1,
            "varying": int(cage.corners.max()) + 1,
            "faceVarying": int(self.counts.sum()),
        }.get(interpolation)
        if expected is None:
            raise ValueError(f"interpolation {interpolation} is unknown")
        if len(values) < expected:
            raise ValueError(f"has {len(values)} {interpolation} values, expected {expected}")
        refined = self.refined.topology
        if interpolation == "constant":
            return np.repeat(values[:1], refined.corners.size, axis=0)
        if interpolation == "uniform":
            face = self.kept_faces[self.refined.parent]
            return np.repeat(values[face], refined.counts, axis=0)
        if interpolation == "faceVarying":
            return carry_corners(self.refined, values[self.kept_corners], self.seams)
        padded = np.zeros((cage.vertices, values.shape[1]))
        padded[: len(values)] = values[: cage.vertices]
        smooth = interpolation == "vertex"
        return self.refined.carry(padded, smooth=smooth)[refined.corners]


def read_cage(
    mesh: UsdGeom.Mesh, points: int, counts: Indices, indices: Indices, time: Usd.TimeCode,
    losses: Losses,
) -> Cage:  # fmt: skip
    """Return the subdivision surface of a mesh whose counts and indices are sound.

    Faces of fewer than three corners, or that name a point twice, are left out with a loss.

    Raises
    ------
    UnreadableError
        When the scheme is unknown or does not fit the faces, or memory would not do.
    """
    prim = mesh.GetPrim()
    scheme = cast(Scheme, token(mesh.GetSubdivisionSchemeAttr(), time, "catmullClark"))
    if scheme not in subdivision.SCHEMES:
        raise UnreadableError(f"subdivision scheme {scheme} is unknown")
    kept_faces = _sound_faces(counts, indices)
    if kept_faces.size < np.count_nonzero(counts):
        losses.dropped(prim, "subdivided faces that name a point twice, or fewer than three")
    kept = np.isin(np.repeat(np.arange(counts.size), counts), kept_faces)
    sizes = counts[kept_faces]
    if scheme == "loop" and (sizes != 3).any():
        raise UnreadableError("loop subdivision wants triangles")
    levels = subdivision.levels_for(sizes, scheme)
    if levels == 0:
        raise UnreadableError(f"{sizes.size} faces to subdivide are none or too many")
    if token(mesh.GetTriangleSubdivisionRuleAttr(), time, "") == UsdGeom.Tokens.smooth:
        losses.approximated(prim, "smooth triangles are subdivided by Catmull and Clark's rule")
    topology = _topology(mesh, points, sizes, indices[kept], time, losses)
    hidden = np.zeros(counts.size, bool)
    if _boundary(mesh, time) == UsdGeom.Tokens.none:
        hidden[kept_faces[_at_border(topology)]] = True
    seams = token(mesh.GetFaceVaryingLinearInterpolationAttr(), time, "cornersPlus1")
    if seams not in INTERPOLATIONS:
        losses.approximated(prim, f"faceVaryingLinearInterpolation {seams} is unknown")
        seams = "cornersPlus1"
    return Cage(
        subdivision.refine(topology, scheme, levels), np.flatnonzero(kept), kept_faces, hidden,
        cast(Interpolation, seams), counts,
    )  # fmt: skip


def _topology(
    mesh: UsdGeom.Mesh, points: int, counts: Indices, indices: Indices, time: Usd.TimeCode,
    losses: Losses,
) -> Topology:  # fmt: skip
    """Return the cage's topology with all that is authored to be sharp."""
    prim = mesh.GetPrim()
    pairs, crease_sharpness = np.zeros((0, 2), np.int64), np.zeros(0)
    vertex_sharpness = np.zeros(points)
    try:
        pairs, crease_sharpness = _creases(mesh, points, time)
    except UnreadableError as reason:
        losses.dropped(prim, str(reason))
    try:
        at, sharpness = _corners(mesh, points, time)
        np.maximum.at(vertex_sharpness, at, sharpness)
    except UnreadableError as reason:
        losses.dropped(prim, str(reason))
    if _boundary(mesh, time) == UsdGeom.Tokens.edgeAndCorner:
        alone = np.bincount(indices, minlength=points) == 1
        vertex_sharpness[alone] = np.inf
    return connect(counts, indices, points, pairs, crease_sharpness, vertex_sharpness)


def _creases(mesh: UsdGeom.Mesh, points: int, time: Usd.TimeCode) -> tuple[Indices, Doubles]:
    """Return pairs of points (n, 2) and the sharpness of the edge between them, (n,).

    A crease of k points has k - 1 edges, with one sharpness for all or one each.
    """
    indices = integers(mesh.GetCreaseIndicesAttr(), time)
    lengths = integers(mesh.GetCreaseLengthsAttr(), time)
    sharpness = rows(mesh.GetCreaseSharpnessesAttr(), time, 1)[:, 0]
    if not indices.size and not lengths.size:
        return np.zeros((0, 2), np.int64), np.zeros(0)
    if not lengths.size or lengths.min() < 2 or int(lengths.sum()) != indices.size:
        raise UnreadableError(f"creases of other lengths than their {indices.size} points")
    if indices.min() < 0 or indices.max() >= points:
        raise UnreadableError(f"creases name a point outside the {points} points")
    last = np.cumsum(lengths) - 1
    inner = np.ones(indices.size, bool)
    inner[last] = False
    first = np.flatnonzero(inner)
    if sharpness.size == lengths.size:
        sharpness = np.repeat(sharpness, lengths - 1)
    if sharpness.size != first.size:
        raise UnreadableError(f"creases have {sharpness.size} sharpnesses, expected {lengths.size}")
    return np.stack((indices[first], indices[first + 1]), axis=1), _endless(sharpness)


def _corners(mesh: UsdGeom.Mesh, points: int, time: Usd.TimeCode) -> tuple[Indices, Doubles]:
    """Return the points that are corners, and their sharpness."""
    indices = integers(mesh.GetCornerIndicesAttr(), time)
    sharpness = rows(mesh.GetCornerSharpnessesAttr(), time, 1)[:, 0]
    if indices.size != sharpness.size:
        raise UnreadableError(f"{indices.size} corners have {sharpness.size} sharpnesses")
    if indices.size and (indices.min() < 0 or indices.max() >= points):
        raise UnreadableError(f"corners name a point outside the {points} points")
    return indices, _endless(sharpness)


def _endless(sharpness: Doubles) -> Doubles:
    return np.where(sharpness >= _INFINITE, np.inf, np.maximum(sharpness, 0))


def _boundary(mesh: UsdGeom.Mesh, time: Usd.TimeCode) -> str:
    return token(mesh.GetInterpolateBoundaryAttr(), time, UsdGeom.Tokens.edgeAndCorner)


def _at_border(topology: Topology) -> NDArray[np.bool_]:
    """Return which faces have a vertex on a border, (F,)."""
    border = np.zeros(topology.vertices, bool)
    border[topology.ends[topology.shared == 1].ravel()] = True
    found = gather_sum(
        border[topology.corners][:, None].astype(np.float64), topology.face_of(),
        topology.counts.size,
    )  # fmt: skip
    return np.asarray(found[:, 0] > 0)


def _sound_faces(counts: Indices, indices: Indices) -> Indices:
    """Return the faces of three or more different points."""
    face = np.repeat(np.arange(counts.size), counts)
    order = np.lexsort((indices, face))
    twice = (np.diff(indices[order]) == 0) & (np.diff(face[order]) == 0)
    sound = counts >= 3
    sound[face[order][1:][twice]] = False
    return np.flatnonzero(sound)
