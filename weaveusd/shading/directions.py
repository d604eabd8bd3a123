"""Pairs of directions at which two reflectances are compared, the same on every machine."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from weaveusd.shading.fibre import Doubles

LOWEST = 0.1
"""Least cosine to the cloth's normal: closer to the cloth little is seen of it."""

_PLASTIC = 1.1673039782614187
"""The root of x⁵ = x + 1, whose powers are an even sequence in four dimensions (Roberts 2018)."""

_SPREAD = 0.6
"""How far beside the mirror's direction a pair near it may lie, as a difference of vectors."""


def pairs(count: int) -> tuple[Doubles, Doubles]:
    """Return wi and wo, (count, 3) each, unit, above the cloth; in the cloth's frame.

    Of four pairs in a row two are free, one is near the mirror's direction and one lies in a
    plane with the normal. Those in a row are alike in nothing else.
    """
    index = np.arange(1, count + 1)
    u, v, s, t = (np.asarray((0.5 + index * _PLASTIC**-k) % 1, float) for k in (1, 2, 3, 4))
    wi, free = _above(u, v), _above(s, t)
    aside = np.stack([s - 0.5, t - 0.5, np.zeros(count)], -1) * _SPREAD
    near = _lifted(wi * (-1, -1, 1) + aside)
    level = np.hypot(wi[:, 0], wi[:, 1])
    turn = np.where(t < 0.5, -1, 1) * np.hypot(free[:, 0], free[:, 1]) / level
    plane = np.stack([wi[:, 0] * turn, wi[:, 1] * turn, free[:, 2]], -1)
    kind = (index % 4)[:, None]
    wo = np.where(kind < 2, free, np.where(kind == 2, near, plane))
    return wi, wo


def _above(u: Doubles, v: Doubles) -> Doubles:
    z = LOWEST + (1 - LOWEST) * u * 0.999
    level, turn = np.sqrt(1 - z**2), 2 * np.pi * v
    return np.stack([level * np.cos(turn), level * np.sin(turn), z], -1)


def _lifted(direction: Doubles) -> Doubles:
    unit = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    unit[:, 2] = np.maximum(unit[:, 2], LOWEST)
    return np.asarray(unit / np.linalg.norm(unit, axis=-1, keepdims=True))
