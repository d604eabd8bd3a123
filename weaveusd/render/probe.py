"""A cloth BSDF probed outside any scene: its values, and Mitsuba's chi² test of its sampler.

Import this module after `weaveusd.render.variant.prepare`, as `weaveusd.render.bsdf`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import drjit as dr
import mitsuba as mi
import numpy as np
from mitsuba.chi2 import ChiSquareTest

from weaveusd.render.bsdf import cloth_bsdf_dict

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

RESOLUTION = 100
"""Cells of the chi² test along θ; there are twice as many around. Borders lie where sides meet."""

SUBDIVISION = 16
"""Evaluations of the density along the side of a cell."""


@dataclass(frozen=True, slots=True)
class Sampled:
    """What the chi² test found: p-value, ∫ pdf over its cells, and why it could not be run."""

    p_value: float
    density: float
    fault: str = ""


def one_texel(
    yarn_inputs: Mapping[str, Sequence[float]],
    *,
    normal: ArrayLike = (0, 0, 1),
    tangent: ArrayLike = (0, 1, 0),
    color: float = 1.0,
    gaussian: bool = False,
) -> Any:
    """Return the BSDF of a cloth that is yarn 0 everywhere, in one frame and of one gray."""
    n = np.asarray(normal, np.float32).reshape(1, 1, 3)
    t = np.asarray(tangent, np.float32).reshape(1, 1, 3)
    arrays = {
        "normal": n,
        "tangent": t,
        "base_color": np.full((1, 1, 3), color, np.float32),
        "opacity": np.ones((1, 1, 1), np.float32),
        "yarn_id": np.zeros((1, 1, 1), np.float32),
    }
    made = cloth_bsdf_dict(arrays, yarn_inputs, (1.0, 1.0), gaussian=gaussian)
    return mi.load_dict(made, parallel=False)


def interaction(wi: Any, count: int = 1, uv: Any = (0.5, 0.5)) -> Any:
    """Return `count` interactions seen from `wi`, on a surface along X and Y under Z."""
    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.wi = mi.Vector3f(*wi)
    si.uv = mi.Point2f(*uv)
    si.sh_frame = mi.Frame3f(mi.Vector3f(0, 0, 1))
    si.sh_frame.s, si.sh_frame.t = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    return si


def values(bsdf: Any, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float64]:
    """Return value times cosine (N, 3) for pairs of unit vectors (N, 3) or (3,)."""
    towards, away = np.broadcast_arrays(np.asarray(wi, np.float32), np.asarray(wo, np.float32))
    si = interaction(towards.T, len(away))
    found = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(np.ascontiguousarray(away.T)))
    return np.array(found, np.float64).T


def densities(bsdf: Any, wi: ArrayLike, wo: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the density (…) of sampling the unit vectors `wo` (…, 3), seen from `wi` (3,)."""
    away = np.ascontiguousarray(wo.reshape(-1, 3).T, np.float32)
    si = interaction(np.asarray(wi, float).tolist(), away.shape[1])
    found = np.array(bsdf.pdf(mi.BSDFContext(), si, mi.Vector3f(away)), np.float64)
    return found.reshape(wo.shape[:-1])


def chi_square(
    bsdf: Any,
    wi: Sequence[float],
    *,
    normal: ArrayLike = (0, 0, 1),
    tangent: ArrayLike = (0, 1, 0),
    samples: int = 200_000,
) -> Sampled:
    """Test whether `bsdf` samples as its density says, seen from `wi`; the seed is fixed.

    The cells lie along θ and φ of the yarn, whose frame is given, since there the density is
    smooth: per solid angle it has a pole at either end of the fibre. A low p-value means that the
    samples are unlikely to follow the density. A sample without weight counts as none, as in a
    render.
    """
    context = mi.BSDFContext()
    domain = FibreDomain(normal, tangent)

    def sample(point: Any) -> tuple[Any, Any]:
        si = interaction(wi, dr.width(point))
        drawn, weight = bsdf.sample(context, si, point[0], mi.Vector2f(point[1], point[2]))
        return drawn.wo, dr.select(dr.all(weight == 0), mi.Float(0), mi.Float(1))

    def pdf(wo: Any) -> Any:
        density = bsdf.pdf(context, interaction(wi, dr.width(wo)), wo)
        return density * domain.solid_angle(wo)

    test = ChiSquareTest(
        domain=domain,
        sample_func=sample,
        pdf_func=pdf,
        sample_dim=3,
        sample_count=samples,
        res=RESOLUTION,
        ires=SUBDIVISION,
    )
    test.run(quiet=True)
    density = float(np.array(test.pdf_sum)[0])
    return Sampled(float(test.p_value), density, test.messages if test.fail else "")


class FibreDomain:
    """Directions by azimuth φ and inclination θ around a fibre, as Mitsuba's chi² test asks."""

    def __init__(self, normal: ArrayLike, tangent: ArrayLike) -> None:
        n, t = np.asarray(normal, float), np.asarray(tangent, float)
        self.frame = mi.Frame3f(*(mi.Vector3f(*v.tolist()) for v in (n, np.cross(t, n), t)))

    def bounds(self) -> Any:
        """Return the rectangle of φ and θ."""
        half = np.pi / 2
        return mi.ScalarBoundingBox2f([-2 * half, -half], [2 * half, half])

    def aspect(self) -> float:
        """Return the height of the rectangle over its width."""
        return 0.5

    def map_forward(self, p: Any) -> Any:
        """Return the direction at (φ, θ)."""
        (sin_phi, cos_phi), (sin_theta, cos_theta) = dr.sincos(p.x), dr.sincos(p.y)
        local = mi.Vector3f(cos_theta * cos_phi, cos_theta * sin_phi, sin_theta)
        return self.frame.to_world(local)

    def map_backward(self, direction: Any) -> Any:
        """Return (φ, θ) of a direction."""
        local = self.frame.to_local(direction)
        return mi.Vector2f(dr.atan2(local.y, local.x), dr.asin(dr.clip(local.z, -1, 1)))

    def solid_angle(self, direction: Any) -> Any:
        """Return dω / dφ dθ = cos θ."""
        local = self.frame.to_local(direction)
        return dr.hypot(local.x, local.y)


def least_p_value(trials: int, significance: float = 0.01) -> float:
    """Return the p-value that the least of `trials` stays above but for `significance` (Šidák)."""
    return float(-np.expm1(np.log1p(-significance) / trials))
