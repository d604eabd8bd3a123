"""The microcylinder BSDF of a yarn, on Dr.Jit arrays: evaluate, density, sample.

After Sadeghi et al. 2013 (lobes) and Wang et al. 2014 (sampling), normalized so that the base
color is an albedo. Directions, the normal `n` and the tangent `t` share one frame; `wi` is where
the viewer is, `wo` where light comes from, both away from the surface. A yarn has two faces: `n`
is turned to the side of `wi`. With b = n × t,

    sin θ = ω·t,  φ = atan2(ω·b, ω·n),  θ_h = (θi + θo)/2,  θ_d = (θi − θo)/2,  φ_d = φi − φo
    C(γ; x) = γ / (π (x² + γ²)),  m = max(cos θi, cos θo),  F exact Fresnel,  T = 1 − F
    f_R = k_s F(cos θ_d cos(φ_d/2)) cos(φ_d/2) · ½ C(γ_s; θ_h) · 3 / (4 √2 m²)     same side only
    f_V = s ½ T(cos θi) T(cos θo) [(1 − k_d) ½ C(γ_v; θ_h)/m² + k_d ½/(cos θi + cos θo)]
    value = (f_R + A N_V f_V) |n·ωo|,   s = 1 − τ on the side of ωi, τ on the other

Everything is written for the active variant, single precision or scalar.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

Float = Any
Color = Any
Vector = Any
Mask = Any

MEAN_COSINE = 4 * 2**0.5 / 3
"""∫ cos(φ/2) cos φ dφ over the side of n; κ_R, the surface lobe's scale, is its inverse."""

_TINY = 1e-12
_HALF_PI = 0.5 * 3.14159265358979
_FULL_COSINE_WIDTH = 0.41887902  # 24°: from this γ_v on, a third of the volume is cosine
_NO_COSINE_WIDTH = 0.20943951  # 12°


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


@dataclass(frozen=True, slots=True)
class _Frame:
    """A yarn's frame with `wi` measured in it."""

    n: Vector
    t: Vector
    b: Vector
    wi: _Measured


@dataclass(frozen=True, slots=True)
class _Measured:
    """One direction in a yarn's frame."""

    theta: Float
    cos_theta: Float
    n: Float  # cos θ cos φ, the cosine to the normal
    b: Float  # cos θ sin φ


@dataclass(frozen=True, slots=True)
class _Mixture:
    """Shares of the sampling strategies for a given `wi`, and the bounds of the CDFs."""

    surface: Float  # p_R
    across: Float  # probability of the other side, within cosine and volume alike
    cosine: Float  # w_c
    alive: Mask  # whether the yarn sends any light back at all


def evaluate(wi: Vector, wo: Vector, n: Vector, t: Vector, yarn: LobeParameters) -> Color:
    """Return f |n·ωo|, the value that Mitsuba calls a BSDF times its cosine."""
    frame = _frame(wi, n, t)
    return _evaluate(frame, _measure(frame, wo), yarn)


def pdf(wi: Vector, wo: Vector, n: Vector, t: Vector, yarn: LobeParameters) -> Float:
    """Return the density of `sample` at `wo` per solid angle; 0 wherever the value is 0.

    The density is even for the black yarn that nothing comes from 0.
    """
    frame = _frame(wi, n, t)
    return _pdf(frame, _measure(frame, wo), yarn)


def evaluate_pdf(
    wi: Vector, wo: Vector, n: Vector, t: Vector, yarn: LobeParameters
) -> tuple[Color, Float]:
    """Return what `evaluate` and `pdf` return."""
    frame = _frame(wi, n, t)
    measured = _measure(frame, wo)
    return _evaluate(frame, measured, yarn), _pdf(frame, measured, yarn)


