"""The cloth BSDF in NumPy: a fibre as a microcylinder, to be read and to be trusted.

The model is that of Sadeghi et al. 2013 with Cauchy lobes (or Gaussian ones, for reference),
normalized so that no fibre reflects more than it receives and that `A` is an albedo; sampling
follows Wang et al. 2014, corrected. The form that they published is in `published`.

Directions are unit vectors that point away from the surface, `wi` to the viewer and `wo` to the
light; `n` is the yarn's normal, `t` the fibre's direction, b = n × t. For a direction ω::

    sin θ = ω·t                    inclination to the plane across the fibre
    φ = atan2(ω·b, ω·n)            azimuth around the fibre
    θ_h = (θi + θo)/2   θ_d = (θi − θo)/2   φ_d = φi − φo, wrapped to −π…π

A yarn has two faces: n is turned to the side of `wi`. What comes back is `f |n·wo|`, in 1/sr.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.shading.fibre import Fibre, dot, facing, in_fibre_frame
from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.longitudinal import inclination_density, profile, sample_inclination
from weaveusd.shading.normalization import SURFACE_SCALE, normalization

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Doubles = NDArray[np.float64]


class Parameters(NamedTuple):
    """Optics of a fibre. Angles in radians.

    `eta` index of refraction; `k_d` isotropic share of the volume lobe; `k_s` scale of the
    surface lobe; `gamma_s` and `gamma_v` half widths of the two lobes, or their standard
    deviations where they are `gaussian`; `tau` share of the volume lobe that leaves on the other
    side; `A` albedo, any shape, channels last.
    """

    eta: float
    k_d: float
    k_s: float
    gamma_s: float
    gamma_v: float
    tau: float
    A: ArrayLike
    gaussian: bool = False


class Sample(NamedTuple):
    """Sampled directions: `wo` (…, 3), `weight` = eval / pdf (…, channels of A), `pdf` (…)."""

    wo: Doubles
    weight: Doubles
    pdf: Doubles


def evaluate(
    wi: ArrayLike,
    wo: ArrayLike,
    n: ArrayLike,
    t: ArrayLike,
    params: Parameters,
    *,
    n_v: float | None = None,
) -> Doubles:
    """Return ``(f_R + A N_V f_V) |n·wo|`` (…, channels of A) in 1/sr (docs/bsdf.md).

    `n_v` is the N_V that an asset states; by default it follows from `params`.
    """
    fibre = in_fibre_frame(wi, wo, n, t)
    f_r, f_v = _lobes(fibre, params)
    if n_v is None:
        n_v = normalization(
            params.eta, params.k_d, params.k_s, params.gamma_s, params.gamma_v, params.gaussian
        )
    albedo = np.asarray(params.A, float)
    value: Doubles = (f_r[..., None] + albedo * n_v * f_v[..., None]) * np.abs(
        fibre.n_dot_o[..., None]
    )
    return value


def lobes(
    wi: ArrayLike, wo: ArrayLike, n: ArrayLike, t: ArrayLike, params: Parameters
) -> tuple[Doubles, Doubles]:
    """Return f_R and f_V (…), the surface and the volume lobe without A, N_V and cosine."""
    return _lobes(in_fibre_frame(wi, wo, n, t), params)


def scattered(
    fibre: Fibre, params: Parameters, narrow: Doubles, wide: Doubles
) -> tuple[Doubles, Doubles]:
    """Return f_R and f_V (…) as `lobes`, of given profiles (…) of the surface and volume lobe."""
    m2 = np.maximum(np.maximum(fibre.cos_i, fibre.cos_o) ** 2, 1e-24)
    same = fibre.n_dot_o > 0
    half = np.cos(0.5 * fibre.phi_d)
    fresnel = reflectance(np.cos(fibre.theta_d) * half, params.eta)
    f_r = params.k_s * SURFACE_SCALE * fresnel * half * (0.5 * narrow / m2)
    enter = 1 - reflectance(fibre.cos_i, params.eta)
    leave = 1 - reflectance(fibre.cos_o, params.eta)
    cosines = np.maximum(fibre.cos_i + fibre.cos_o, 1e-12)
    scatter = (1 - params.k_d) * (0.5 * wide / m2) + params.k_d * 0.5 / cosines
    side = np.where(same, 1 - params.tau, params.tau)
    return np.where(same, f_r, 0), side * 0.5 * enter * leave * scatter


def pdf(wi: ArrayLike, wo: ArrayLike, n: ArrayLike, t: ArrayLike, params: Parameters) -> Doubles:
    """Return the density of `sample` at `wo`, (…) in 1/sr (Wang et al. 2014, corrected)."""
    fibre = in_fibre_frame(wi, wo, n, t)
    p_r = surface_probability(fibre.theta_i, fibre.cos_i, params)
    w_c = cosine_share(params.gamma_v)
    same = fibre.n_dot_o > 0
    surface = _density(fibre, params.gamma_s, params)
    volume = (1 - params.k_d) * _density(fibre, params.gamma_v, params)
    volume = volume + params.k_d * 0.5 * fibre.cos_o
    side = np.where(same, 1 - params.tau, params.tau)
    lobe = np.where(same, p_r * surface, 0) + side * (1 - p_r) * volume
    n_o = np.abs(fibre.n_dot_o)
    cos_o = np.maximum(fibre.cos_o, 1e-12)
    density: Doubles = (1 - w_c) * lobe * n_o / (2 * cos_o**2) + w_c * side * n_o / np.pi
    return density


def sample(wi: ArrayLike, n: ArrayLike, t: ArrayLike, params: Parameters, u: ArrayLike) -> Sample:
    """Draw a direction from every lobe, with exact density.

    `u` (…, 2) or (…, 3) are uniform in 0…1. The first number chooses the lobe and, where there
    are only two, is rescaled after each choice and used again for the inclination.
    """
    u = np.asarray(u, float)
    choice, u_phi = u[..., 0], u[..., -1]
    wi, n, t = (np.asarray(v, float) for v in (wi, n, t))
    n = facing(n, wi)
    theta_i = np.arcsin(np.clip(dot(wi, t), -1, 1))
    p_r = surface_probability(theta_i, np.cos(theta_i), params)
    w_c = cosine_share(params.gamma_v)

    # Choose: cosine, surface, volume (isotropic or its lobe); each choice gives back its number.
    cosine, choice = _branch(choice, np.broadcast_to(w_c, choice.shape))
    surface, choice = _branch(choice, p_r)
    isotropic, choice = _branch(choice, np.broadcast_to(params.k_d, choice.shape))
    u_theta = u[..., 1] if u.shape[-1] == 3 else choice

    # Every lobe but the surface lobe leaves on the other side with probability tau.
    far, u_phi = _branch(u_phi, np.where(surface & ~cosine, 0.0, params.tau))

    gamma = np.where(surface, params.gamma_s, params.gamma_v)
    theta_o = sample_inclination(u_theta, theta_i, gamma, is_gaussian=params.gaussian)
    sin_o = np.where(isotropic & ~surface, 2 * u_theta - 1, np.sin(theta_o))
    sin_o = np.clip(sin_o, -1, 1)
    cos_o = np.sqrt(1 - sin_o**2)
    sin_phi = 2 * u_phi - 1
    local = np.stack([cos_o * sin_phi, sin_o, cos_o * np.sqrt(1 - sin_phi**2)], -1)
    local = np.where(cosine[..., None], _cosine_direction(u_theta, u_phi), local)
    local[..., 2] = np.where(far, -local[..., 2], local[..., 2])

    frame = np.stack(np.broadcast_arrays(np.cross(n, t), t, n), -1)
    wo: Doubles = np.einsum("...ij,...j->...i", frame, local)
    density = pdf(wi, wo, n, t, params)
    value = evaluate(wi, wo, n, t, params)
    weight = np.divide(value, density[..., None], where=density[..., None] > 0, out=0 * value)
    return Sample(wo, weight, density)


def surface_probability(theta_i: Doubles, cos_i: Doubles, params: Parameters) -> Doubles:
    """Return the probability (…) of sampling the surface lobe, 0.1…0.9.

    The surface lobe weighs its Fresnel reflectance at the middle of its azimuths, the volume
    lobe its albedo times the light that enters and leaves; the better the guess, the less the
    noise, whatever the guess the mean is right.
    """
    half = np.cos(np.pi / 8)
    surface = params.k_s * reflectance(np.cos(theta_i) * half, params.eta)
    volume = np.mean(np.asarray(params.A, float), -1) * (1 - reflectance(cos_i, params.eta)) ** 2
    return np.asarray(np.clip(surface / np.maximum(surface + volume, 1e-9), 0.1, 0.9))


def cosine_share(gamma_v: float) -> float:
    """Return the share of plain cosine sampling: none below 12°, a third from 24° on.

    Sampling a wide Cauchy lobe alone is slightly noisier than cosine sampling.
    """
    return float(np.clip((np.degrees(gamma_v) - 12) / 12, 0, 1) / 3)


def _lobes(fibre: Fibre, params: Parameters) -> tuple[Doubles, Doubles]:
    narrow, wide = (
        profile(gamma, fibre.theta_h, is_gaussian=params.gaussian)
        for gamma in (params.gamma_s, params.gamma_v)
    )
    return scattered(fibre, params, narrow, wide)


def _density(fibre: Fibre, gamma: float, params: Parameters) -> Doubles:
    return inclination_density(fibre.theta_i, fibre.theta_o, gamma, is_gaussian=params.gaussian)


def _branch(u: Doubles, probability: ArrayLike) -> tuple[NDArray[np.bool_], Doubles]:
    """Return whether u < probability, and u stretched over the branch taken."""
    p = np.asarray(probability, float)
    taken = u < p
    low = np.divide(u, p, where=p > 0, out=np.zeros_like(u))
    high = np.divide(u - p, 1 - p, where=p < 1, out=np.zeros_like(u))
    return taken, np.where(taken, low, high)


def _cosine_direction(u1: Doubles, u2: Doubles) -> Doubles:
    r, phi = np.sqrt(u1), 2 * np.pi * u2
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(np.maximum(1 - u1, 0))], -1)
