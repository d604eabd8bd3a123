"""Fresnel reflectance of a dielectric."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


def reflectance(cos_theta: ArrayLike, eta: ArrayLike) -> NDArray[np.float64]:
    """Return the exact unpolarized reflectance of a dielectric, from outside.

    `cos_theta` (…) is taken absolute and clipped to 0…1; `eta` ≥ 1 is the index inside over
    that outside. The mean of the squared amplitude ratios of both polarizations.
    """
    cos_i = np.clip(np.abs(np.asarray(cos_theta, float)), 0, 1)
    eta = np.asarray(eta, float)
    cos_t = np.sqrt(1 - (1 - cos_i**2) / eta**2)
    parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    return np.asarray(0.5 * (parallel**2 + perpendicular**2))
