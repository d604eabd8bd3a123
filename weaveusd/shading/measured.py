"""The albedo with which a woven yarn measures as the color that it is said to have.

A spectrophotometer of geometry d/8° lights the cloth evenly from all around and looks at it from 8°
to its normal, without the mirror's direction. What a yarn sends back is linear in A, since the
volume lobe is. With G what it would send back for A = 1, in the places and frames in which the
cloth shows it, A = color / G measures as the color (docs/bsdf.md). G is below 1: the fibre's albedo
is below A at most angles, a bent yarn faces away from some of the light, and some passes through.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.shading.fibre import dot, facing
from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.longitudinal import inclination_density, sample_inclination
from weaveusd.shading.normalization import normalization

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.shading.fibre import Doubles
    from weaveusd.synth.model import TextureSet
    from weaveusd.yarn.model import Optics, Yarn

VIEW = math.radians(8)
VIEWS = 4
"""Azimuths from which the cloth is looked at, evenly apart."""

ROWS, MOST_ROWS = 64, 256
"""Rows of texels looked at together, and in all."""

TEXELS, FEWEST = 8192, 32
"""Texels looked at, shared by the yarns, and of one yarn."""

DIGITS = 5
"""Digits to which results are rounded, so that a machine's last bit does not reach a file."""

_NODES = 16
_GOLDEN = 0.5 * (math.sqrt(5) - 1)


class Measured(NamedTuple):
    """How a yarn measures: A is `gain` times its color, and `reached` is what d/8° then finds.

    `reached` is the color itself where no A above 1 would be needed for it; else it is as light
    as it gets in the same hue.
    """

    gain: float
    reached: tuple[float, float, float]


class Texels(NamedTuple):
    """Some texels of a yarn: unit normals and directions of the fibre, (N, 3) each, cloth frame.

    `share` is the share of the cloth's face that the yarn has.
    """

    normal: Doubles
    tangent: Doubles
    share: float


def measured(weave: Weave, texels: Sequence[Texels | None]) -> tuple[Measured, ...]:
    """Return how each of `weave.yarns` measures from its `texels_of`; unseen ones have gain 1."""
    whites = white_reflectances(weave, texels)
    return tuple(_fit(yarn, white) for yarn, white in zip(weave.yarns, whites, strict=True))


def white_reflectances(weave: Weave, texels: Sequence[Texels | None]) -> tuple[float | None, ...]:
    """Return G, the d/8° reflectance of each yarn's volume lobe for A = 1; None where not seen."""
    return tuple(
        None if own is None else texel_reflectance(own.normal, own.tangent, yarn.optics)
        for yarn, own in zip(weave.yarns, texels, strict=True)
    )


def texel_reflectance(normal: Doubles, tangent: Doubles, optics: Optics) -> float:
    """Return the mean d/8° reflectance of texels (N, 3) of one yarn, for A = 1 and its N_V.

    ∫ N_V f_V |n·ωo| dωo over the directions that lie both on the yarn's side and on the cloth's,
    under light of unit radiance. In the azimuth around the fibre the integral is a closed form,
    along the fibre it takes nodes that follow the lobe.
    """
    o = optics
    turn = np.arange(VIEWS) * (2 * np.pi / VIEWS)
    wi = np.stack(
        [np.sin(VIEW) * np.cos(turn), np.sin(VIEW) * np.sin(turn), np.full(VIEWS, np.cos(VIEW))],
        axis=-1,
    )
    n = facing(np.asarray(normal, float)[:, None], wi)
    t = np.broadcast_to(np.asarray(tangent, float)[:, None], n.shape)
    sin_i = np.clip(dot(wi, t), -1, 1)[..., None]
    theta_i, cos_i = np.arcsin(sin_i), np.sqrt(1 - sin_i**2)
    up = n[..., 2], np.cross(n, t)[..., 2], t[..., 2]

    # Inclinations that follow the lobe, then some that are even in sin θo.
    x, w = np.polynomial.legendre.leggauss(_NODES)
    share, weight = 0.5 * (x + 1), 0.5 * w
    along = sample_inclination(share, theta_i, o.gamma_v, is_gaussian=False)
    cos_o = np.cos(along)
    flattest = np.maximum(cos_i, cos_o)
    # ½ C(γ_v; θ_h) over the density of the nodes is the lobe's mass between θo = ±π/2.
    density = inclination_density(theta_i, along, o.gamma_v, is_gaussian=False)
    lobe = 0.5 * o.gamma_v / (np.pi * ((0.5 * (theta_i + along)) ** 2 + o.gamma_v**2)) / density
    seen = _lit_azimuth(along, up) * (1 - reflectance(cos_o, o.eta)) * cos_o**2
    total = (1 - o.k_d) * np.sum(weight * lobe / flattest**2 * seen, -1)

    even = np.arcsin(x)[None, None]
    cos_o = np.sqrt(1 - x**2)
    seen = _lit_azimuth(even, up) * (1 - reflectance(cos_o, o.eta)) * cos_o
    total = total + o.k_d * np.sum(w * 0.5 / (cos_i + cos_o) * seen, -1)

    n_v = normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v)
    enter = 1 - reflectance(cos_i[..., 0], o.eta)
    return float(np.mean(0.5 * n_v * (1 - o.tau) * enter * total))


