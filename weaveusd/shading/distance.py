"""The cloth from afar: reflectance of a footprint from the moments of the yarns under it.

A footprint's texels are told by `synth.moments`: of each system how much is flat, rising and
falling, means and variances of the places S along the float and X across the yarn, and the twist.
`footprint` takes them for even distributions, `strands` cuts these into arcs and leaves only what
viewer and light both see. Each arc is shaded as one frame but for what varies too much inside: of
the lobes along the fibre the exact mean is taken, since a Cauchy profile has a closed
antiderivative; the narrow one is shaded where most of it is; the cosine to the light is a mean
along and across.

Without variance all frames are one, and the value is that of `microcylinder.evaluate`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.shading.fibre import dot, in_fibre_frame
from weaveusd.shading.footprint import NOTHING, coverage
from weaveusd.shading.longitudinal import mean_profile
from weaveusd.shading.microcylinder import Parameters, normalization_of, scattered
from weaveusd.shading.strands import FULL, LEAN, Nodes, Strand, frame, strands

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from weaveusd.shading.fibre import Doubles
    from weaveusd.synth.moments import Footprint, Section
    from weaveusd.yarn.model import Optics

__all__ = ["FULL", "LEAN", "Nodes", "evaluate", "parameters"]

GAUSS = (0.5 - 0.5 / 3**0.5, 0.5 + 0.5 / 3**0.5)
"""Places, 0…1, whose mean is that of a cubic; they lie a deviation off the middle."""

MOST_WIDER = 2.0
"""No strand is lit more than twice as well as its middle."""


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
        (parameters(o), normalization_of(parameters(o)), float(share) / a)
        for o, share in zip(footprint.kinds, footprint.share, strict=True)
        if share > NOTHING * a
    ]
    for strand in strands(wi, wo, side, moments, footprint.section, nodes):
        surface, volume = _shaded(wi, wo, side, strand, footprint.section, kinds)
        out += (strand.weight * surface)[:, None] + albedo * (strand.weight * volume)[:, None]
    return out


def _shaded(
    wi: Doubles,
    wo: Doubles,
    side: Doubles,
    strand: Strand,
    section: Section,
    kinds: list[tuple[Parameters, float, float]],
) -> tuple[Doubles, Doubles]:
    """Return what surface and volume send back (P,), the second for A = 1."""
    x, (low, high), sin_psi = strand.x, strand.along, strand.sin_psi
    middle = 0.5 * (low + high)
    left, right = strand.across
    along = [frame(s, x, sin_psi, section) for s in (low, middle, high)]
    across = [frame(middle, left + g * (right - left), sin_psi, section) for g in GAUSS]
    begin, end = _arc(wi, wo, along, across)
    # The sign in the middle: both ends may lie where the viewer sees the yarn edge on.
    face = side * np.where(dot(along[1][0], wi) < 0, -1.0, 1.0)
    cosines = [np.maximum(face * dot(n, wo), 0) for n, _ in along]
    # How much more light the strand's width has than its middle.
    aside = 0.5 * sum(np.maximum(_cosine(wi, wo, side, n), 0) for n, _ in across)
    wider = np.minimum(aside / np.maximum(cosines[1], 1e-9), MOST_WIDER)
    cosine = wider * (cosines[0] + 4 * cosines[1] + cosines[2]) / 6
    fibre = in_fibre_frame(wi, wo, *along[1])._replace(n_dot_o=side)
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
        normal, tangent = frame(s, x, sin_psi, section)
        at_peak = in_fibre_frame(wi, wo, normal, tangent)._replace(n_dot_o=side)
        f_r, _ = scattered(at_peak, params, narrow, wide)
        surface += share * f_r * wider * np.maximum(face * dot(normal, wo), 0)
    return surface, volume


def _arc(
    wi: Doubles,
    wo: Doubles,
    along: list[tuple[Doubles, Doubles]],
    across: list[tuple[Doubles, Doubles]],
) -> tuple[Doubles, Doubles]:
    """Return θ_h (P,) at both ends of an arc, widened by the variance of θ_h across.

    `along` are the frames at begin, middle and end, `across` those at the places `GAUSS`.
    """
    begin, middle, end, left, right = (
        0.5 * (_inclination(wi, t) + _inclination(wo, t)) for _, t in (*along, *across)
    )
    center, reach = 0.5 * (0.5 * (begin + end) + middle), 0.5 * (end - begin)
    reach = np.copysign(np.sqrt(reach**2 + 0.75 * (right - left) ** 2), reach)
    return center - reach, center + reach


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
