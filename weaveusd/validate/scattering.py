"""The judge's own statement of how a yarn scatters light, in NumPy, from docs/bsdf.md.

Neither the makers' model nor the renderer's is used here. Directions are given by their
inclination θ from the plane across the fibre and their azimuth φ from the yarn's normal; ωi leads
to the viewer, on the side of the normal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

SURFACE_SCALE = 3 / (4 * math.sqrt(2))
"""κ_R, the inverse of ∫ cos(φ/2) cos φ dφ over the side of the normal."""

INCLINATIONS, AZIMUTHS = 96, 24
"""Nodes of the integral over all directions."""

_SMALLEST = 1e-6


@dataclass(frozen=True, slots=True)
class YarnOptics:
    """The numbers of one yarn; angles in radians, `normalization` is N_V."""

    eta: float
    k_d: float
    k_s: float
    gamma_s: float
    gamma_v: float
    tau: float
    normalization: float


def lobes(
    yarn: YarnOptics, theta_i: Any, phi_i: Any, theta_o: Any, phi_o: Any
) -> tuple[Doubles, Doubles]:
    """Return f_R and N_V f_V of docs/bsdf.md, without the cosine; arguments broadcast.

    f_R is 0 on the other side, where cos φo is negative.
    """
    cos_i = np.maximum(np.cos(theta_i), _SMALLEST)
    cos_o = np.maximum(np.cos(theta_o), _SMALLEST)
    half_sum, half_difference = 0.5 * (theta_i + theta_o), 0.5 * (theta_i - theta_o)
    flattest = np.maximum(cos_i, cos_o) ** 2
    cos_half = np.abs(np.cos(0.5 * (phi_i - phi_o)))
    same = np.cos(phi_o) > 0

    mirrored = fresnel(np.cos(half_difference) * cos_half, yarn.eta)
    surface = yarn.k_s * SURFACE_SCALE * mirrored * cos_half
    surface = surface * 0.5 * _cauchy(half_sum, yarn.gamma_s) / flattest

    enters = (1 - fresnel(cos_i, yarn.eta)) * (1 - fresnel(cos_o, yarn.eta))
    forward = (1 - yarn.k_d) * 0.5 * _cauchy(half_sum, yarn.gamma_v) / flattest
    isotropic = yarn.k_d * 0.5 / (cos_i + cos_o)
    side = np.where(same, 1 - yarn.tau, yarn.tau)
    volume = yarn.normalization * side * 0.5 * enters * (forward + isotropic)
    return np.where(same, surface, 0.0), volume


def scattered(yarn: YarnOptics, theta_i: float, phi_i: float = 0.0) -> tuple[float, float]:
    """Return the shares of the light from (`theta_i`, `phi_i`) in the surface and volume lobe.

    ∫ f |n·ωo| dωo over both sides, for A = 1. In the volume lobe the integral around the fibre is
    closed: ∫ |cos φ| dφ is 2 on either side, of which one gets 1 − τ and the other τ. Nodes along
    θ are spread as the lobe is, so that none is too narrow for them.
    """
    incoming = np.float64(theta_i), np.float64(phi_i)
    phi, d_phi = _azimuths()
    theta, d_theta = _inclinations(theta_i, yarn.gamma_s)
    value, _ = lobes(yarn, *incoming, theta[:, None], phi)
    around = np.sum(value * np.cos(phi) * d_phi, axis=1)
    surface = float(np.sum(around * np.cos(theta) ** 2 * d_theta))
    theta, d_theta = _inclinations(theta_i, yarn.gamma_v)
    _, front = lobes(yarn, *incoming, theta, np.float64(0))
    _, back = lobes(yarn, *incoming, theta, np.float64(math.pi))
    volume = float(np.sum(2 * (front + back) * np.cos(theta) ** 2 * d_theta))
    return surface, volume


def surface_above(yarn: YarnOptics, normal: Doubles, tangent: Doubles, viewer: Doubles) -> float:
    """Return the share of the light of an even sky that the surface lobe sends to `viewer`.

    ∫ f_R |n·ωo| dωo over the directions on the yarn's side that lie above the cloth, whose normal
    is Z. `normal` and `tangent` (3,) are a texel's, `viewer` (3,) is a direction, all unit.
    """
    n = normal if normal @ viewer > 0 else -normal
    b = np.cross(n, tangent)
    theta_i = math.asin(max(-1.0, min(1.0, float(tangent @ viewer))))
    phi_i = math.atan2(float(b @ viewer), float(n @ viewer))
    phi, d_phi = _azimuths()
    theta, d_theta = _inclinations(theta_i, yarn.gamma_s)
    cos_o, sin_o = np.cos(theta)[:, None], np.sin(theta)[:, None]
    up = cos_o * (np.cos(phi) * n[2] + np.sin(phi) * b[2]) + sin_o * tangent[2]
    value, _ = lobes(yarn, theta_i, phi_i, theta[:, None], phi)
    weights = cos_o**2 * np.cos(phi) * d_theta[:, None] * d_phi
    return float(np.sum(np.where(up * viewer[2] > 0, value * weights, 0.0)))


def fresnel(cosine: Any, eta: float) -> Any:
    """Return the unpolarized reflectance of a dielectric of index `eta` from outside."""
    cosine = np.clip(cosine, 0.0, 1.0)
    inside = np.sqrt(np.maximum(1 - (1 - cosine**2) / eta**2, 0.0))
    parallel = (eta * cosine - inside) / (eta * cosine + inside)
    perpendicular = (cosine - eta * inside) / (cosine + eta * inside)
    return 0.5 * (parallel**2 + perpendicular**2)


def _cauchy(x: Any, gamma: float) -> Any:
    return gamma / (np.pi * (x**2 + gamma**2))


def _azimuths() -> tuple[Doubles, Doubles]:
    """Return nodes and weights in −π/2…π/2, the side of the normal."""
    x, w = _legendre(AZIMUTHS)
    return 0.5 * np.pi * x, 0.5 * np.pi * w


def _inclinations(theta_i: float, gamma: float) -> tuple[Doubles, Doubles]:
    """Return nodes θo in −π/2…π/2 and their weights for a lobe of width `gamma` around −`theta_i`.

    θo = 2 γ tan u − θi, u even between the bounds by Gauss and Legendre.
    """
    low = math.atan2(-math.pi / 2 + theta_i, 2 * gamma)
    high = math.atan2(math.pi / 2 + theta_i, 2 * gamma)
    x, w = _legendre(INCLINATIONS)
    u = low + 0.5 * (high - low) * (x + 1)
    theta = np.clip(2 * gamma * np.tan(u) - theta_i, -math.pi / 2, math.pi / 2)
    return theta, 0.5 * (high - low) * w * 2 * gamma / np.cos(u) ** 2


@cache
def _legendre(count: int) -> tuple[Doubles, Doubles]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return nodes, weights
