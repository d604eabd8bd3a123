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


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A triangle mesh, its triangles counter-clockwise seen from outside."""

    points: Doubles  # (P, 3)
    triangles: NDArray[np.uint32]  # (T, 3)


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
    parameters["vertex_positions"] = np.ascontiguousarray(solid.points, np.float32).ravel()
    parameters["faces"] = np.ascontiguousarray(solid.triangles, np.uint32).ravel()
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
    points = rings.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    # At a pole two corners of a triangle fall together.
    sides = np.cross(points[triangles[:, 1]] - points[triangles[:, 0]],
                     points[triangles[:, 2]] - points[triangles[:, 0]])  # fmt: skip
    area = np.linalg.norm(sides, axis=1)
    triangles = triangles[area > area.max() * 1e-9]
    if mirrors(matrix):
        triangles = triangles[:, ::-1]
    return Solid(points, triangles.astype(np.uint32))
