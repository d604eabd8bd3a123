"""Ellipsoids and open tubes as meshes, and their areas."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np

from weaveusd.render.xforms import mirrors

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

_AROUND, _DOWN = 192, 96
"""Faces about the axis and from pole to pole: a silhouette is 2e-4 smaller than the solid's."""

_LEAST = 2e-5
"""Least axis over the farthest coordinate: a face about it is then some five steps of float32."""


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A triangle mesh, its triangles counter-clockwise seen from outside."""

    points: NDArray[np.float32]  # (P, 3)
    triangles: NDArray[np.uint32]  # (T, 3)

    def area(self) -> float:
        """Return the sum of the areas of its triangles."""
        return float(_triangle_areas(self.points.astype(np.float64), self.triangles).sum())


def at_least_fine(matrix: Doubles) -> Doubles:
    """Return a (4, 4) matrix whose axes are long enough for corners in single precision."""
    axes, shift = matrix[:3, :3], matrix[:3, 3]
    lengths = np.linalg.norm(axes, axis=0)
    least = _LEAST * float((np.abs(shift) + np.abs(axes).sum(axis=1)).max())
    made = matrix.copy()
    made[:3, :3] *= np.maximum(lengths, least) / np.where(lengths > 0, lengths, 1)
    return made


def ellipsoid(matrix: Doubles) -> Solid:
    """Return the image of the unit sphere under a (4, 4) matrix."""
    theta = np.linspace(0.0, math.pi, _DOWN + 1)[:, None]
    phi = 2 * math.pi * np.arange(_AROUND) / _AROUND
    rings = np.stack(
        np.broadcast_arrays(
            np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
        ),
        axis=-1,
    )
    return _placed(rings, matrix)


def tube(matrix: Doubles) -> Solid:
    """Return the image of the open tube of radius 1 about z, from z = 0 to 1."""
    phi = 2 * math.pi * np.arange(_AROUND) / _AROUND
    ring = np.stack([np.cos(phi), np.sin(phi), np.ones(_AROUND)], axis=-1)
    return _placed(np.stack([ring, ring * (1, 1, 0)]), matrix)


def ellipsoid_area(axes: Doubles) -> float:
    """Return the area of the image of the unit sphere under a (3, 3) matrix.

    A patch dω about the direction n becomes |cof(M) n| dω (Nanson's formula), which is
    integrated with Gauss and Legendre's points in cos θ and even steps in φ.
    """
    heights, weights = np.polynomial.legendre.leggauss(128)
    phi = 2 * math.pi * (np.arange(256) + 0.5) / 256
    radius = np.sqrt(1 - heights**2)[:, None]
    normals = np.stack(
        np.broadcast_arrays(radius * np.cos(phi), radius * np.sin(phi), heights[:, None]), axis=-1
    )
    lengths = np.linalg.norm(normals @ _cofactors(axes).T, axis=-1)
    return float((weights @ lengths).sum() * (2 * math.pi / 256))


def tube_area(axes: Doubles) -> float:
    """Return the lateral area of the image of the tube of radius and length 1."""
    phi = 2 * math.pi * (np.arange(1024) + 0.5) / 1024
    normals = np.stack([np.cos(phi), np.sin(phi), np.zeros(1024)], axis=-1)
    lengths = np.linalg.norm(normals @ _cofactors(axes).T, axis=-1)
    return float(lengths.mean() * 2 * math.pi)


def to_mesh(name: str, solid: Solid, properties: Any) -> Any:
    """Return Mitsuba's mesh with flat faces; `properties` carry its BSDF and emitter."""
    shape = mi.Mesh(name, len(solid.points), len(solid.triangles), props=properties)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = solid.points.ravel()
    parameters["faces"] = solid.triangles.ravel()
    parameters.update()
    return shape


def _cofactors(axes: Doubles) -> Doubles:
    """Return the matrix that turns normals, unscaled: its columns are products of two axes."""
    a, b, c = axes.T
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)


def _placed(rings: Doubles, matrix: Doubles) -> Solid:
    """Return the mesh between rings of points, the first on top."""
    count, around, _ = rings.shape
    row, column = np.meshgrid(np.arange(count - 1), np.arange(around), indexing="ij")
    after = (column + 1) % around
    corners = [row * around + column, (row + 1) * around + column,
               (row + 1) * around + after, row * around + after]  # fmt: skip
    a, b, c, d = (corner.ravel() for corner in corners)
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    points = (rings.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32)
    # At a pole two corners of a triangle fall together.
    area = _triangle_areas(points.astype(np.float64), triangles)
    triangles = triangles[area > area.max() * 1e-9]
    if mirrors(matrix):
        triangles = triangles[:, ::-1]
    return Solid(points, np.ascontiguousarray(triangles, np.uint32))


def _triangle_areas(points: Doubles, triangles: NDArray[Any]) -> Doubles:
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
