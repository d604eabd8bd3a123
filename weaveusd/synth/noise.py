"""Noise along threads: what wanders along a yarn, and the repeat still tiles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int32]

MAX_KNOTS = 512
MAX_SIGMAS = 3.0
"""Deviations are clipped to so many standard deviations."""


class Blend(NamedTuple):
    """Which two knots every texel of an axis lies between, and the weight of each.

    One row for each of several deviations, whose knots are not as many.
    """

    left: Indices  # (deviations, texels)
    right: Indices  # (deviations, texels)
    left_weight: Doubles  # (deviations, texels)
    right_weight: Doubles  # (deviations, texels)


def wander(
    deviation: Sequence[float],
    correlation_mm: Sequence[float],
    yarn: Indices,
    length_mm: float,
    seed: tuple[int, ...],
) -> Doubles:
    """Return deviations ~ N(0, σ²) (threads, knots) at knots along each thread.

    `deviation` σ and `correlation_mm` are those of each yarn, `yarn` (threads,) says which one
    a thread is of. The knots divide the repeat evenly, about one a correlation length of the
    yarn with the shortest; a repeat shorter than that has one, so that threads differ but do
    not change. A yarn's deviations add up to zero, so that even a small repeat has its mean;
    but for that, threads are independent. The same `seed` gives the same numbers.
    """
    sigma = np.asarray(deviation, float)
    moving = sigma > 0
    if not moving.any():
        return np.zeros((len(yarn), 1))
    shortest = float(np.asarray(correlation_mm, float)[moving].min())
    knots = int(np.clip(round(length_mm / shortest), 1, MAX_KNOTS))
    normal = np.random.Generator(np.random.PCG64(seed)).standard_normal((len(yarn), knots))
    normal = np.clip(normal, -MAX_SIGMAS, MAX_SIGMAS)
    for one in np.unique(yarn):
        own = normal[yarn == one]
        # An exact sum: that of NumPy may differ between machines.
        normal[yarn == one] = own - math.fsum(own.ravel()) / own.size
    return np.asarray(sigma[yarn, None] * normal)


def blends(knots: Sequence[int], texels: int) -> Blend:
    """Return how `texels` texels over a repeat blend deviations of so many `knots`.

    Two neighbouring knots are blended linearly and divided by the norm of their weights, so
    that the variance between knots is that at the knots. A single knot stands as it is.
    """
    count = np.asarray(knots)[:, None]
    place = (np.arange(texels) + 0.5) * (count / texels)
    left = np.floor(place)
    w = np.where(count > 1, place - left, 0.0)
    norm = np.sqrt(w * w + (1.0 - w) * (1.0 - w))
    index = left.astype(np.int32) % count.astype(np.int32)
    right = (index + 1) % count.astype(np.int32)
    return Blend(index, right, (1.0 - w) / norm, w / norm)
