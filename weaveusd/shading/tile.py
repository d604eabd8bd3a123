"""The reflectance of a whole tile, exact and of the lobes that may stand in for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.shading.fibre import dot, facing
from weaveusd.shading.lobe import COSINES, Lit, fresnel_edge, halfway, lit, mirror
from weaveusd.shading.microcylinder import Parameters, lobes, normalization_of

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.shading.fibre import Doubles
    from weaveusd.shading.measured import Measured, Texels
    from weaveusd.yarn.model import Optics

TEXELS, FEWEST = 160, 8
"""Texels looked at, shared by the parts of the tile, and of one part."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """What yarns of one system and equal optics add to the tile's reflectance times cosine.

    P pairs of directions, A candidates for the lobe.
    """

    exact: Doubles  # (P, 3) 1/sr
    diffuse: Doubles  # (16, P, 3) of a Lambertian base, by the viewer's cosine to the texel
    lobe: Doubles  # (A, P) of the mirror-like lobe, without Fresnel's factor
    edge: Doubles  # (A, P) the same times (1 − c)⁵


@dataclass(frozen=True, slots=True, eq=False)
class _Sample:
    """Texels of a part: frames (N, 3), color and gain (N, 3), weight (N,) in the tile."""

    normal: Doubles
    tangent: Doubles
    color: Doubles
    albedo: Doubles
    weight: Doubles


def tile_parts(
    weave: Weave,
    texels: Sequence[Texels | None],
    measured: Sequence[Measured],
    wi: Doubles,
    wo: Doubles,
    alphas: Sequence[tuple[float, float]],
) -> tuple[list[Part], list[int | None]]:
    """Return the parts of the tile, and the index of each yarn's part.

    Every yarn counts by its share of the face; one that no texel shows has no part.
    """
    members: dict[tuple[str, Optics], list[int]] = {}
    for index, yarn in enumerate(weave.yarns):
        if texels[index] is not None:
            members.setdefault((yarn.system, yarn.optics), []).append(index)
    wanted = max(FEWEST, TEXELS // max(len(members), 1))
    parts: list[Part] = []
    owner: list[int | None] = [None] * len(weave.yarns)
    for (_, optics), group in members.items():
        for index in group:
            owner[index] = len(parts)
        sample = _sample(weave, texels, measured, group, wanted)
        parts.append(_part(sample, optics, wi, wo, alphas))
    return parts, owner


def flat_part(
    color: Doubles, fibre: Doubles, wi: Doubles, wo: Doubles, alphas: Sequence[tuple[float, float]]
) -> Part:
    """Return what a flat cloth of `color` (3,) reflects whose fibres lie along `fibre` (3,).

    Its `exact` is zero: it stands for others.
    """
    up, one = np.array([[0.0, 0.0, 1.0]]), np.ones(1)
    flat = _Sample(up, fibre[None], color[None], color[None], one)
    return Part(np.zeros((len(wi), 3)), *_reflected(flat, wi, wo, alphas))


def mean_color(weave: Weave, texels: Sequence[Texels | None]) -> Doubles:
    """Return the mean of the yarns' colors, (3,), by their shares of the face."""
    seen = [(yarn.color, own.share) for yarn, own in zip(weave.yarns, texels, strict=True) if own]
    colors, shares = (np.array(column) for column in zip(*seen, strict=True))
    return np.asarray(shares @ colors / shares.sum())


def _sample(
    weave: Weave,
    texels: Sequence[Texels | None],
    measured: Sequence[Measured],
    group: Sequence[int],
    wanted: int,
) -> _Sample:
    each = max(1, wanted // len(group))
    rows: list[tuple[Doubles, ...]] = []
    for index in group:
        found = texels[index]
        if found is None:
            continue
        normal, tangent = found.normal[:each], found.tangent[:each]
        count = len(normal)
        color = np.tile(np.asarray(weave.yarns[index].color, float), (count, 1))
        weight = np.full(count, found.share / count)
        rows.append((normal, tangent, color, color * measured[index].gain, weight))
    return _Sample(*(np.concatenate(column) for column in zip(*rows, strict=True)))


def _part(
    sample: _Sample,
    optics: Optics,
    wi: Doubles,
    wo: Doubles,
    alphas: Sequence[tuple[float, float]],
) -> Part:
    return Part(_exact(sample, optics, wi, wo), *_reflected(sample, wi, wo, alphas))


def _reflected(
    sample: _Sample, wi: Doubles, wo: Doubles, alphas: Sequence[tuple[float, float]]
) -> tuple[Doubles, Doubles, Doubles]:
    """Return what `sample` reflects as standard shaders have it: a `Part` but for `exact`."""
    under = lit(sample.normal, sample.tangent, wi, wo)
    weight = sample.weight[:, None] * (under.n_o > 0)
    lobe = np.stack([np.sum(weight * mirror(under, *alpha), 0) for alpha in alphas])
    edge = lobe * fresnel_edge(dot(wi, halfway(wi, wo)))
    return _diffuse(sample, under, weight), lobe, edge


def _diffuse(sample: _Sample, under: Lit, weight: Doubles) -> Doubles:
    """Return Lambert's reflectance times cosine (16, P, 3), by the viewer's cosine."""
    steps = len(COSINES)
    step = np.minimum((under.n_i * steps).astype(int), steps - 1)
    cosine = weight * np.maximum(under.n_o, 0) / np.pi
    result = np.zeros((steps, weight.shape[1], 3))
    for index in range(steps):
        within = np.where(step == index, cosine, 0)
        for channel in range(3):
            result[index, :, channel] = np.sum(within * sample.color[:, channel, None], 0)
    return result


def _exact(sample: _Sample, optics: Optics, wi: Doubles, wo: Doubles) -> Doubles:
    """Return the mean over the texels of (f_R + A N_V f_V) |n·wo|, (P, 3) in 1/sr."""
    o = optics
    params = Parameters(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v, o.tau, 1.0)
    normal, tangent = sample.normal[:, None], sample.tangent[:, None]
    surface, volume = lobes(wi, wo, normal, tangent, params)
    # Light that comes from behind the yarn and above the cloth is none (the side rule).
    cosine = np.maximum(dot(facing(normal, wi[None]), wo), 0) * sample.weight[:, None]
    surface, volume = surface * cosine, volume * cosine * normalization_of(params)
    return np.stack([np.sum(surface + sample.albedo[:, k, None] * volume, 0) for k in range(3)], -1)
