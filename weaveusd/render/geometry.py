"""Shapes in spaces of their own, and where copies of them stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]


Bounds = tuple["Doubles", "Doubles"]
"""The lowest and the highest corner of a box."""


@dataclass(frozen=True, slots=True, eq=False)
class Facets:
    """Triangles that face the side from which their vertices turn counter-clockwise."""

    points: Doubles  # (V, 3)
    triangles: Indices  # (T, 3)
    normals: Doubles | None = None  # (V, 3) unit
    uv: Doubles | None = None  # (V, 2)
    attributes: Mapping[str, Doubles] = field(default_factory=dict)  # (V, k), Mitsuba's names

    def corners(self) -> Doubles:
        """Return the corners of a box around the shape, (8, 3)."""
        return box(self.points)

    def weight(self) -> int:
        """Return how many primitives one copy is."""
        return len(self.triangles)


@dataclass(frozen=True, slots=True, eq=False)
class Strands:
    """Tubes along curves: straight ones between two points, or cubic B-splines of four."""

    cubic: bool
    controls: Doubles  # (P, 4) place and radius
    segments: Indices  # (S,) first control of each segment

    def corners(self) -> Doubles:
        """Return the corners of a box around the shape, (8, 3)."""
        radius = np.abs(self.controls[:, 3:])
        centers = self.controls[:, :3]
        return box(np.concatenate((centers - radius, centers + radius)))

    def weight(self) -> int:
        """Return how many primitives one copy is."""
        return len(self.segments)


@dataclass(frozen=True, slots=True, eq=False)
class Balls:
    """Spheres."""

    centers: Doubles  # (N, 3)
    radii: Doubles  # (N,)

    def corners(self) -> Doubles:
        """Return the corners of a box around the shape, (8, 3)."""
        radius = self.radii[:, None]
        return box(np.concatenate((self.centers - radius, self.centers + radius)))

    def weight(self) -> int:
        """Return how many primitives one copy is."""
        return len(self.radii)


Shape = Facets | Strands | Balls


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Copies of a shape: matrices (N, 4, 4) to the world, vectors as columns, in stage units."""

    prim: str
    shape: Shape
    matrices: Doubles
    look: Any  # materials.Look
    both_sides: bool

    def repeated(self) -> int:
        """Return how many primitives the copies after the first are."""
        return self.shape.weight() * (len(self.matrices) - 1)

    def bounds(self) -> Bounds:
        """Return the lowest and the highest corner of all copies."""
        linear = self.matrices[:, :3, :3] @ self.shape.corners().T
        placed = linear + self.matrices[:, :3, 3:]
        return placed.min(axis=(0, 2)), placed.max(axis=(0, 2))


def box(points: Doubles) -> Doubles:
    """Return the eight corners (8, 3) of the box around points (n, 3)."""
    low, high = points.min(axis=0), points.max(axis=0)
    choice = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    return np.asarray(np.where(choice == 1, high, low))
