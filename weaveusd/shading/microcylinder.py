"""The cloth BSDF in NumPy: a fibre as a microcylinder, to be read and to be trusted.

The model is that of Sadeghi et al. 2013 with Cauchy lobes (or Gaussian ones, for reference),
normalized so that no fibre reflects more than it receives and that `A` is an albedo. `sampling`
draws directions for it; the form that they published is in `published`.

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

from weaveusd.shading.fibre import Fibre, in_fibre_frame
from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.longitudinal import profile
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
    n_v = normalization_of(params, n_v)
    albedo = np.asarray(params.A, float)
    value: Doubles = (f_r[..., None] + albedo * n_v * f_v[..., None]) * np.abs(
        fibre.n_dot_o[..., None]
    )
    return value


def normalization_of(params: Parameters, stated: float | None = None) -> float:
    """Return the N_V that an asset states, or else that which follows from `params`."""
    if stated is not None:
        return stated
    return normalization(
        params.eta, params.k_d, params.k_s, params.gamma_s, params.gamma_v, params.gaussian
    )


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


def _lobes(fibre: Fibre, params: Parameters) -> tuple[Doubles, Doubles]:
    narrow, wide = (
        profile(gamma, fibre.theta_h, is_gaussian=params.gaussian)
        for gamma in (params.gamma_s, params.gamma_v)
    )
    return scattered(fibre, params, narrow, wide)
