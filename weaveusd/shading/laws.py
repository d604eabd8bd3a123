"""What the cloth BSDF must keep to, measured by quadrature: density, energy, reciprocity.

The fibre runs along Y under the normal Z. A direction is told by its inclination θ to the plane
across the fibre and its azimuth φ around it: ω = (cos θ sin φ, sin θ, cos θ cos φ).
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.shading.microcylinder import evaluate, lobes
from weaveusd.shading.sampling import pdf

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from weaveusd.shading.microcylinder import Parameters

    Doubles = NDArray[np.float64]

NORMAL = (0.0, 0.0, 1.0)
ALONG = (0.0, 1.0, 0.0)

_NODES = 32
_PAIRS = 500


class Sides(NamedTuple):
    """Integrals over the directions on the side of the normal and on the other."""

    front: float
    back: float

    @property
    def whole(self) -> float:
        """Integral over all directions."""
        return self.front + self.back


def direction(theta: ArrayLike, phi: ArrayLike) -> Doubles:
    """Return the unit vectors (…, 3) at inclination `theta` and azimuth `phi` in radians."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    return np.stack(
        [np.cos(theta) * np.sin(phi), np.sin(theta), np.cos(theta) * np.cos(phi)], axis=-1
    )


def sphere(theta_i: float, params: Parameters) -> tuple[Doubles, Doubles]:
    """Return nodes (θ, φ, 3) and weights (θ, φ) of an integral over all directions.

    Gauss–Legendre pieces end at the kinks ±θi of the model, around the peaks of both lobes at
    -θi, and where φ changes side. The second half of the azimuths is the other side.
    """
    gammas = (params.gamma_s, params.gamma_v)
    peaks = [-theta_i + sign * k * g for g in gammas for sign in (-1, 1) for k in (1, 4, 16)]
    quarter = np.pi / 2
    borders = np.unique(np.clip([*peaks, theta_i, -theta_i, -quarter, quarter], -quarter, quarter))
    x, w = np.polynomial.legendre.leggauss(_NODES)
    pieces = [(0.5 * (b - a) * x + 0.5 * (a + b), 0.5 * (b - a) * w) for a, b in pairwise(borders)]
    theta = np.concatenate([nodes for nodes, _ in pieces])
    w_theta = np.concatenate([weights for _, weights in pieces]) * np.cos(theta)
    phi = np.concatenate([quarter * x, quarter * x + np.pi])
    w_phi = quarter * np.concatenate([w, w])
    return direction(theta[:, None], phi), w_theta[:, None] * w_phi


def density_integral(params: Parameters, theta: float, phi: float = 0.0) -> Sides:
    """Return ∫ pdf dω for light seen from (θ, φ): together they are 1."""
    return _integral(lambda wi, wo: pdf(wi, wo, NORMAL, ALONG, params), params, theta, phi)


def directional_albedo(params: Parameters, theta: float, phi: float = 0.0) -> Sides:
    """Return the reflected and the transmitted share of light, seen from (θ, φ).

    It is that of the color channel with the largest A, and together never more than 1.
    """
    return _integral(
        lambda wi, wo: evaluate(wi, wo, NORMAL, ALONG, params).max(-1), params, theta, phi
    )


def reciprocity_error(params: Parameters) -> float:
    """Return the largest |f(ωi, ωo) − f(ωo, ωi)| over their sum, f_R and f_V, 500 random pairs."""
    rng = np.random.default_rng(1)
    pairs = rng.normal(size=(2, _PAIRS, 3))
    wi, wo = pairs / np.linalg.norm(pairs, axis=-1, keepdims=True)
    forth = np.stack(lobes(wi, wo, NORMAL, ALONG, params))
    back = np.stack(lobes(wo, wi, NORMAL, ALONG, params))
    total = forth + back
    error = np.divide(np.abs(forth - back), total, where=total > 0, out=np.zeros_like(total))
    return float(error.max())


def _integral(
    value: Callable[[Doubles, Doubles], Doubles], params: Parameters, theta: float, phi: float
) -> Sides:
    wo, weight = sphere(theta, params)
    at = value(direction(theta, phi), wo) * weight
    sides = at.reshape(len(wo), 2, _NODES).sum(axis=(0, 2))
    return Sides(float(sides[0]), float(sides[1]))
