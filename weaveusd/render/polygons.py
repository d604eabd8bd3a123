"""Polygon meshes as triangles: plain arrays, nothing of USD or Mitsuba.

A corner is one vertex of one face; corners are numbered as `face_vertex_indices` lists them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

MAX_CONCAVE = 1024
"""Vertices of a face that is split by ears, which takes their number to the third."""

Interpolation = Literal["constant", "uniform", "vertex", "faceVarying"]


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """Triangles of a mesh as corners, with the face that each is a part of."""

    corners: Indices  # (T, 3)
    face: Indices  # (T,)


@dataclass(frozen=True, slots=True, eq=False)
class SplitMesh:
    """Vertices made unique over all their values, and triangles that index them."""

    source: Indices  # (V,) a corner that has the vertex's values
    triangles: Indices  # (T, 3)


def triangulate(counts: Indices, points: Doubles, indices: Indices, reverse: bool) -> Triangles:
    """Return the triangles of all faces; `reverse` turns each to the other side.

    Convex faces are split as fans. Faces that are not convex are split ear by ear, up to
    `MAX_CONCAVE` vertices, so that no triangle lies outside them. Faces of fewer than three
    vertices have no triangle.
    """
    starts = np.concatenate(([0], np.cumsum(counts)[:-1])).astype(np.int64)
    corners: list[Indices] = []
    faces: list[Indices] = []
    for count in np.unique(counts[counts >= 3]):
        face = np.flatnonzero(counts == count)
        corner = starts[face][:, None] + np.arange(count)
        fan = np.stack(
            [np.zeros(count - 2, int), np.arange(1, count - 1), np.arange(2, count)], axis=1
        )
        if count == 4:
            # A fan about the vertex that turns inward lies inside.
            inward = np.argmin(_bends(points[indices[corner]]), axis=1)
            corner = np.take_along_axis(corner, (inward[:, None] + np.arange(4)) % 4, axis=1)
        pieces = corner[:, fan]  # (F, count - 2, 3)
        if 4 < count <= MAX_CONCAVE:
            bent = (_bends(points[indices[corner]]) < 0).any(axis=1)
            for k in np.flatnonzero(bent):
                pieces[k] = corner[k][_clip_ears(points[indices[corner[k]]])]
        corners.append(pieces.reshape(-1, 3))
        faces.append(np.repeat(face, count - 2))
    if not corners:
        return Triangles(np.zeros((0, 3), np.int64), np.zeros(0, np.int64))
    corner_of, face_of = np.concatenate(corners), np.concatenate(faces)
    order = np.argsort(face_of, kind="stable")
    corner_of = corner_of[order]
    return Triangles(corner_of[:, ::-1] if reverse else corner_of, face_of[order])


def per_corner(
    values: Doubles, interpolation: Interpolation, counts: Indices, indices: Indices
) -> Doubles:
    """Return one value a corner, (corners, components).

    Raises
    ------
    ValueError
        When the interpolation is unknown, or the number of values does not fit it.
    """
    expected = {
        "constant": 1,
        "uniform": counts.size,
        "vertex": int(indices.max(initial=-1)) + 1,
        "faceVarying": indices.size,
    }.get(interpolation)
    if expected is None:
        raise ValueError(f"interpolation {interpolation} is unknown")
    if len(values) < expected:
        raise ValueError(f"has {len(values)} {interpolation} values, expected {expected}")
    if interpolation == "constant":
        return np.repeat(values[:1], indices.size, axis=0)
    if interpolation == "uniform":
        return np.repeat(values[: counts.size], counts, axis=0)
    return values[indices] if interpolation == "vertex" else values[: indices.size]


def split(triangles: Triangles, indices: Indices, values: Mapping[str, Doubles]) -> SplitMesh:
    """Return the mesh with one vertex for every distinct point and corner values."""
    used = _marked(triangles.corners, indices.size)
    shared = _one_corner_a_point(used, indices)
    if all(np.array_equal(v[used], v[shared[indices[used]]]) for v in values.values()):
        points = _marked(indices[triangles.corners], len(shared))
        vertex_of = np.zeros(len(shared), np.int64)
        vertex_of[points] = np.arange(points.size)
        return SplitMesh(shared[points], vertex_of[indices[triangles.corners]])
    columns = [indices[used].astype(np.float64)[:, None]]
    columns += [np.asarray(v, np.float64)[used] for v in values.values()]
    table = np.ascontiguousarray(np.concatenate(columns, axis=1) + 0.0)  # no negative zeros
    rows = table.view(np.dtype((np.void, table.dtype.itemsize * table.shape[1]))).ravel()
    _, first, inverse = np.unique(rows, return_index=True, return_inverse=True)
    # Vertices are numbered as they come, whatever the byte order sorts first.
    rank = np.empty(first.size, np.int64)
    order = np.argsort(first, kind="stable")
    rank[order] = np.arange(first.size)
    vertex_of = np.full(indices.size, -1, np.int64)
    vertex_of[used] = rank[inverse]
    return SplitMesh(used[first[order]], vertex_of[triangles.corners])


def _marked(numbers: Indices, size: int) -> Indices:
    """Return which of the numbers below `size` occur, in order."""
    found = np.zeros(size, bool)
    found[numbers] = True
    return np.flatnonzero(found)


def _one_corner_a_point(used: Indices, indices: Indices) -> Indices:
    """Return the first of the used corners of each point, -1 for points without, (P,)."""
    first = np.full(int(indices.max(initial=-1)) + 1, -1, np.int64)
    first[indices[used[::-1]]] = used[::-1]
    return first


def _area_vector(polygons: Doubles) -> Doubles:
    """Return twice the area of polygons (..., n, 3) as a vector along their normal."""
    return np.asarray(np.cross(polygons, np.roll(polygons, -1, axis=-2)).sum(axis=-2))


def _bends(polygons: Doubles) -> Doubles:
    """Return how polygons (F, n, 3) turn at each vertex, (F, n): negative where inward, else 0."""
    centered = polygons - polygons.mean(axis=1, keepdims=True)
    normal = _area_vector(centered)
    incoming = centered - np.roll(centered, 1, axis=1)
    turn = np.cross(incoming, np.roll(incoming, -1, axis=1))
    bend = np.einsum("fnk,fk->fn", turn, normal)
    least = -1e-12 * np.sum(normal * normal, axis=1, keepdims=True)
    return np.where(bend < least, bend, 0.0)


def _clip_ears(polygon: Doubles) -> Indices:
    """Return the triangles (n - 2, 3) of a simple polygon (n, 3) that is not convex."""
    normal = _area_vector(polygon - polygon.mean(axis=0))
    drop = int(np.argmax(np.abs(normal)))
    flat = np.delete(polygon, drop, axis=1)
    if (normal[drop] < 0) != (drop == 1):
        flat = flat * (1.0, -1.0)
    left = list(range(len(polygon)))
    triangles: list[tuple[int, int, int]] = []
    while len(left) > 3:
        ear = next((k for k in range(len(left)) if _is_ear(flat, left, k)), 0)
        triangles.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    triangles.append((left[0], left[1], left[2]))
    return np.array(triangles, np.int64)


def _is_ear(flat: Doubles, left: list[int], k: int) -> bool:
    """Return whether the corner `k` turns left and holds no other vertex of the polygon."""
    a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
    if _turn(flat[a], flat[b], flat[c]) <= 0:
        return False
    others = flat[[i for i in left if i not in (a, b, c)]]
    inside = np.ones(len(others), bool)
    for start, end in ((a, b), (b, c), (c, a)):
        inside &= _turn(flat[start], flat[end], others.T) >= 0
    return not bool(inside.any())


def _turn(a: Doubles, b: Doubles, c: Doubles) -> NDArray[np.float64]:
    """Return twice the signed area of the triangles a, b, c in the plane."""
    turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    return np.asarray(turn, np.float64)
