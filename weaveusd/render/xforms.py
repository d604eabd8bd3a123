"""World transforms of prims, in the units of the picture.

USD multiplies rows: p' = p M. Mitsuba multiplies columns. A single factor scales the whole
stage: Mitsuba moves the start of a ray by about 1e-4 (1 + |p|), which is a tenth of a millimetre
in a stage in metres and would part a cloth from what it lies on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
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
    """Gives world matrices, scaled by a power of two so that no digit is lost."""

    scale: float
    time: Usd.TimeCode
    _cache: UsdGeom.XformCache = field(init=False)

    def __post_init__(self) -> None:
        self._cache = UsdGeom.XformCache(self.time)

    def world(self, prim: Usd.Prim) -> Doubles:
        """Return the (4, 4) matrix from the prim's space to the picture's, columns as vectors.

        A reset transform stack is honored.
        """
        matrix = np.array(self._cache.GetLocalToWorldTransform(prim), np.float64).T
        return np.diag((self.scale, self.scale, self.scale, 1.0)) @ matrix

    def unscaled(self, prim: Usd.Prim) -> Doubles:
        """Return the matrix in the units of the stage."""
        return np.array(self._cache.GetLocalToWorldTransform(prim), np.float64).T


def picture_scale(bounds: tuple[Doubles, Doubles] | None) -> float:
    """Return the power of two that brings the diagonal of `bounds` between 512 and 1024."""
    if bounds is None:
        return 1.0
    diagonal = float(np.linalg.norm(bounds[1] - bounds[0]))
    if not 0 < diagonal < math.inf:
        return 1.0
    return float(2.0 ** math.floor(math.log2(_EXTENT / diagonal)))


def stage_bounds(stage: Usd.Stage, time: Usd.TimeCode) -> tuple[Doubles, Doubles] | None:
    """Return the corners of what is rendered, in the units of the stage; None if nothing is."""
    cache = UsdGeom.BBoxCache(time, [UsdGeom.Tokens.default_, UsdGeom.Tokens.render])
    box = cache.ComputeWorldBound(stage.GetPseudoRoot()).ComputeAlignedRange()
    if box.IsEmpty():
        return None
    low, high = np.array(box.GetMin(), np.float64), np.array(box.GetMax(), np.float64)
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        return None
    return low, high


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
