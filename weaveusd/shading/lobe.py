"""An anisotropic GGX lobe over a diffuse base: what the standard shaders all come down to."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.shading.fibre import dot

if TYPE_CHECKING:
    from weaveusd.shading.fibre import Doubles

COSINES = (np.arange(16) + 0.5) / 16
"""Cosines of the viewer's angle at which albedos are tabulated: the middles of equal steps."""

BENT = 1e-3
"""Least cosine between a normal and the viewer: a normal that is turned away is bent to it."""


class Squares(NamedTuple):
    """Squares of a direction's components across the fibre, along it and along the normal."""

    across: Doubles
    along: Doubles
    up: Doubles


class Lit(NamedTuple):
    """N frames under P pairs of directions, as a shader with maps sees them; all (N, P).

    `n_i` and `n_o` are the cosines of viewer and light to the normal, the first at least `BENT`.
    """

    view: Squares
    light: Squares
    half: Squares
    n_i: Doubles
    n_o: Doubles


def lit(normal: Doubles, tangent: Doubles, wi: Doubles, wo: Doubles) -> Lit:
    """Return what pairs of directions (P, 3) are in the frames of N fibres.

    `normal` and `tangent`, the fibre's direction, are (N, 3), unit and orthogonal. Renderers bend
    a normal that is turned away from the viewer until it is not.
    """
    short = np.maximum(BENT - dot(normal[:, None], wi), 0)
    up = normal[:, None] + short[..., None] * wi
    up /= np.linalg.norm(up, axis=-1, keepdims=True)
    along = tangent[:, None] - up * dot(up, tangent[:, None])[..., None]
    along /= np.linalg.norm(along, axis=-1, keepdims=True)

    def squares(direction: Doubles) -> tuple[Squares, Doubles]:
        n, b = dot(up, direction), dot(along, direction)
        return Squares(np.maximum(1 - n**2 - b**2, 0), b**2, n**2), n

    (view, n_i), (light, n_o), (half, _) = (squares(w) for w in (wi, wo, halfway(wi, wo)))
    return Lit(view, light, half, n_i, n_o)


def mirror(under: Lit, alpha_along: float, alpha_across: float) -> Doubles:
    """Return D V n·wo (N, P) in 1/sr: the GGX lobe without its Fresnel factor.

    ``D = 1 / (π α_t α_b (h_t²/α_t² + h_b²/α_b² + h_n²)²)`` and, with
    ``Λ(w) = sqrt(w_n² + α_t² w_t² + α_b² w_b²)``, ``V = 1 / (2 (o_n Λ(i) + i_n Λ(o)))``: the
    height-correlated masking of Smith (Heitz 2014).
    """
    narrow, wide = alpha_along**2, alpha_across**2
    spread = under.half.across / wide + under.half.along / narrow + under.half.up
    n_o = np.maximum(under.n_o, 0)
    masks = 2 * (
        n_o * _masked(under.view, narrow, wide) + under.n_i * _masked(under.light, narrow, wide)
    )
    scale = np.pi * alpha_along * alpha_across
    return np.asarray(n_o / (scale * spread**2 * np.maximum(masks, 1e-12)))


def fresnel_edge(cos_half: Doubles) -> Doubles:
    """Return (1 − c)⁵, with which ``F = F0 + (1 − F0) (1 − c)⁵`` (Schlick 1994)."""
    return np.asarray((1 - np.clip(cos_half, 0, 1)) ** 5)


@lru_cache(maxsize=256)
def albedos(alpha: float) -> tuple[Doubles, Doubles]:
    """Return a and b (16,) of ``E = a F0 + b``, which the lobe reflects to `COSINES`.

    By quadrature; `alpha` is isotropic.
    """
    mid, cosine = COSINES, COSINES[:, None, None]
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
    count = len(mid) ** 2
    direct, rim = (np.sum(share * part, (1, 2)) / count for part in (1 - edge, edge))
    direct.flags.writeable = rim.flags.writeable = False
    return direct, rim


def halfway(wi: Doubles, wo: Doubles) -> Doubles:
    """Return the unit vectors (P, 3) between `wi` and `wo` (P, 3)."""
    total = wi + wo
    return np.asarray(total / np.linalg.norm(total, axis=-1, keepdims=True))


def _masked(w: Squares, narrow: float, wide: float) -> Doubles:
    return np.asarray(np.sqrt(w.up + wide * w.across + narrow * w.along))