def _lit_azimuth(theta: Doubles, up: tuple[Doubles, Doubles, Doubles]) -> Doubles:
    """Return ∫ cos φ dφ over the azimuths at `theta` (N, views, nodes) from which light comes.

    They lie on the yarn's side, |φ| < π/2, and above the cloth: with Z the cloth's normal,
    cos θ (cos φ n·Z + sin φ b·Z) + sin θ t·Z > 0. `up` are n·Z, b·Z and t·Z, (N, views) each.
    """
    n_z, b_z, t_z = (component[..., None] for component in up)
    reach = np.maximum(np.hypot(n_z, b_z), 1e-9)
    middle = np.arctan2(b_z, n_z)
    half = np.arccos(np.clip(-np.tan(theta) * t_z / reach, -1, 1))
    low = np.clip(middle - half, -np.pi / 2, np.pi / 2)
    high = np.clip(middle + half, -np.pi / 2, np.pi / 2)
    return np.asarray(np.sin(high) - np.sin(low))


def texels_of(weave: Weave, textures: TextureSet) -> list[Texels | None]:
    """Return normals and tangents of some texels of each yarn, (N, 3) each; None where not seen.

    Rows are taken that lie apart, however many there are, until each yarn has its texels.
    """
    yarns = len(weave.yarns)
    wanted = max(FEWEST, TEXELS // yarns)
    order = np.argsort(np.arange(textures.height) * _GOLDEN % 1, kind="stable")
    found: list[list[np.ndarray]] = [[] for _ in range(yarns)]
    counts = np.zeros(yarns, int)
    for first in range(0, min(len(order), MOST_ROWS), ROWS):
        for row in order[first : first + ROWS]:
            band = textures.band(int(row), int(row) + 1)
            ids = band["yarn_id"][0, :, 0]
            vectors = np.concatenate([band["normal"][0], band["tangent"][0]], axis=-1)
            for yarn in np.unique(ids[ids >= 0]).astype(int):
                own = vectors[ids == yarn]
                found[yarn].append(own)
                counts[yarn] += len(own)
        if counts.min() >= wanted:
            break
    total = max(int(counts.sum()), 1)
    return [
        Texels(*_thinned(np.concatenate(own), wanted), int(count) / total) if own else None
        for own, count in zip(found, counts, strict=True)
    ]


def _thinned(vectors: np.ndarray, wanted: int) -> tuple[Doubles, Doubles]:
    """Return normals and tangents of `wanted` of the texels (N, 6), chosen by chance, seed 0.

    Any regular choice would step through the threads' own regularity.
    """
    order = np.random.default_rng(0).permutation(len(vectors))[:wanted]
    chosen = vectors[order].astype(float)
    normal, tangent = chosen[:, :3], chosen[:, 3:]
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    tangent -= normal * dot(normal, tangent)[:, None]
    return normal, tangent / np.linalg.norm(tangent, axis=-1, keepdims=True)


def _fit(yarn: Yarn, white: float | None) -> Measured:
    """Return the gain, no larger than keeps A of every color of the yarn within 1."""
    if white is None:
        return Measured(1.0, yarn.color)
    uneven = yarn.irregularity
    colors = [yarn.color, *(color for color, _ in uneven.melange), *uneven.strands]
    lightest = max(max(color) for color in colors)
    # The darkest yarn has some gain, and one that lets all light pass reaches nothing.
    most, wanted = 1 / max(lightest, 1e-3), 1 / max(white, 1e-3)
    share = _rounded(min(1.0, most * white))
    r, g, b = (component * share for component in yarn.color)
    return Measured(_rounded(min(most, wanted)), (r, g, b))


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