def sample(
    choice: Float, point: Any, wi: Vector, n: Vector, t: Vector, yarn: LobeParameters
) -> Vector:
    """Return a direction distributed after `pdf`.

    `choice` and the two components of `point` are uniform in [0, 1); `choice` is stretched back
    to that range after every decision taken with it.
    """
    frame = _frame(wi, n, t)
    mix = _mixture(frame, yarn)

    is_cosine, choice = _decide(choice, mix.cosine)
    is_surface, rest = _decide(choice, mix.surface)
    choice = dr.select(is_cosine, choice, rest)
    is_across, rest = _decide(choice, dr.select(is_cosine, mix.across, yarn.tau))
    is_across &= is_cosine | _not(is_surface)
    choice = dr.select(is_surface & _not(is_cosine), choice, rest)
    is_flat, _ = _decide(choice, yarn.k_d)
    is_flat &= _not(is_surface)

    # Longitude and inclination of the lobes
    gamma = dr.select(is_surface, yarn.gamma_s, yarn.gamma_v)
    upper, lower = _bounds(frame.wi.theta, gamma)
    theta = 2 * gamma * dr.tan(lower + point[0] * (upper - lower)) - frame.wi.theta
    theta = dr.clip(theta, -_HALF_PI, _HALF_PI)
    sin_theta, cos_theta = dr.sincos(theta)
    flat_sin = 2 * point[0] - 1
    sin_theta = dr.select(is_flat, flat_sin, sin_theta)
    cos_theta = dr.select(is_flat, dr.safe_sqrt(1 - dr.square(flat_sin)), dr.abs(cos_theta))
    sin_phi = 2 * point[1] - 1
    cos_phi = dr.safe_sqrt(1 - dr.square(sin_phi))
    lobe = mi.Vector3f(cos_theta * cos_phi, cos_theta * sin_phi, sin_theta)

    cosine = mi.warp.square_to_cosine_hemisphere(point)
    local = dr.select(is_cosine, mi.Vector3f(cosine.z, cosine.x, cosine.y), lobe)
    height = dr.select(is_across, -local.x, local.x)
    return dr.normalize(frame.n * height + frame.b * local.y + frame.t * local.z)


def fresnel(cosine: Float, eta: Float) -> Float:
    """Return the unpolarized reflectance of a dielectric, exact, for a cosine in 0…1."""
    inside = dr.safe_sqrt(1 - (1 - dr.square(cosine)) / dr.square(eta))
    across = (cosine - eta * inside) / dr.maximum(cosine + eta * inside, _TINY)
    along = (eta * cosine - inside) / dr.maximum(eta * cosine + inside, _TINY)
    return 0.5 * (dr.square(across) + dr.square(along))


def _frame(wi: Vector, n: Vector, t: Vector) -> _Frame:
    n = n * dr.select(dr.dot(n, wi) < 0, -1.0, 1.0)
    b = dr.cross(n, t)
    return _Frame(n, t, b, _measure_in(n, t, b, wi))


def _measure(frame: _Frame, w: Vector) -> _Measured:
    return _measure_in(frame.n, frame.t, frame.b, w)


def _measure_in(n: Vector, t: Vector, b: Vector, w: Vector) -> _Measured:
    across, up = dr.dot(w, b), dr.dot(w, n)
    # Near the poles 1 − sin² loses all its digits; the hypotenuse keeps them.
    cos_theta = dr.sqrt(dr.maximum(dr.square(across) + dr.square(up), _TINY))
    return _Measured(dr.atan2(dr.dot(w, t), cos_theta), cos_theta, up, across)


def _cauchy(gamma: Float, x: Float) -> Float:
    return gamma / (dr.square(x) + dr.square(gamma)) * (1 / 3.14159265358979)


def _evaluate(frame: _Frame, wo: _Measured, yarn: LobeParameters) -> Color:
    wi = frame.wi
    same = wo.n > 0
    half_sum = 0.5 * (wi.theta + wo.theta)
    half_difference = 0.5 * (wi.theta - wo.theta)
    flattest = 1 / dr.square(dr.maximum(wi.cos_theta, wo.cos_theta))

    # cos(φ_d / 2) is half the length of the sum of both unit vectors in the normal plane.
    sum_n = wi.n / wi.cos_theta + wo.n / wo.cos_theta
    sum_b = wi.b / wi.cos_theta + wo.b / wo.cos_theta
    cos_half = 0.5 * dr.sqrt(dr.maximum(dr.square(sum_n) + dr.square(sum_b), _TINY))

    reflected = fresnel(dr.clip(dr.cos(half_difference) * cos_half, 0, 1), yarn.eta)
    surface = yarn.k_s * reflected * cos_half * (0.5 / MEAN_COSINE) * flattest
    surface = dr.select(same, surface * _cauchy(yarn.gamma_s, half_sum), 0)

    through = (1 - fresnel(wi.cos_theta, yarn.eta)) * (1 - fresnel(wo.cos_theta, yarn.eta))
    forward = (1 - yarn.k_d) * _cauchy(yarn.gamma_v, half_sum) * flattest
    isotropic = yarn.k_d / (wi.cos_theta + wo.cos_theta)
    side = dr.select(same, 1 - yarn.tau, yarn.tau)
    volume = 0.25 * side * through * (forward + isotropic)

    value = surface + yarn.color * (yarn.normalization * volume)
    return dr.select(wo.n == 0, 0, value * dr.abs(wo.n))


