"""Sampling of a yarn: three strategies on the viewer's side, two on the other, mixed by a guess.

`cosine` sampling about the yarn's normal, the `surface` lobe and the `volume` lobe, the lobes after
Wang et al. 2014: θo from the lobe's own profile, cut off at ±π/2, sin φ uniform. Per solid angle

    pdf = |n·ωo| (w_c/π + (w_s C(γ_s)/M_s + w_v C(γ_v)/M_v) / (2 cos² θo)),   M = ∫ C dθo

The shares w depend on the viewer and the yarn alone. They follow the albedos of the lobes, k_s F
and A N_V T, and give to cosine what is wide: a lobe is cut by cos² θo / m² away from its peak, so
that from about 24° on cosine sampling suits it better, the less so the more the fibre is inclined;
the isotropic part is nearly a cosine from the start. The constants are rounded from the least mean
logarithm of the variance under an even sky, ∫ value²/pdf dω − (∫ value dω)² by quadrature, over the
optics of the presets, albedos of 3 to 70 % and 21 viewing directions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from weaveusd.render.lobes import (
    SMALLEST_COSINE,
    TINY,
    Direction,
    Fibre,
    LobeParameters,
    entering,
    fresnel,
)
from weaveusd.render.longitudinal import draw, mass, profile

Float = Any
Color = Any
Vector = Any

# The surface lobe turns into cosine between these widths, the volume lobe likewise, where the
# fibre lies square to the viewer; both in radians.
_SURFACE_WIDTHS = (0.20, 0.31)
_VOLUME_WIDTHS = (0.17, 0.42)
_SURFACE_ALBEDO = 0.8
_VOLUME_ALBEDO = 0.5


@dataclass(frozen=True, slots=True)
class Shares:
    """Probabilities of the strategies, their sum 1; all 0 for a yarn that returns no light."""

    cosine: Float
    surface: Float
    volume: Float
    cosine_across: Float
    volume_across: Float


def shares(yarn: LobeParameters, fibre: Fibre) -> Shares:
    """Return how often each strategy is used, without gradients."""
    wi = fibre.wi
    square = dr.square(wi.cos_theta)
    middle = wi.cos_theta * dr.sqrt(0.5 + 0.5 * wi.cos_phi)  # halfway from the viewer to n
    surface = _SURFACE_ALBEDO * yarn.k_s * fresnel(middle, yarn.eta) * dr.sqrt(wi.cos_theta)
    volume = _VOLUME_ALBEDO * yarn.normalization * entering(fibre, yarn) * dr.mean(yarn.color)
    total = surface + volume
    scale = dr.select(total > TINY, 1 / dr.maximum(total, TINY), 0)
    surface, volume = surface * scale, volume * scale
    wide_surface = _wide(yarn.gamma_s, _SURFACE_WIDTHS, dr.square(dr.square(square)))
    wide_volume = dr.lerp(_wide(yarn.gamma_v, _VOLUME_WIDTHS, square), 1, yarn.k_d)
    cosine = volume * wide_volume
    mixed = (
        surface * wide_surface + (1 - yarn.tau) * cosine,
        surface * (1 - wide_surface),
        (1 - yarn.tau) * (volume - cosine),
        yarn.tau * cosine,
        yarn.tau * (volume - cosine),
    )
    return Shares(*(dr.detach(share) for share in mixed))


def _wide(gamma: Float, widths: tuple[float, float], square: Float) -> Float:
    """Return 0 for narrow lobes, 1 for wide ones seen across the fibre."""
    return dr.clip((gamma - widths[0]) / (widths[1] - widths[0]) * square, 0, 1)


def density(yarn: LobeParameters, fibre: Fibre, wo: Direction) -> Float:
    """Return the density of `sample` at `wo` per solid angle; 0 wherever the value is 0.

    The density is even for the black yarn that nothing comes from 0.
    """
    share = shares(yarn, fibre)
    theta_i, gaussian = fibre.wi.theta, yarn.gaussian
    half_sum = 0.5 * (theta_i + wo.theta)
    same = wo.cos_phi > 0
    surface = profile(yarn.gamma_s, half_sum, gaussian) / mass(theta_i, yarn.gamma_s, gaussian)
    volume = profile(yarn.gamma_v, half_sum, gaussian) / mass(theta_i, yarn.gamma_v, gaussian)
    lobes = dr.select(same, share.surface, 0) * surface
    lobes += dr.select(same, share.volume, share.volume_across) * volume
    flat = dr.select(same, share.cosine, share.cosine_across) * (1 / math.pi)
    return (flat + 0.5 * lobes / dr.square(wo.cos_theta)) * dr.abs(wo.n)


def sample(yarn: LobeParameters, fibre: Fibre, choice: Float, point: Any) -> Direction:
    """Return a direction distributed after `density`.

    `choice` and the two components of `point` are uniform in [0, 1).
    """
    share = shares(yarn, fibre)
    is_across = choice < share.cosine_across + share.volume_across
    rest = choice - dr.select(is_across, 0, share.cosine_across + share.volume_across)
    is_cosine = rest < dr.select(is_across, share.cosine_across, share.cosine)
    is_surface = (rest < share.cosine + share.surface) & (is_across ^ True)

    # A lobe gives θ; cosine sampling gives a point of the disk across n, whose x is sin θ.
    disk = mi.warp.square_to_uniform_disk_concentric(point)
    gamma = dr.select(is_surface, yarn.gamma_s, yarn.gamma_v)
    theta = draw(point[0], fibre.wi.theta, gamma, yarn.gaussian)
    theta = dr.select(is_cosine, dr.asin(disk.x), theta)
    sin_theta, cos_theta = dr.sincos(theta)
    cos_theta = dr.maximum(cos_theta, SMALLEST_COSINE)
    sin_phi = dr.select(is_cosine, dr.clip(disk.y / cos_theta, -1, 1), 2 * point[1] - 1)
    cos_phi = dr.safe_sqrt(1 - dr.square(sin_phi))
    return Direction(theta, sin_theta, cos_theta, sin_phi, dr.select(is_across, -cos_phi, cos_phi))
