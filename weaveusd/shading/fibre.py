"""The frame of a fibre: inclinations and azimuths of a pair of directions."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Doubles = NDArray[np.float64]


class Fibre(NamedTuple):
    """Two directions in a fibre's frame, its normal turned to the side of wi. All (…), radians."""

    theta_i: Doubles
    theta_o: Doubles
    cos_i: Doubles  # cos θi
    cos_o: Doubles  # cos θo
    phi_i: Doubles
    phi_o: Doubles
    n_dot_o: Doubles

    @property
    def theta_h(self) -> Doubles:
        """Half of the sum of the inclinations."""
        return np.asarray(0.5 * (self.theta_i + self.theta_o))

    @property
    def theta_d(self) -> Doubles:
        """Half of the difference of the inclinations."""
        return np.asarray(0.5 * (self.theta_i - self.theta_o))

    @property
    def phi_d(self) -> Doubles:
        """φi − φo, wrapped to -π…π."""
        return np.asarray(np.remainder(self.phi_i - self.phi_o + np.pi, 2 * np.pi) - np.pi)


def in_fibre_frame(wi: ArrayLike, wo: ArrayLike, n: ArrayLike, t: ArrayLike) -> Fibre:
    """Return `wi` and `wo` in the frame of normal `n` and fibre `t`, all (…, 3) and unit."""
    wi, wo, n, t = (np.asarray(v, float) for v in (wi, wo, n, t))
    n = facing(n, wi)
    b = np.cross(n, t)
    sin_i, sin_o = np.clip(dot(wi, t), -1, 1), np.clip(dot(wo, t), -1, 1)
    return Fibre(
        np.arcsin(sin_i),
        np.arcsin(sin_o),
        np.sqrt(1 - sin_i**2),
        np.sqrt(1 - sin_o**2),
        np.arctan2(dot(wi, b), dot(wi, n)),
        np.arctan2(dot(wo, b), dot(wo, n)),
        dot(wo, n),
    )


def facing(n: Doubles, wi: Doubles) -> Doubles:
    """Return `n` turned to the side of `wi`: a yarn has two faces."""
    return np.where(dot(n, wi)[..., None] < 0, -n, n)


def dot(a: Doubles, b: Doubles) -> Doubles:
    """Return the inner products (…) of the vectors (…, 3)."""
    return np.asarray(np.sum(a * b, -1))