def _mixture(frame: _Frame, yarn: LobeParameters) -> _Mixture:
    """Weigh the strategies by k_s F and A T², both at `wi`."""
    surface = yarn.k_s * fresnel(dr.clip(dr.abs(frame.wi.n), 0, 1), yarn.eta)
    volume = dr.mean(yarn.color) * dr.square(1 - fresnel(frame.wi.cos_theta, yarn.eta))
    volume = dr.select(yarn.normalization > 0, volume, 0)
    alive = (surface > 0) | (volume > 0)
    p_surface = dr.clip(surface / dr.maximum(surface + volume, _TINY), 0.1, 0.9)
    p_surface = dr.select(volume > 0, p_surface, 1)
    p_surface = dr.select(surface > 0, p_surface, dr.select(volume > 0, 0, p_surface))
    width = (yarn.gamma_v - _NO_COSINE_WIDTH) / (_FULL_COSINE_WIDTH - _NO_COSINE_WIDTH)
    cosine = dr.select(volume > 0, dr.clip(width, 0, 1) / 3, 0)
    across = (1 - p_surface) * yarn.tau
    return _Mixture(dr.detach(p_surface), dr.detach(across), dr.detach(cosine), alive)


def _bounds(theta: Float, gamma: Float) -> tuple[Float, Float]:
    """Return A and B, the arguments between which the Cauchy distribution is cut off."""
    return dr.atan((theta + _HALF_PI) / (2 * gamma)), dr.atan((theta - _HALF_PI) / (2 * gamma))


def _density(theta_i: Float, half_sum: Float, gamma: Float) -> Float:
    """Return the density in θo of the Cauchy lobe between −π/2 and π/2."""
    upper, lower = _bounds(theta_i, gamma)
    return gamma / (2 * (upper - lower) * (dr.square(half_sum) + dr.square(gamma)))


def _pdf(frame: _Frame, wo: _Measured, yarn: LobeParameters) -> Float:
    mix = _mixture(frame, yarn)
    same = wo.n > 0
    theta_i = frame.wi.theta
    half_sum = 0.5 * (theta_i + wo.theta)
    volume = (1 - yarn.k_d) * _density(theta_i, half_sum, yarn.gamma_v)
    volume += yarn.k_d * 0.5 * wo.cos_theta
    surface = mix.surface * _density(theta_i, half_sum, yarn.gamma_s)

    side = dr.select(same, 1 - yarn.tau, yarn.tau)
    lobes = dr.select(same, surface, 0) + (1 - mix.surface) * side * volume
    lobes *= 0.5 / dr.square(wo.cos_theta)
    flat = dr.select(same, 1 - mix.across, mix.across) * (1 / 3.14159265358979)
    density = ((1 - mix.cosine) * lobes + mix.cosine * flat) * dr.abs(wo.n)
    return dr.select(mix.alive & (wo.n != 0), density, 0)


def _decide(choice: Float, probability: Float) -> tuple[Mask, Float]:
    """Return whether `choice` falls below `probability`, and `choice` stretched to 0…1 again."""
    taken = choice < probability
    low = choice / dr.maximum(probability, _TINY)
    high = (choice - probability) / dr.maximum(1 - probability, _TINY)
    return taken, dr.clip(dr.select(taken, low, high), 0, 0.99999994)


def _not(mask: Mask) -> Mask:
    """Return the complement; `~` of a scalar variant's bool would be an integer."""
    return mask ^ True
