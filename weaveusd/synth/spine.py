"""Yarns as bent tubes: where a point of the cloth lies on the surface of its yarn.

A yarn's spine turns from inclination 0 in the middle of a float to ±u_max at its ends; its
section is an ellipse of half width a and half thickness b::

    p(u, v) = c(u) + a sin v · X + b cos v · N(u)    N = (0, sin u, cos u)   T = (0, cos u, −sin u)

Seen from above, a point (x, y) of a float has v = asin(x/a), and u solves
``y = y_spine(u) + b cos v sin u`` (physics.md C: the projection of the bent tube, which, unlike
Irawan's mapping, is the surface of something). Everything is written in sin u and square roots:
IEEE arithmetic alone, so that every machine computes the same bits.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.synth.compiled import inlined, step

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

_S = tuple((-1) ** k / math.factorial(2 * k + 1) for k in range(1, 7))
_C = tuple((-1) ** k / math.factorial(2 * k) for k in range(1, 8))
"""Coefficients of the series of sine and cosine behind their first terms."""

_ROUNDING = 1.5 * 2.0**52


def sine_cosine(angle: Any) -> tuple[Any, Any]:
    """Return sine and cosine of angles (…) within ±π, by their series around angle/4.

    The libraries' own differ in the last bit from machine to machine; these do not. The
    absolute error is below 1e-12.
    """
    q = 0.25 * angle
    q2 = q * q
    s = q * (1.0 + q2 * (_S[0] + q2 * (_S[1] + q2 * (_S[2] + q2 * (_S[3] + q2 * (
        _S[4] + q2 * _S[5]))))))  # fmt: skip
    c = 1.0 + q2 * (_C[0] + q2 * (_C[1] + q2 * (_C[2] + q2 * (_C[3] + q2 * (
        _C[4] + q2 * (_C[5] + q2 * _C[6]))))))  # fmt: skip
    s, c = 2.0 * s * c, c * c - s * s
    return 2.0 * s * c, c * c - s * s


sin_cos = inlined(sine_cosine)
"""`sine_cosine` of one angle, in compiled loops."""

SIN_LIMIT: float = sine_cosine(0.02)[1]
"""No inclination exceeds 90° − 0.02 rad."""


@inlined
def circle_bend(y: float, radius: float, b_cos_v: float) -> tuple[float, float, float]:
    """Return sin u, cos u and the spine's height at distance `y` into a circular bend.

    Before the bend, where `y` is negative, the yarn is straight.

    sin u = y / (R₀ + b cos v), z_spine = R₀ (cos u − 1); `radius` is R₀, lengths in mm.
    """
    sin_u = min(max(y, 0.0) / (radius + b_cos_v), SIN_LIMIT)
    cos_u = math.sqrt(1.0 - sin_u * sin_u)
    return sin_u, cos_u, radius * (cos_u - 1.0)


@step
def conic_spine(sin_u: float, r_hat: float, scale: float) -> tuple[float, float, float]:
    """Return y, z and dy/d(sin u) of Irawan's conic spine at an inclination.

    `scale` is B for an ellipse (r̂ > 0) and a hyperbola (r̂ < 0), A for the parabola (r̂ = 0);
    physics.md C, with q = tan u, sin(atan x) = x/√(1 + x²) and sinh(atanh x) = x/√(1 − x²).
    """
    cos_u = math.sqrt(1.0 - sin_u * sin_u)
    q = sin_u / cos_u
    dq = 1.0 / (cos_u * cos_u * cos_u)
    if r_hat == 0.0:
        return 2.0 * scale * q, -scale * q * q, 2.0 * scale * dq
    sign = 1.0 if r_hat > 0.0 else -1.0
    root = math.sqrt(1.0 + sign * r_hat * r_hat * q * q)
    y = scale * sign * r_hat * q / root
    z = scale / r_hat * (1.0 / root - 1.0)
    return y, z, scale * sign * r_hat / (root * root * root) * dq


@step
def conic_bend(y: float, r_hat: float, scale: float, b_cos_v: float) -> tuple[float, float, float]:
    """Return sin u, cos u and the spine's height at distance `y` ≥ 0 from a conic's middle.

    Newton's method, kept inside a bracket, on ``y_spine(u) + b cos v sin u = y``.
    """
    low, high = 0.0, SIN_LIMIT
    if r_hat < 0.0:
        high = min(high, (1.0 - 1e-9) / math.sqrt(1.0 + r_hat * r_hat))
    sin_u = min(0.5 * high, high)
    for _ in range(60):
        y_spine, _z, slope = conic_spine(sin_u, r_hat, scale)
        error = y_spine + b_cos_v * sin_u - y
        if error > 0.0:
            high = sin_u
        else:
            low = sin_u
        step = sin_u - error / (slope + b_cos_v)
        if not low <= step <= high:
            step = 0.5 * (low + high)
        if abs(step - sin_u) <= 1e-15:
            sin_u = step
            break
        sin_u = step
    _y, z, _slope = conic_spine(sin_u, r_hat, scale)
    return sin_u, math.sqrt(1.0 - sin_u * sin_u), z


@inlined
def frame(
    sin_u: float, cos_u: float, sin_v: float, cos_v: float, b_over_a: float,
    sin_psi: float, cos_psi: float,
) -> tuple[float, float, float, float, float, float]:  # fmt: skip
    """Return normal and fibre tangent in the yarn's frame (x across, y along, z out).

    n ∝ ((b/a) sin v, sin u cos v, cos u cos v) and t = cos ψ T − sin ψ T_v, with
    T_v ∝ (cos v, −(b/a) sin u sin v, −(b/a) cos u sin v); physics.md C.
    """
    slant = b_over_a * sin_v
    scale = 1.0 / math.sqrt(slant * slant + cos_v * cos_v)
    side, up = slant * scale, cos_v * scale
    t_x = -sin_psi * up
    t_y = cos_psi * cos_u + sin_psi * side * sin_u
    t_z = -cos_psi * sin_u + sin_psi * side * cos_u
    return side, up * sin_u, up * cos_u, t_x, t_y, t_z


@inlined
def nearest(x: float) -> float:
    """Return the whole number nearest to `x`, ties to even, for |x| below 2^51.

    Doubles of 2^52 and more have no fraction, so that adding 1.5 · 2^52 rounds; this is one
    vector instruction twice, where the conversion to integers is none.
    """
    return (x + _ROUNDING) - _ROUNDING


@inlined
def floor(x: float) -> float:
    """Return the greatest whole number not above `x`, for |x| below 2^51, as `nearest` does."""
    whole: float = nearest(x)
    return whole - 1.0 if whole > x else whole


def circle_radius(bend_mm: ArrayLike, u_max: ArrayLike, b_mm: ArrayLike) -> NDArray[np.float64]:
    """Return R₀ (…) of bends that end, at their crown, after `bend_mm`: e / sin u_max − b."""
    sin_u, _ = sine_cosine(np.asarray(u_max, float))
    radius: NDArray[np.float64] = np.asarray(bend_mm, float) / sin_u - np.asarray(b_mm)
    return radius


def conic_parameters(
    length_mm: float, u_max: float, b_mm: float, kappa: float
) -> tuple[float, float]:
    """Return r̂ and the scale (B, or A of the parabola) of Irawan's conic spine.

    r̂ = 1 + κ (1 + cot u_max); the crown ends at half the length, so the spine ends at
    h = l/2 − b sin u_max.
    """
    sin_u, cos_u = sine_cosine(u_max)
    tan_u = sin_u / cos_u
    r_hat = 1 + kappa * (1 + 1 / tan_u)
    h = 0.5 * length_mm - b_mm * sin_u
    x = r_hat * tan_u
    if r_hat == 0:
        return 0.0, h / (2 * tan_u)
    if r_hat > 0:
        return r_hat, h / (x / math.sqrt(1 + x * x))
    return r_hat, h / (-x / math.sqrt(1 - x * x))
