"""Twist noise: the fibre's angle wanders along a yarn, and the repeat still tiles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.yarn.model import Yarn

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int32]

MAX_KNOTS = 512


def twist_wander(
    yarns: tuple[Yarn, ...], yarn: Indices, length_mm: float, seed: tuple[int, int]
) -> Doubles:
    """Return deviations ~ N(0, σ²) of the twist angle (threads, knots) along each thread.

    In radians, at most 3 σ and never beyond ±1 rad. The knots divide the repeat evenly, about
    one a correlation length of the yarn with the shortest; a repeat shorter than that has one.
    Threads are independent of each other. σ and the correlation length are the yarn's; the
    numbers come from `seed`: the user's and the system's.
    """
    noisy = [y for y in yarns if y.twist_deviation > 0]
    if not noisy:
        return np.zeros((len(yarn), 1))
    shortest = min(y.twist_correlation_mm for y in noisy)
    knots = int(np.clip(round(length_mm / shortest), 1, MAX_KNOTS))
    noise = np.random.Generator(np.random.PCG64(seed)).standard_normal((len(yarn), knots))
    deviation = np.array([y.twist_deviation for y in yarns])[yarn, None]
    return np.asarray(np.clip(deviation * np.clip(noise, -3, 3), -1, 1))
