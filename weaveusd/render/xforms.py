"""World transforms of prims, in the units of the picture.

USD multiplies rows: p' = p M. Mitsuba multiplies columns. A single factor scales the whole
stage: Mitsuba moves the start of a ray by about 1e-4 (1 + |p|), which is a tenth of a millimetre
in a stage in metres and would part a cloth from what it lies on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np
from pxr import Usd, UsdGeom

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

_EXTENT = 1024.0
"""Diagonal, or twice it, of the scaled stage: then the 1 above counts no more than 1/500."""


@dataclass(slots=True)
class Placing:
    """Gives world matrices, scaled by a power of two so that no digit is lost.

    For a copy of what lies below `root`, `base` leads from the space around the copy's root to
    the world.
    """

    scale: float
    time: Usd.TimeCode
    root: Usd.Prim | None = None
    base: Doubles = field(default_factory=lambda: np.eye(4))
    _cache: UsdGeom.XformCache = field(init=False)

    def __post_init__(self) -> None:
        self._cache = UsdGeom.XformCache(self.time)

    def world(self, prim: Usd.Prim) -> Doubles:
        """Return the (4, 4) matrix from the prim's space to the picture's, columns as vectors.

        A reset transform stack is honored.
        """
        return np.diag((self.scale, self.scale, self.scale, 1.0)) @ self.unscaled(prim)

    def unscaled(self, prim: Usd.Prim) -> Doubles:
        """Return the matrix in the units of the stage, without a perspective part."""
        matrix = self.authored(prim)
        matrix[3] = (0.0, 0.0, 0.0, 1.0)
        return self.base @ matrix

    def authored(self, prim: Usd.Prim) -> Doubles:
        """Return the matrix up to the root of the stage or of the copy, perspective and all."""
        if self.root is None:
            return np.array(self._cache.GetLocalToWorldTransform(prim), np.float64).T
        relative, _ = self._cache.ComputeRelativeTransform(prim, self.root.GetParent())
        return np.array(relative, np.float64).T

    def copied(self, matrix: Doubles) -> Placing:
        """Return the placing of the same copy moved by a (4, 4) matrix of the world."""
        return replace(self, base=matrix @ self.base)

    def below(self, root: Usd.Prim) -> Placing:
        """Return the placing of a copy of `root` whose surrounding space is the world."""
        return Placing(self.scale, self.time, root)

    def scaled(self, scale: float) -> Placing:
        """Return the same placing with other units of the picture."""
        return replace(self, scale=scale)


def picture_scale(bounds: tuple[Doubles, Doubles] | None) -> float:
    """Return the power of two that brings the diagonal of `bounds` between 512 and 1024."""
    if bounds is None:
        return 1.0
    diagonal = float(np.linalg.norm(bounds[1] - bounds[0]))
    if not 0 < diagonal < math.inf:
        return 1.0
    return float(2.0 ** math.floor(math.log2(_EXTENT / diagonal)))


def to_mitsuba(matrix: Doubles) -> Any:
    """Return Mitsuba's transform of a matrix with vectors as columns."""
    return mi.ScalarTransform4f(np.ascontiguousarray(matrix, np.float64))


def mirrors(matrix: Doubles) -> bool:
    """Return whether the matrix turns a right hand into a left one."""
    return bool(np.linalg.det(matrix[:3, :3]) < 0)


def singular(matrix: Doubles) -> bool:
    """Return whether the matrix flattens space, or holds a value that is no number."""
    if not np.isfinite(matrix).all():
        return True
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    return bool(lengths.min() == 0 or abs(np.linalg.det(matrix[:3, :3] / lengths)) < 1e-9)


def uniform_scale(matrix: Doubles) -> float | None:
    """Return the scale of a matrix that keeps angles, else None."""
    squares = matrix[:3, :3].T @ matrix[:3, :3]
    mean = float(np.trace(squares)) / 3
    return math.sqrt(mean) if np.allclose(squares, np.eye(3) * mean, atol=1e-5 * mean) else None


def rotation(axis: str, degrees: float) -> Doubles:
    """Return the (4, 4) rotation about a coordinate axis, counter-clockwise seen from its tip."""
    angle = math.radians(degrees)
    c, s = math.cos(angle), math.sin(angle)
    i, j = {"X": (1, 2), "Y": (2, 0), "Z": (0, 1)}[axis]
    matrix = np.eye(4)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


def scaling(x: float, y: float, z: float) -> Doubles:
    """Return the (4, 4) scaling."""
    return np.diag((x, y, z, 1.0))
