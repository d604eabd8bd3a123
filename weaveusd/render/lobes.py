"""The microcylinder BSDF of a yarn on Dr.Jit arrays: its value.

After Sadeghi et al. 2013, normalized so that the base color is an albedo. Directions, the normal
`n` and the tangent `t` share one frame; `wi` is where the viewer is, `wo` where light comes from,
both away from the surface. A yarn has two faces: `n` is turned to the side of `wi`. With
b = n × t,

    sin θ = ω·t,  φ = atan2(ω·b, ω·n),  θ_h = (θi + θo)/2,  θ_d = (θi − θo)/2,  φ_d = φi − φo
    m = max(cos θi, cos θo),  F exact Fresnel,  T = 1 − F,  C(γ; θ_h) the profile of a lobe
    f_R = k_s F(cos θ_d cos(φ_d/2)) cos(φ_d/2) · ½ C(γ_s) · 3 / (4 √2 m²)     same side only
    f_V = s ½ T(cos θi) T(cos θo) [(1 − k_d) ½ C(γ_v)/m² + k_d ½/(cos θi + cos θo)]
    value = (f_R + A N_V f_V) |n·ωo|,   s = 1 − τ on the side of ωi, τ on the other

Everything is written for the active variant, single precision or scalar.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import drjit as dr

from weaveusd.render.longitudinal import profile

Float = Any
Color = Any
Vector = Any

MEAN_COSINE = 4 * 2**0.5 / 3
"""∫ cos(φ/2) cos φ dφ over the side of n; κ_R, the surface lobe's scale, is its inverse."""

TINY = 1e-12
SMALLEST_COSINE = 1e-6
"""cos θ is no smaller: at the poles of the fibre, φ loses its meaning."""


@dataclass(frozen=True, slots=True)
class LobeParameters:
    """Optics of one yarn, one array each; angles in radians."""

    color: Color  # A, the albedo of the yarn
    eta: Float
    k_d: Float
    k_s: Float
    gamma_s: Float
    gamma_v: Float
    tau: Float
    normalization: Float  # N_V
    gaussian: bool = False  # the profile of both lobes, the same for all yarns


@dataclass(frozen=True, slots=True)
class Direction:
    """A direction in a yarn's frame: inclination θ from the plane across the fibre, azimuth φ."""

    theta: Float
    sin_theta: Float
    cos_theta: Float
    sin_phi: Float
    cos_phi: Float

    @property
    def n(self) -> Float:
        """Return the cosine to the normal."""
        return self.cos_theta * self.cos_phi


@dataclass(frozen=True, slots=True)
class Fibre:
    """A yarn's frame, the normal on the viewer's side, and the viewer in it."""

    n: Vector
    t: Vector
    b: Vector
    wi: Direction

    def direction(self, w: Vector) -> Direction:
        """Return the unit vector `w` in the yarn's frame."""
        return _direction(self.n, self.t, self.b, w)

    def vector(self, w: Direction) -> Vector:
        """Return the unit vector of a direction of the yarn's frame."""
        across = w.cos_theta * w.sin_phi
        return dr.normalize(self.n * w.n + self.b * across + self.t * w.sin_theta)


def fibre(wi: Vector, n: Vector, t: Vector) -> Fibre:
    """Return the yarn with unit normal `n` and tangent `t` as seen from `wi`."""
    n = n * dr.select(dr.dot(n, wi) < 0, -1.0, 1.0)
    b = dr.cross(n, t)
    return Fibre(n, t, b, _direction(n, t, b, wi))


def value(
    yarn: LobeParameters,
    fibre: Fibre,
    wo: Direction,
    spread: Callable[[Float], Float] | None = None,
) -> Color:
    """Return f |n·ωo|, the value that Mitsuba calls a BSDF times its cosine.

    `spread` gives for a width γ what stands for C(γ; θ_h), by default the profile itself.
    """
    wi = fibre.wi
    same = wo.cos_phi > 0
    half_sum = 0.5 * (wi.theta + wo.theta)
    flattest = 1 / dr.square(dr.maximum(wi.cos_theta, wo.cos_theta))
    along = spread or (lambda gamma: profile(gamma, half_sum, yarn.gaussian))

    # Half angles by the length of a sum or by their cosine's root: cheaper than the angles.
    cos_half = 0.5 * dr.sqrt(
        dr.maximum(dr.square(wi.cos_phi + wo.cos_phi) + dr.square(wi.sin_phi + wo.sin_phi), TINY)
    )
    cos_twice = wi.cos_theta * wo.cos_theta + wi.sin_theta * wo.sin_theta
    cos_difference = dr.sqrt(dr.maximum(0.5 + 0.5 * cos_twice, TINY))

    reflected = fresnel(dr.minimum(cos_difference * cos_half, 1), yarn.eta)
    surface = yarn.k_s * reflected * cos_half * (0.5 / MEAN_COSINE) * flattest
    surface *= along(yarn.gamma_s)

    through = entering(fibre, yarn) * (1 - fresnel(wo.cos_theta, yarn.eta))
    forward = (1 - yarn.k_d) * along(yarn.gamma_v) * flattest
    isotropic = yarn.k_d / (wi.cos_theta + wo.cos_theta)
    side = dr.select(same, 1 - yarn.tau, yarn.tau)
    volume = 0.25 * side * through * (forward + isotropic)

    both = dr.select(same, surface, 0) + yarn.color * (yarn.normalization * volume)
    return dr.select(wo.n == 0, 0, both * dr.abs(wo.n))


def entering(fibre: Fibre, yarn: LobeParameters) -> Float:
    """Return T(cos θi), the share of light that enters the fibre."""
    return 1 - fresnel(fibre.wi.cos_theta, yarn.eta)


def fresnel(cosine: Float, eta: Float) -> Float:
    """Return the unpolarized reflectance of a dielectric, exact, for a cosine in 0…1.

    With g² = η² − 1 + c², F = ½ (g − c)²/(g + c)² (1 + (c(g + c) − 1)²/(c(g − c) + 1)²)
    (Cook and Torrance 1982).
    """
    g = dr.sqrt(dr.maximum(dr.square(eta) - 1 + dr.square(cosine), TINY))
    low, high = g - cosine, dr.maximum(g + cosine, TINY)
    along, across = cosine * high - 1, cosine * low + 1
    scale = low / (high * across)
    return 0.5 * dr.square(scale) * (dr.square(across) + dr.square(along))


def _direction(n: Vector, t: Vector, b: Vector, w: Vector) -> Direction:
    across, along, up = dr.dot(w, b), dr.dot(w, t), dr.dot(w, n)
    # Near the poles 1 − sin² loses all its digits; the hypotenuse keeps them.
    cos_theta = dr.sqrt(dr.maximum(dr.square(across) + dr.square(up), TINY))
    scale = 1 / cos_theta
    return Direction(dr.atan2(along, cos_theta), along, cos_theta, across * scale, up * scale)
