"""How directions are drawn for the cloth BSDF, in NumPy: the rule that the renderer follows.

On the viewer's side a direction comes from one of three strategies, on the other from two:
`cosine` sampling about the yarn's normal, and the `surface` and `volume` lobes after Wang et al.
2014, θo from the lobe's own profile C, cut off at ±π/2, and sin φ uniform. Per solid angle

    pdf = |n·ωo| (w_c/π + (w_s C(γ_s)/M_s + w_v C(γ_v)/M_v) / (2 cos² θo)),   M = ∫ C dθo

Directions and frames are those of `microcylinder`. docs/bsdf-cost.md says how the shares w were
found and what they save; `render.sampling` holds the same constants, and a test both to each other.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.shading.fibre import facing, in_fibre_frame
from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.longitudinal import inclination_density, sample_inclination
from weaveusd.shading.microcylinder import evaluate, normalization_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from weaveusd.shading.fibre import Fibre
    from weaveusd.shading.microcylinder import Parameters

    Doubles = NDArray[np.float64]

SURFACE_WIDTHS = (0.20, 0.31)
VOLUME_WIDTHS = (0.17, 0.42)
"""Widths in radians between which a lobe turns into cosine, seen square to the fibre."""

SURFACE_ALBEDO = 0.8
VOLUME_ALBEDO = 0.5


class Shares(NamedTuple):
    """Probabilities (…) of the strategies, their sum 1; all 0 where no light comes back."""

    cosine: Doubles
    surface: Doubles
    volume: Doubles
    cosine_across: Doubles
    volume_across: Doubles


class Sample(NamedTuple):
    """Sampled directions: `wo` (…, 3), `weight` = eval / pdf (…, channels of A), `pdf` (…)."""

    wo: Doubles
    weight: Doubles
    pdf: Doubles


def shares(fibre: Fibre, params: Parameters, n_v: float) -> Shares:
    """Return how often each strategy is used, which the viewer and the yarn alone decide.

    They follow the albedos of the lobes, k_s F and A N_V T, and give to cosine what is wide.
    """
    square = fibre.cos_i**2
    middle = fibre.cos_i * np.sqrt(0.5 + 0.5 * np.cos(fibre.phi_i))  # halfway from wi to n
    surface = SURFACE_ALBEDO * params.k_s * reflectance(middle, params.eta) * np.sqrt(fibre.cos_i)
    entering = 1 - reflectance(fibre.cos_i, params.eta)
    volume = VOLUME_ALBEDO * n_v * entering * np.mean(np.asarray(params.A, float), -1)
    total = surface + volume
    scale = np.divide(1, total, where=total > 0, out=np.zeros_like(total))
    surface, volume = surface * scale, volume * scale
    wide_surface = _wide(params.gamma_s, SURFACE_WIDTHS, square**4)
    wide_volume = _wide(params.gamma_v, VOLUME_WIDTHS, square)
    cosine = volume * (wide_volume + (1 - wide_volume) * params.k_d)
    return Shares(
        surface * wide_surface + (1 - params.tau) * cosine,
        surface * (1 - wide_surface),
        (1 - params.tau) * (volume - cosine),
        params.tau * cosine,
        params.tau * (volume - cosine),
    )


def pdf(
    wi: ArrayLike,
    wo: ArrayLike,
    n: ArrayLike,
    t: ArrayLike,
    params: Parameters,
    *,
    n_v: float | None = None,
) -> Doubles:
    """Return the density of `sample` at `wo`, (…) in 1/sr; 0 wherever the value is 0."""
    fibre = in_fibre_frame(wi, wo, n, t)
    share = shares(fibre, params, normalization_of(params, n_v))
    same = fibre.n_dot_o > 0
    surface, volume = (
        inclination_density(fibre.theta_i, fibre.theta_o, gamma, is_gaussian=params.gaussian)
        for gamma in (params.gamma_s, params.gamma_v)
    )
    lobes = np.where(same, share.surface * surface, 0)
    lobes = lobes + np.where(same, share.volume, share.volume_across) * volume
    flat = np.where(same, share.cosine, share.cosine_across) / np.pi
    cos_o = np.maximum(fibre.cos_o, 1e-12)
    density: Doubles = np.abs(fibre.n_dot_o) * (flat + 0.5 * lobes / cos_o**2)
    return density


def sample(
    wi: ArrayLike,
    n: ArrayLike,
    t: ArrayLike,
    params: Parameters,
    u: ArrayLike,
    *,
    n_v: float | None = None,
) -> Sample:
    """Draw a direction from every strategy, with exact density.

    `u` (…, 3) are uniform in 0…1: the first chooses the strategy, the others give the direction.
    """
    choice, u_theta, u_phi = np.moveaxis(np.asarray(u, float), -1, 0)
    wi, n, t = (np.asarray(v, float) for v in (wi, n, t))
    n = facing(n, wi)
    fibre = in_fibre_frame(wi, wi, n, t)
    share = shares(fibre, params, normalization_of(params, n_v))

    across = choice < share.cosine_across + share.volume_across
    rest = choice - np.where(across, 0, share.cosine_across + share.volume_across)
    cosine = rest < np.where(across, share.cosine_across, share.cosine)
    surface = ~across & (rest < share.cosine + share.surface)

    # A lobe gives θ; cosine sampling gives a point of the disk across n, whose x is sin θ.
    x, y = _disk(u_theta, u_phi)
    gamma = np.where(surface, params.gamma_s, params.gamma_v)
    theta = sample_inclination(u_theta, fibre.theta_i, gamma, is_gaussian=params.gaussian)
    cos_o = np.where(cosine, np.sqrt(1 - x**2), np.cos(theta))
    sin_phi = 2 * u_phi - 1
    along = np.where(cosine, x, np.sin(theta))
    beside = np.where(cosine, y, cos_o * sin_phi)
    above = np.where(
        cosine, np.sqrt(np.maximum(1 - x**2 - y**2, 0)), cos_o * np.sqrt(1 - sin_phi**2)
    )
    local = np.stack([beside, along, np.where(across, -above, above)], -1)

    frame = np.stack(np.broadcast_arrays(np.cross(n, t), t, n), -1)
    wo: Doubles = np.einsum("...ij,...j->...i", frame, local)
    density = pdf(wi, wo, n, t, params, n_v=n_v)
    value = evaluate(wi, wo, n, t, params, n_v=n_v)
    weight = np.divide(value, density[..., None], where=density[..., None] > 0, out=0 * value)
    return Sample(wo, weight, density)


def _wide(gamma: float, widths: tuple[float, float], square: Doubles) -> Doubles:
    """Return 0 (…) for narrow lobes, 1 for wide ones seen across the fibre."""
    return np.clip((gamma - widths[0]) / (widths[1] - widths[0]) * square, 0, 1)


def _disk(u: Doubles, v: Doubles) -> tuple[Doubles, Doubles]:
    """Return points of the unit disk for those of the unit square (Shirley and Chiu 1997)."""
    x, y = 2 * u - 1, 2 * v - 1
    steep = np.abs(x) < np.abs(y)
    radius, other = np.where(steep, y, x), np.where(steep, x, y)
    ratio = np.divide(other, radius, where=radius != 0, out=np.zeros_like(radius))
    angle = np.where(steep, 0.5 * np.pi - 0.25 * np.pi * ratio, 0.25 * np.pi * ratio)
    return radius * np.cos(angle), radius * np.sin(angle)
