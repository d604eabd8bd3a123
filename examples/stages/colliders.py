"""Solid things that cloth lies on: the ground, ellipsoids and boxes. Lengths in metres."""

from __future__ import annotations

from typing import TYPE_CHECKING

import kernels
import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

_UPRIGHT = np.eye(3)


class Colliders:
    """A list of solids, each larger by the `thickness` at which cloth stops."""

    def __init__(self, thickness: float) -> None:
        self.thickness = thickness
        self._rows: list[Doubles] = []

    @property
    def table(self) -> Doubles:
        """(C, 16): kind, center, half axes, rows of the rotation into the solid's frame."""
        return np.array(self._rows).reshape(-1, 16)

    def ground(self, height: float = 0.0) -> Colliders:
        """Add the ground: y is at least `height`."""
        return self._add(kernels.PLANE, (0, height, 0), (0, 0, 0), _UPRIGHT)

    def ellipsoid(self, center: Sequence[float], half: Sequence[float]) -> Colliders:
        """Add an ellipsoid, upright."""
        return self._add(kernels.ELLIPSOID, center, half, _UPRIGHT)

    def box(
        self, center: Sequence[float], half: Sequence[float], axes: Doubles = _UPRIGHT
    ) -> Colliders:
        """Add a box whose own x, y and z are the rows of `axes`."""
        return self._add(kernels.BOX, center, half, axes)

    def _add(
        self, kind: int, center: Sequence[float], half: Sequence[float], axes: Doubles
    ) -> Colliders:
        middle = np.array(center, float)
        if kind == kernels.PLANE:
            middle[1] += self.thickness
        larger = np.array(half, float) + self.thickness
        self._rows.append(np.concatenate(((kind,), middle, larger, axes.ravel())))
        return self
