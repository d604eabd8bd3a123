"""An anisotropic GGX lobe over a diffuse base: what the standard shaders all come down to."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from weaveusd.shading.fibre import Doubles

_NODES = 16
"""Nodes of each dimension of a quadrature."""


class Squares(NamedTuple):
    """Squares of a direction's components across the fibre, along it and along the normal."""

    across: Doubles
    along: Doubles
    up: Doubles


def squares(direction: Doubles, normal: Doubles, tangent: Doubles) -> Squares:
    """Return the squares (N, P) of the components of `direction` (P, 3) in N fibres' frames.

    `normal` and `tangent`, the fibre's direction, are (N, 3), unit and orthogonal.
    """
    across = np.cross(normal, tangent)
    return Squares(*(components(axis, direction) ** 2 for axis in (across, tangent, normal)))


def components(axis: Doubles, direction: Doubles) -> Doubles:
    """Return the components (N, P) of `direction` (P, 3) along each `axis` (N, 3)."""
    # Not a matrix product: its last bits would be those of the machine's BLAS.
    return np.asarray(
        axis[:, :1] * direction[:, 0]
        + axis[:, 1:2] * direction[:, 1]
        + axis[:, 2:] * direction[:, 2]
    )


def mirror(
    wi: Squares, wo: Squares, half: Squares, alpha_along: float, alpha_across: float
) -> Doubles:
    """Return D V n·wo (N, P) in 1/sr: the GGX lobe without its Fresnel factor.

    ``D = 1 / (π α_t α_b (h_t²/α_t² + h_b²/α_b² + h_n²)²)`` and, with
    ``Λ(w) = sqrt(w_n² + α_t² w_t² + α_b² w_b²)``, ``V = 1 / (2 (o_n Λ(i) + i_n Λ(o)))``: the
    height-correlated masking of Smith (Heitz 2014).
    """
    narrow, wide = alpha_along**2, alpha_across**2
    spread = half.across / wide + half.along / narrow + half.up
    i_n, o_n = np.sqrt(wi.up), np.sqrt(wo.up)
    masks = 2 * (o_n * _masked(wi, narrow, wide) + i_n * _masked(wo, narrow, wide))
    scale = np.pi * alpha_along * alpha_across
    return np.asarray(o_n / (scale * spread**2 * np.maximum(masks, 1e-12)))


def fresnel_edge(cos_half: Doubles) -> Doubles:
    """Return (1 − c)⁵, with which ``F = F0 + (1 − F0) (1 − c)⁵`` (Schlick 1994)."""
    return np.asarray((1 - np.clip(cos_half, 0, 1)) ** 5)


@lru_cache(maxsize=256)
def mean_albedo(alpha: float) -> tuple[float, float]:
    """Return what the lobe reflects of light from all around: a and b in ``E = a F0 + b``.

    Means over the cosine of the viewer's angle, by quadrature; `alpha` is isotropic.
    """
    mid = (np.arange(_NODES) + 0.5) / _NODES
    cosine = mid[:, None, None]
    view = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], -1)
    # Half vectors as D has them, so that the sharpest lobe needs no more nodes than the widest.
    up = np.sqrt((1 - mid) / (1 + (alpha**2 - 1) * mid))[:, None]
    level, turn = np.sqrt(1 - up**2), 2 * np.pi * mid
    half = np.stack(np.broadcast_arrays(level * np.cos(turn), level * np.sin(turn), up), -1)
    meets = np.sum(view * half, -1)
    light = 2 * meets[..., None] * half - view
    o_n = np.maximum(light[..., 2], 0)
    bent = [np.sqrt(n**2 + alpha**2 * (1 - n**2)) for n in (cosine, o_n)]
    masks = 2 * (o_n * bent[0] + cosine * bent[1])
    share = np.where(meets > 0, 4 * meets * o_n / (masks * half[..., 2]), 0)
    edge = fresnel_edge(meets)
    weight = 2 * cosine / _NODES**3
    return float(np.sum(weight * share * (1 - edge))), float(np.sum(weight * share * edge))


def halfway(wi: Doubles, wo: Doubles) -> Doubles:
    """Return the unit vectors (P, 3) between `wi` and `wo` (P, 3)."""
    total = wi + wo
    return np.asarray(total / np.linalg.norm(total, axis=-1, keepdims=True))


def _masked(w: Squares, narrow: float, wide: float) -> Doubles:
    return np.asarray(np.sqrt(w.up + wide * w.across + narrow * w.along))
