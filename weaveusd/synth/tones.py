"""Tones: the colors that one yarn shows, lighter and darker, fibre by fibre and ply by ply."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.color_space import LUMINANCE, RGB
from weaveusd.synth.noise import MAX_SIGMAS, settled

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.contract import ColorSpace
    from weaveusd.yarn.model import Yarn

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int32]

STEPS = 33
"""Tones between the darkest and the lightest, both `MAX_SIGMAS` from the mean."""

SLOTS = 64
"""Bundles of fibres among which a mélange shares out its colors."""

_EPSILON, _KAPPA = 216 / 24389, 24389 / 27  # CIE 15: the straight part of lightness


class Tones(NamedTuple):
    """Colors of all yarns, in the color space of the cloth."""

    color: Doubles  # (yarns, colors, 3) mean of each color
    scale: Doubles  # (yarns, colors, STEPS) its tones, each the color times this
    colors: Indices  # (yarns,) colors that a yarn has
    by_ply: Indices  # (yarns,) 1 where each ply has its color, 0 where bundles of fibres have
    slots: Indices  # (yarns, SLOTS) color of a bundle of fibres


def lay_tones(yarns: tuple[Yarn, ...], space: ColorSpace = "lin_rec709") -> Tones:
    """Return the tones of `yarns`, whose colors are in `space`.

    A tone is the color scaled so that its CIE lightness moves by the yarn's `color` deviation
    times −`MAX_SIGMAS`…`MAX_SIGMAS`; hue and chromaticity stay. The tones are scaled back so
    that their mean over a normal distribution is the color itself: a patch keeps the yarn's color.
    For that, a color so bright that its lightest tone would leave 0…1 varies less.
    """
    most = max(1, *(len(_colors(y)) for y in yarns))
    color = np.zeros((len(yarns), most, 3))
    scale = np.ones((len(yarns), most, STEPS))
    count = np.ones(len(yarns), np.int32)
    by_ply = np.zeros(len(yarns), np.int32)
    slots = np.zeros((len(yarns), SLOTS), np.int32)
    for i, yarn in enumerate(yarns):
        colors = _colors(yarn)
        count[i] = len(colors)
        by_ply[i] = bool(yarn.irregularity.strands)
        for k, (own, _) in enumerate(colors):
            color[i, k] = settled(own)
            scale[i, k] = _scales(color[i, k], yarn.irregularity.color, LUMINANCE[space])
        borders = np.cumsum([share for _, share in colors])
        places = (np.arange(SLOTS) + 0.5) / SLOTS * borders[-1]
        slots[i] = np.searchsorted(borders, places)
    return Tones(color, scale, count, by_ply, slots)


def lightness(y: Doubles) -> Doubles:
    """Return CIE L* of relative luminance (CIE 15:2018)."""
    return np.asarray(np.where(y > _EPSILON, 116 * np.cbrt(y) - 16, _KAPPA * y))


def luminance(lightness: Doubles) -> Doubles:
    """Return relative luminance of CIE L*, the inverse of `lightness`."""
    cubed = ((lightness + 16) / 116) ** 3
    return np.asarray(np.where(cubed > _EPSILON, cubed, lightness / _KAPPA))


def _colors(yarn: Yarn) -> tuple[tuple[tuple[float, float, float], float], ...]:
    if yarn.irregularity.strands:
        return tuple((color, 1.0) for color in yarn.irregularity.strands)
    return yarn.irregularity.melange or ((yarn.color, 1.0),)


def _scales(color: Doubles, delta_e: float, weights: RGB) -> Doubles:
    """Return the tones (STEPS,) of one color; `weights` are its components' luminance."""
    y = float(color @ weights)
    if delta_e == 0 or y <= 0:
        return np.ones(STEPS)
    sigmas = np.linspace(-MAX_SIGMAS, MAX_SIGMAS, STEPS)
    wanted = np.clip(lightness(np.array(y)) + delta_e * sigmas, 0, 100)
    scale = luminance(wanted) / y
    weight = np.exp(-0.5 * sigmas**2)
    scale *= weight.sum() / (weight @ scale)
    room = 1 / float(color.max()) - 1
    if scale.max() - 1 > room:
        scale = 1 + (scale - 1) * (room / (scale.max() - 1))
    # Rounding must not carry the lightest tone over 1.
    return np.minimum(settled(scale), 1 + room)
