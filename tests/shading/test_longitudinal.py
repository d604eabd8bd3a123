"""Cauchy and Gaussian profiles: mass, matching, and how they are drawn."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from weaveusd.shading.longitudinal import (
    CAUCHY_PER_GAUSSIAN_AREA,
    CAUCHY_PER_GAUSSIAN_WIDTH,
    cauchy,
    gaussian,
    inclination_density,
    sample_inclination,
)


def area_between(gamma: float) -> float:
    """∫ |Cauchy − Gaussian| for a Gaussian of deviation 1."""
    x = np.linspace(0, 10, 100_001)
    near = np.trapezoid(np.abs(cauchy(gamma, x) - gaussian(1, x)), x)
    # Beyond 10 there is the Cauchy's tail alone.
    return float(2 * near + 1 - 2 / np.pi * np.arctan(10 / gamma))


def test_the_matching_constants_match():
    best = minimize_scalar(area_between, bounds=(0.3, 2), method="bounded")
    assert best.x == pytest.approx(CAUCHY_PER_GAUSSIAN_AREA, abs=1e-3)
    assert best.fun == pytest.approx(0.380, abs=1e-3)
    half = CAUCHY_PER_GAUSSIAN_WIDTH
    assert gaussian(1, half) == pytest.approx(0.5 * gaussian(1, 0))
    assert cauchy(half, half) == pytest.approx(0.5 * cauchy(half, 0))


@pytest.mark.parametrize("is_gaussian", [False, True])
@pytest.mark.parametrize("gamma", [0.0436, 0.42, 1.05])
@pytest.mark.parametrize("theta_i", [0.0, -0.9, 1.5707])
def test_inclinations_are_drawn_as_their_density_says(is_gaussian, gamma, theta_i):
    def cumulative(theta_o: float) -> float:
        around = [-theta_i + k * gamma for k in (-16, -4, 0, 4, 16)]
        borders = np.unique(np.clip([-np.pi / 2, *around, theta_o], -np.pi / 2, theta_o))
        x = np.concatenate(
            [[-np.pi / 2], *(np.linspace(a, b, 20_001) for a, b in pairwise(borders))]
        )
        return np.trapezoid(
            inclination_density(np.array(theta_i), x, gamma, is_gaussian=is_gaussian), x
        )

    assert cumulative(np.pi / 2) == pytest.approx(1, abs=1e-7)
    for u in (0.0, 0.001, 0.3, 0.9, 0.9999, 1.0):
        theta_o = sample_inclination(np.array(u), np.array(theta_i), gamma, is_gaussian=is_gaussian)
        assert cumulative(float(theta_o)) == pytest.approx(u, abs=1e-6)
