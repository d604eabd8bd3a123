"""The cloth from afar: reflectance of a footprint from the moments of the yarns under it.

A footprint's texels are told by `synth.moments`: of each system how much is flat, rising and
falling, means and variances of the places S along the float and X across the yarn, and the twist.
Each of the three is taken for a box in S, and both halves of the yarn for boxes in X. The boxes are
cut into arcs along S and places across. Each is shaded as one frame but for what varies too much
inside: of the lobes along the fibre the exact mean over the arc is taken, since a Cauchy profile
has a closed antiderivative; the narrow one is shaded where most of it is; the cosine to the light
may end inside. Across, only that part of a box counts which viewer and light both see.

Without variance all frames are one, and the value is that of `microcylinder.evaluate`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.shading.fibre import dot, in_fibre_frame
from weaveusd.shading.footprint import NOTHING, arcs, coverage, halves, twist
from weaveusd.shading.longitudinal import mean_profile
from weaveusd.shading.microcylinder import Parameters, scattered
from weaveusd.shading.normalization import normalization

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from weaveusd.shading.fibre import Doubles
    from weaveusd.synth.moments import Footprint, Section
    from weaveusd.yarn.model import Optics


@dataclass(frozen=True, slots=True)
class Nodes:
    """How finely a footprint is cut: places across each half of a yarn, arcs of each slope."""

    across: int
    arcs: int


FULL, LEAN = Nodes(2, 2), Nodes(1, 2)

STEEPEST = 0.9998
"""No sine of an inclination exceeds that of 90° − 0.02 rad."""


class _Strand(NamedTuple):
    """Frames to be shaded for P pairs of directions, in the yarn's frame."""

    x: Doubles  # (P,) place across
    s: tuple[float, float]  # places along, both ends of the arc
    sin_psi: float
    weight: Doubles  # (P,) share of the footprint


def evaluate(
    wi: ArrayLike, wo: ArrayLike, footprints: Iterable[Footprint], nodes: Nodes = FULL
) -> Doubles:
    """Return the mean of (f_R + A N_V f_V) |n·wo| over a footprint, (P, 3) in 1/sr.

    `wi` and `wo` (P, 3) are unit vectors in the cloth's frame, to the viewer and to the light;
    `footprints` are those of warp and weft. Light counts where yarn and cloth agree on its side,
    and gaps add nothing.
    """
    wi, wo = np.atleast_2d(np.asarray(wi, float)), np.atleast_2d(np.asarray(wo, float))
    total = np.zeros((len(wi), 3))
    for footprint in footprints:
        total += _system(wi, wo, footprint, nodes)
    return total


def parameters(optics: Optics) -> Parameters:
    """Return `optics` as the BSDF has them, with A = 1."""
    o = optics
    return Parameters(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v, o.tau, 1.0)


def _system(wi: Doubles, wo: Doubles, footprint: Footprint, nodes: Nodes) -> Doubles:
    out = np.zeros((len(wi), 3))
    moments = np.asarray(footprint.moments, float)
    a = coverage(moments)
    if a <= NOTHING:
        return out
    # Which side the light is on; the yarn is turned so that this is a matter of the frame alone.
    side = np.where(wi[:, 2] * wo[:, 2] < 0, -1.0, 1.0)
    if footprint.weft:
        wi, wo = (np.stack([-w[:, 1], w[:, 0], w[:, 2]], -1) for w in (wi, wo))
    albedo = np.asarray(footprint.albedo, float) / a
    kinds = [
        (parameters(o), _normalization(o), float(share) / a)
        for o, share in zip(footprint.kinds, footprint.share, strict=True)
        if share > NOTHING * a
    ]
    for strand in _strands(wi, wo, side, moments, footprint.section, nodes):
        surface, volume = _shaded(wi, wo, side, strand, footprint.section, kinds)
        out += (strand.weight * surface)[:, None] + albedo * (strand.weight * volume)[:, None]
    return out


def _shaded(
    wi: Doubles,
    wo: Doubles,
    side: Doubles,
    strand: _Strand,
    section: Section,
    kinds: list[tuple[Parameters, float, float]],
) -> tuple[Doubles, Doubles]:
    """Return what surface and volume send back (P,), the second for A = 1."""
    low, high = strand.s
    frames = [_frame(s, strand.x, strand.sin_psi, section) for s in (low, 0.5 * (low + high), high)]
    begin, middle, end = (0.5 * (_inclination(wi, t) + _inclination(wo, t)) for _, t in frames)
    center, reach = 0.5 * (0.5 * (begin + end) + middle), 0.5 * (end - begin)
    begin, end = center - reach, center + reach
    fibre = in_fibre_frame(wi, wo, *frames[1])._replace(n_dot_o=side)
    cosines = [_cosine(wi, wo, side, n) for n, _ in frames]
    cosine = 0.5 * (_mean_above(cosines[0], cosines[1]) + _mean_above(cosines[1], cosines[2]))
    surface, volume = np.zeros(len(wi)), np.zeros(len(wi))
    for params, n_v, share in kinds:
        narrow, wide = (
            mean_profile(gamma, begin, end, is_gaussian=False)
            for gamma in (params.gamma_s, params.gamma_v)
        )
        _, f_v = scattered(fibre, params, narrow, wide)
        volume += share * n_v * f_v * cosine
        # The narrow lobe has its own frame: the one where most of it is.
        s = low + (high - low) * _peak(params.gamma_s, begin, end)
        normal, tangent = _frame(s, strand.x, strand.sin_psi, section)
        at_peak = in_fibre_frame(wi, wo, normal, tangent)._replace(n_dot_o=side)
        f_r, _ = scattered(at_peak, params, narrow, wide)
        surface += share * f_r * np.maximum(_cosine(wi, wo, side, normal), 0)
    return surface, volume


