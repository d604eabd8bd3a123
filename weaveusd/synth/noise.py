"""Noise along threads: what wanders along a yarn, and the repeat still tiles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from weaveusd.synth.compiled import inlined

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int32]
    Places = NDArray[np.uint32]

MAX_KNOTS = 512
MAX_SIGMAS = 3.0
"""Deviations are clipped to so many standard deviations."""


def settled(values: ArrayLike) -> Doubles:
    """Return `values` (…) rounded to single precision, as doubles.

    Sines, powers and logarithms of libraries differ in the last bit of a double from machine to
    machine. Rounded they are the same, but for one in 2^28.
    """
    return np.asarray(values, np.float32).astype(float)


class Blend(NamedTuple):
    """Which two knots every texel of an axis lies between, and the weight of each.

    One row for each of several deviations, whose knots are not as many.
    """

    left: Places  # (deviations, texels)
    right: Places  # (deviations, texels)
    left_weight: Doubles  # (deviations, texels)
    right_weight: Doubles  # (deviations, texels)


def wander(
    deviation: Sequence[float],
    correlation_mm: Sequence[float],
    yarn: Indices,
    length_mm: float,
    seed: tuple[int, ...],
) -> Doubles:
    """Return deviations ~ N(0, σ²) (knots, threads) at knots along each thread.

    `deviation` σ and `correlation_mm` are those of each yarn, `yarn` (threads,) says which one
    a thread is of. The knots divide the repeat evenly, about one a correlation length of the
    yarn with the shortest; a repeat shorter than that has one, so that threads differ but do
    not change. A yarn's deviations add up to zero, so that even a small repeat has its mean;
    but for that, threads are independent. The same `seed` gives the same numbers.
    """
    sigma = np.asarray(deviation, float)
    moving = sigma > 0
    if not moving.any():
        return np.zeros((1, len(yarn)))
    shortest = float(np.asarray(correlation_mm, float)[moving].min())
    knots = int(np.clip(round(length_mm / shortest), 1, MAX_KNOTS))
    normal = np.random.Generator(np.random.PCG64(seed)).standard_normal((len(yarn), knots))
    normal = np.clip(settled(normal), -MAX_SIGMAS, MAX_SIGMAS)
    for one in np.unique(yarn):
        own = normal[yarn == one]
        # An exact sum: that of NumPy may differ between machines.
        normal[yarn == one] = own - math.fsum(own.ravel()) / own.size
    return np.ascontiguousarray((sigma[yarn, None] * normal).T)


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
    index = left.astype(np.uint32) % count.astype(np.uint32)
    right = (index + np.uint32(1)) % count.astype(np.uint32)
    return Blend(index, right, (1.0 - w) / norm, w / norm)


@inlined
def beside(knots: Doubles, blend: Blend, kind: int, texel: int) -> Any:
    """Return both rows of `knots` (knots, threads) beside a texel, and their weights."""
    left, right = blend.left[kind, texel], blend.right[kind, texel]
    low, high = blend.left_weight[kind, texel], blend.right_weight[kind, texel]
    return knots[left], knots[right], low, high
