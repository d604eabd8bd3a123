"""How light spreads along a fibre: Cauchy lobes, and Gaussian ones as the reference option.

Both are densities of unit mass in θ_h = (θi + θo)/2 on the whole line: the Cauchy with half width
γ, the Gaussian with standard deviation γ as Sadeghi et al. 2013 has it. For given θi both are
sampled exactly, cut off at θo = ±π/2 (Wang et al. 2014 for the Cauchy).
"""

from __future__ import annotations

import math
from typing import Any

import drjit as dr

Float = Any

HALF_PI = 0.5 * math.pi

_DEEPEST = 0.99999988
"""The largest error function that single precision tells from 1."""


def profile(gamma: Float, x: Float, gaussian: bool) -> Float:
    """Return the density of the lobe of width `gamma` at θ_h = `x`, both in radians."""
    if gaussian:
        scaled = x / gamma
        return dr.exp(-0.5 * dr.square(scaled)) / gamma * (1 / math.sqrt(2 * math.pi))
    return gamma / (dr.square(x) + dr.square(gamma)) * (1 / math.pi)


def mass(theta: Float, gamma: Float, gaussian: bool) -> Float:
    """Return ∫ profile((θ + θo)/2) dθo over −π/2…π/2, by which `draw` is normalized."""
    if gaussian:
        low, high = _error_bounds(theta, gamma)
        return high - low
    return (2 / math.pi) * _span(theta, gamma)


def draw(uniform: Float, theta: Float, gamma: Float, gaussian: bool) -> Float:
    """Return θo in −π/2…π/2 with the density profile((θ + θo)/2) / mass."""
    if gaussian:
        low, high = _error_bounds(theta, gamma)
        share = dr.clip(low + uniform * (high - low), -_DEEPEST, _DEEPEST)
        half_sum = math.sqrt(2) * gamma * dr.erfinv(share)
    else:
        # tan(B + ξ(A − B)) by the addition theorem, tan B being known: no arctangent but the span.
        sin, cos = dr.sincos(uniform * _span(theta, gamma))
        low = (theta - HALF_PI) / (2 * gamma)
        half_sum = gamma * (low * cos + sin) / (cos - low * sin)
    return dr.clip(2 * half_sum - theta, -HALF_PI, HALF_PI)


def _span(theta: Float, gamma: Float) -> Float:
    """Return A − B, A and B = atan((θ ± π/2)/(2γ)), by the subtraction theorem."""
    return dr.atan2(
        2 * math.pi * gamma, 4 * dr.square(gamma) + dr.square(theta) - HALF_PI * HALF_PI
    )


def _error_bounds(theta: Float, gamma: Float) -> tuple[Float, Float]:
    """Return the error functions at both ends of θ_h."""
    scale = 1 / (2 * math.sqrt(2) * gamma)
    return dr.erf((theta - HALF_PI) * scale), dr.erf((theta + HALF_PI) * scale)