def _strands(
    wi: Doubles, wo: Doubles, side: Doubles, moments: Doubles, section: Section, nodes: Nodes
) -> Iterator[_Strand]:
    """Yield the frames that stand for a footprint: of each arc and half, in the light or beyond.

    The far face of a yarn, turned away from viewer and light alike, is seen where the texture
    shows it; one place is enough for it.
    """
    across = halves(moments)
    mean, deviation = twist(moments)
    outside = np.where(wi[:, 2] < 0, -1.0, 1.0)
    for i, arc in enumerate(arcs(moments, nodes.arcs)):
        for j, half in enumerate(across):
            sine, cosine = _bend(0.5 * (arc.low + arc.high), 0.5 * (half.low + half.high), section)
            for face, count in ((outside, nodes.across), (-outside, 1)):
                lit = _lit(wi, face, float(sine), float(cosine), section)
                shone = _lit(wo, face * side, float(sine), float(cosine), section)
                low = np.maximum(np.maximum(lit[0], shone[0]), half.low)
                high = np.maximum(np.minimum(np.minimum(lit[1], shone[1]), half.high), low)
                weight = (high - low) * (arc.share * half.share / (half.high - half.low))
                if not weight.any():
                    continue
                for k, (node, part) in enumerate(_gauss(count)):
                    # Two points of mean and variance, each at every other frame.
                    psi = mean + (deviation if (i + j + k) % 2 else -deviation)
                    x = low + node * (high - low)
                    yield _Strand(x, (arc.low, arc.high), min(max(psi, -1), 1), part * weight)


def _bend(s: ArrayLike, x: ArrayLike, section: Section) -> tuple[Doubles, Doubles]:
    """Return sin u and cos u at a place: sin u = S (1 + k) / (1 + k cos v)."""
    k = section.curvature
    cos_v = np.sqrt(np.maximum(1 - np.square(x), 0))
    sine = np.clip(np.asarray(s) * (1 + k) / (1 + k * cos_v), -STEEPEST, STEEPEST)
    return sine, np.sqrt(1 - sine**2)


def _frame(s: ArrayLike, x: Doubles, sin_psi: float, section: Section) -> tuple[Doubles, Doubles]:
    """Return normal and fibre (P, 3) at a place, in the yarn's frame (physics.md C)."""
    sin_u, cos_u = _bend(s, x, section)
    cos_v, slant = np.sqrt(np.maximum(1 - x**2, 0)), section.flatness * x
    scale = 1 / np.sqrt(slant**2 + cos_v**2)
    aside, up = slant * scale, cos_v * scale
    cos_psi = np.sqrt(1 - sin_psi**2)
    normal = np.stack([aside, up * sin_u, up * cos_u], -1)
    fibre = [
        -sin_psi * up,
        cos_psi * cos_u + sin_psi * aside * sin_u,
        sin_psi * aside * cos_u - cos_psi * sin_u,
    ]
    return normal, np.stack(fibre, -1)


def _lit(
    w: Doubles, face: Doubles, sin_u: float, cos_u: float, section: Section
) -> tuple[Doubles, Doubles]:
    """Return the bounds (P,) in X between which a yarn inclined by u faces `w`; `face` is ±1.

    n·w ∝ ρ X w_x + cos v c with c = w_y sin u + w_z cos u, which changes its sign once, at
    X = −c / √(c² + ρ² w_x²) on the side of w_x.
    """
    c, aside = face * (w[:, 1] * sin_u + w[:, 2] * cos_u), face * w[:, 0]
    border = c / np.maximum(np.hypot(c, section.flatness * aside), 1e-12)
    return np.where(aside > 0, -border, -1), np.where(aside < 0, border, 1)


def _inclination(w: Doubles, fibre: Doubles) -> Doubles:
    return np.asarray(np.arcsin(np.clip(dot(w, fibre), -1, 1)))


def _cosine(wi: Doubles, wo: Doubles, side: Doubles, normal: Doubles) -> Doubles:
    """Return |n·wo|, negative where yarn and cloth disagree on the side of the light."""
    return np.asarray(side * np.where(dot(normal, wi) < 0, -1.0, 1.0) * dot(normal, wo))


def _peak(gamma: float, begin: Doubles, end: Doubles) -> Doubles:
    """Return the mean place, 0…1, of a Cauchy lobe along an arc from θ_h = `begin` to `end`.

    ``∫ x C(γ; x) dx = γ/(2π) ln(x² + γ²)`` over ``∫ C(γ; x) dx = atan(x/γ) / π``.
    """
    width = end - begin
    thin = np.abs(width) < 1e-3 * gamma
    mass = np.where(thin, 1, np.arctan(end / gamma) - np.arctan(begin / gamma))
    mean = 0.5 * gamma * np.log((end**2 + gamma**2) / (begin**2 + gamma**2)) / mass
    place = (mean - begin) / np.where(thin, 1, width)
    return np.where(thin, 0.5, np.clip(place, 0, 1))


def _mean_above(begin: Doubles, end: Doubles) -> Doubles:
    """Return the mean of max(c, 0) where c runs evenly from `begin` to `end`."""
    low, high = np.minimum(begin, end), np.maximum(begin, end)
    crossing = np.maximum(high, 0) ** 2 / (2 * np.maximum(high - low, 1e-12))
    return np.where(low >= 0, 0.5 * (low + high), crossing)


@lru_cache(maxsize=8)
def _gauss(count: int) -> tuple[tuple[float, float], ...]:
    """Return nodes in 0…1 and weights of Gauss and Legendre."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple(zip((0.5 * (nodes + 1)).tolist(), (0.5 * weights).tolist(), strict=True))


def _normalization(optics: Optics) -> float:
    o = optics
    return normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v)
