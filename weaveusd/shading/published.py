"""The BSDF as it was published: Sadeghi et al. 2013 with the thesis's Cauchy lobes.

Kept for comparison and for the thesis's figures 6.1 and 6.2; nothing is rendered with it. Its
directional albedo reaches 1.5 to 6 at grazing angles, its color is no albedo, and it is not
reciprocal under the masking `array`; docs/bsdf.md says what `microcylinder` does instead.
With the letters of `microcylinder` and a profile g(γ; θ_h)::

    f_s = k_s F(cos θ_d cos(φ_d/2)) cos(φ_d/2) g(γ_s) / cos² θ_d
    f_v = T(cos θi) T(cos θo) [(1 − k_d) g(γ_v) + k_d] / ((cos θi + cos θo) cos² θ_d)
    M   = (1 − u) M_i M_o + u min(M_i, M_o),  M_x = max(0, cos φ_x),  u = exp(−φ_d² / 2 (20°)²)
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np

from weaveusd.shading.fibre import Fibre, in_fibre_frame
from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.longitudinal import cauchy, gaussian

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from weaveusd.shading.microcylinder import Parameters

    Doubles = NDArray[np.float64]

Profile = Literal["gaussian", "cauchy", "cauchy_cut"]
"""Gaussian of unit mass; Cauchy; Cauchy whose tails beyond θ_h = ±π/4 are cut off, of unit mass."""

Masking = Literal["none", "sadeghi", "array"]
"""None; Sadeghi's M; M / cos φi, as a thread among parallel threads receives light."""

CORRELATED = math.radians(20)
"""Standard deviation of φ_d within which both directions are masked together."""


def evaluate(
    wi: ArrayLike,
    wo: ArrayLike,
    n: ArrayLike,
    t: ArrayLike,
    params: Parameters,
    *,
    profile: Profile = "gaussian",
    masking: Masking = "none",
) -> Doubles:
    """Return the published f |n·wo| (…, channels of A) in 1/sr.

    On the side of `wi` it is W cos θo (f_s + (1 − τ) A f_v) with W = 1, M or M / cos φi after
    `masking`; on the other τ A f_v |n·wo|. `params.gaussian` is not read: `profile` says it.
    """
    fibre = in_fibre_frame(wi, wo, n, t)
    f_s, f_v = _lobes(fibre, params, profile)
    weight = _masked(fibre, masking) * fibre.cos_o
    same = fibre.n_dot_o > 0
    surface = np.where(same, weight * f_s, 0)
    volume = np.where(
        same, (1 - params.tau) * weight * f_v, params.tau * np.abs(fibre.n_dot_o) * f_v
    )
    value: Doubles = surface[..., None] + np.asarray(params.A, float) * volume[..., None]
    return value


def lobes(
    wi: ArrayLike,
    wo: ArrayLike,
    n: ArrayLike,
    t: ArrayLike,
    params: Parameters,
    *,
    profile: Profile = "gaussian",
) -> tuple[Doubles, Doubles]:
    """Return the published f_s and f_v (…) on either side, without A, masking and cosine."""
    return _lobes(in_fibre_frame(wi, wo, n, t), params, profile)


def _lobes(fibre: Fibre, params: Parameters, profile: Profile) -> tuple[Doubles, Doubles]:
    cos_d2 = np.maximum(np.cos(fibre.theta_d) ** 2, 1e-24)
    half = np.cos(0.5 * fibre.phi_d)
    fresnel = reflectance(np.cos(fibre.theta_d) * half, params.eta)
    f_s = params.k_s * fresnel * half * _profile(profile, params.gamma_s, fibre.theta_h) / cos_d2
    through = (1 - reflectance(fibre.cos_i, params.eta)) * (
        1 - reflectance(fibre.cos_o, params.eta)
    )
    scatter = (1 - params.k_d) * _profile(profile, params.gamma_v, fibre.theta_h) + params.k_d
    cosines = np.maximum(fibre.cos_i + fibre.cos_o, 1e-12)
    return f_s, np.asarray(through * scatter / (cosines * cos_d2))


def _profile(profile: Profile, gamma: float, theta_h: Doubles) -> Doubles:
    if profile == "gaussian":
        return gaussian(gamma, theta_h)
    if profile == "cauchy":
        return cauchy(gamma, theta_h)
    return cauchy(gamma, theta_h) * (np.pi / (2 * math.atan(np.pi / (4 * gamma))))


def _masked(fibre: Fibre, masking: Masking) -> Doubles:
    if masking == "none":
        return np.ones_like(fibre.n_dot_o)
    lit, seen = (np.maximum(np.cos(phi), 0) for phi in (fibre.phi_i, fibre.phi_o))
    together = np.exp(-0.5 * (fibre.phi_d / CORRELATED) ** 2)
    mask = (1 - together) * lit * seen + together * np.minimum(lit, seen)
    return np.asarray(mask / np.maximum(lit, 1e-12) if masking == "array" else mask)
