"""How a lobe spreads along the fibre: Cauchy, or Gaussian for reference; drawn exactly.

Both are densities in θ_h = (θi + θo)/2. The same γ is the half width at half height of the
Cauchy lobe and the standard deviation of the Gaussian one. They are never alike: the
Cauchy keeps half of its mass outside ±γ. To match a Gaussian, multiply its γ by
`CAUCHY_PER_GAUSSIAN_AREA`, with which ∫ |Cauchy − Gaussian| is least (0.38 of 2 at most; the
minimum is flat), or by `CAUCHY_PER_GAUSSIAN_WIDTH`, with which the half widths are equal.
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Doubles = NDArray[np.float64]

CAUCHY_PER_GAUSSIAN_AREA = 0.732
CAUCHY_PER_GAUSSIAN_WIDTH = math.sqrt(2 * math.log(2))

_erfc = np.frompyfunc(math.erfc, 1, 1)
_quantile = np.frompyfunc(NormalDist().inv_cdf, 1, 1)


def cauchy(gamma: ArrayLike, x: ArrayLike) -> Doubles:
    """Return the Cauchy density γ / (π (x² + γ²)) of half width `gamma`."""
    gamma, x = np.asarray(gamma, float), np.asarray(x, float)
    return np.asarray(gamma / (np.pi * (x**2 + gamma**2)))


def gaussian(gamma: ArrayLike, x: ArrayLike) -> Doubles:
    """Return the Gaussian density of standard deviation `gamma`, of unit mass."""
    gamma, x = np.asarray(gamma, float), np.asarray(x, float)
    return np.asarray(np.exp(-0.5 * (x / gamma) ** 2) / (gamma * math.sqrt(2 * np.pi)))


def profile(gamma: ArrayLike, x: ArrayLike, *, is_gaussian: bool) -> Doubles:
    """Return `gaussian` or `cauchy`."""
    return gaussian(gamma, x) if is_gaussian else cauchy(gamma, x)


def mean_profile(
    gamma: ArrayLike, low: ArrayLike, high: ArrayLike, *, is_gaussian: bool
) -> Doubles:
    """Return the mean of `profile` between `low` and `high`, its value where both are one.

    The profile has a closed antiderivative; for the Cauchy lobe it is atan(x/γ) / π.
    """
    gamma, low, high = (np.asarray(x, float) for x in (gamma, low, high))
    width = high - low
    thin = np.abs(width) < 1e-4 * gamma
    mass = _share(high / gamma, is_gaussian) - _share(low / gamma, is_gaussian)
    middle = profile(gamma, 0.5 * (low + high), is_gaussian=is_gaussian)
    return np.where(thin, middle, mass / np.where(thin, 1, width))


def inclination_density(
    theta_i: Doubles, theta_o: Doubles, gamma: ArrayLike, *, is_gaussian: bool
) -> Doubles:
    """Return the density of `sample_inclination` at `theta_o`, (…) in 1/rad.

    It is ½ profile(γ; θ_h) over the mass of the profile between θo = ±π/2 (Wang et al. 2014,
    with dθ_h = ½ dθo).
    """
    low, high = _shares(theta_i, gamma, is_gaussian=is_gaussian)
    theta_h = 0.5 * (theta_i + theta_o)
    return np.asarray(0.5 * profile(gamma, theta_h, is_gaussian=is_gaussian) / (high - low))


def sample_inclination(
    u: Doubles, theta_i: Doubles, gamma: ArrayLike, *, is_gaussian: bool
) -> Doubles:
    """Return θo (…) in -π/2…π/2 for numbers `u` that are uniform in 0…1."""
    low, high = _shares(theta_i, gamma, is_gaussian=is_gaussian)
    share = low + u * (high - low)
    if is_gaussian:
        inside = np.clip(share, 1e-300, 1 - 2**-53)
        theta_h = np.asarray(gamma) * np.asarray(_quantile(inside), float)
    else:
        theta_h = np.asarray(gamma) * np.tan(np.pi * (share - 0.5))
    return np.asarray(np.clip(2 * theta_h - theta_i, -np.pi / 2, np.pi / 2))


def _shares(theta_i: Doubles, gamma: ArrayLike, *, is_gaussian: bool) -> tuple[Doubles, Doubles]:
    """Return the profile's cumulative share at θo = -π/2 and at θo = π/2."""
    gamma = np.asarray(gamma)
    low, high = (0.5 * (theta_i + side * np.pi / 2) / gamma for side in (-1, 1))
    return _share(low, is_gaussian), _share(high, is_gaussian)


def _share(x: Doubles, is_gaussian: bool) -> Doubles:
    if is_gaussian:
        return np.asarray(0.5 * np.asarray(_erfc(-x / math.sqrt(2)), float))
    return np.asarray(0.5 + np.arctan(x) / np.pi)
