"""The factor N_V that makes the volume lobe's color an albedo."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.longitudinal import profile

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

SURFACE_SCALE = 3 / (4 * math.sqrt(2))
"""κ_R = 1 / ∫ cos(φ/2) cos φ dφ over the side of n, the surface lobe's scale (docs/bsdf.md)."""

GRAZING = math.pi / 2 - 1e-3
"""The steepest inclination at which albedos are compared."""


def surface_albedo(
    theta_i: float, eta: float, k_s: float, gamma_s: float, gaussian: bool = False
) -> float:
    """Return E_R, the directional albedo of the surface lobe at φi = 0 (docs/bsdf.md)."""
    theta_o, w_theta = _inclinations(theta_i, gamma_s)
    phi_o, w_phi = _gauss(-np.pi / 2, np.pi / 2, 48)
    half = np.cos(phi_o / 2)
    cos_d = np.cos(0.5 * (theta_i - theta_o))[:, None] * half
    azimuth = np.sum(reflectance(cos_d, eta) * half * np.cos(phi_o) * w_phi, 1)
    lobe = _longitudinal(theta_i, theta_o, gamma_s, gaussian)
    return float(k_s * SURFACE_SCALE * np.sum(azimuth * lobe * np.cos(theta_o) ** 2 * w_theta))


def volume_albedo(
    theta_i: float, eta: float, k_d: float, gamma_v: float, gaussian: bool = False
) -> float:
    """Return E_V, the directional albedo of the volume lobe for A = 1 (docs/bsdf.md)."""
    theta_o, w_theta = _inclinations(theta_i, gamma_v)
    cos_i, cos_o = np.cos(theta_i), np.cos(theta_o)
    enter, leave = 1 - reflectance(cos_i, eta), 1 - reflectance(cos_o, eta)
    scatter = (1 - k_d) * _longitudinal(theta_i, theta_o, gamma_v, gaussian)
    scatter = scatter + k_d * 0.5 / (cos_i + cos_o)
    return float(np.sum(0.5 * enter * leave * scatter * 2 * cos_o**2 * w_theta))


@lru_cache(maxsize=1024)
def normalization(
    eta: float, k_d: float, k_s: float, gamma_s: float, gamma_v: float, gaussian: bool = False
) -> float:
    """Return N_V = (1 − max E_R) / max E_V, the maxima over the inclination (docs/bsdf.md).

    With it, reflection plus transmission never exceed 1 for A, k_s ≤ 1. Angles in radians;
    `gaussian` lobes have other tails, hence another factor.
    """
    surface = _maximum(lambda theta: surface_albedo(theta, eta, k_s, gamma_s, gaussian))
    volume = _maximum(lambda theta: volume_albedo(theta, eta, k_d, gamma_v, gaussian))
    return (1 - surface) / volume


def _longitudinal(theta_i: float, theta_o: Doubles, gamma: float, gaussian: bool) -> Doubles:
    m = np.maximum(np.cos(theta_i), np.cos(theta_o))
    lobe = profile(gamma, 0.5 * (theta_i + theta_o), is_gaussian=gaussian)
    return np.asarray(0.5 * lobe / m**2)


def _maximum(albedo: Callable[[float], float]) -> float:
    """Return the maximum of `albedo` over 0 ≤ θ ≤ `GRAZING`: a coarse search, then a fine one."""
    grid = np.linspace(0, GRAZING, 49)
    values = [albedo(float(theta)) for theta in grid]
    best = int(np.argmax(values))
    low, high = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, 48)])
    golden = 0.5 * (math.sqrt(5) - 1)
    for _ in range(40):
        left, right = high - golden * (high - low), low + golden * (high - low)
        if albedo(left) < albedo(right):
            low = left
        else:
            high = right
    return max(albedo(0.5 * (low + high)), values[best])


def _inclinations(theta_i: float, gamma: float) -> tuple[Doubles, Doubles]:
    """Return nodes and weights in θo, with borders at the kinks ±θi and around the lobe's peak."""
    spread = [-theta_i + sign * k * gamma for sign in (-1, 1) for k in (1, 4, 16)]
    borders = np.clip([-np.pi / 2, -abs(theta_i), abs(theta_i), np.pi / 2, *spread],
                      -np.pi / 2, np.pi / 2)  # fmt: skip
    pieces = [_gauss(a, b, 32) for a, b in pairwise(np.unique(borders)) if b - a > 1e-12]
    return np.concatenate([x for x, _ in pieces]), np.concatenate([w for _, w in pieces])


def _gauss(low: float, high: float, count: int) -> tuple[Doubles, Doubles]:
    nodes, weights = _legendre(count)
    half = 0.5 * (high - low)
    return half * nodes + 0.5 * (high + low), half * weights


@lru_cache(maxsize=8)
def _legendre(count: int) -> tuple[Doubles, Doubles]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights
