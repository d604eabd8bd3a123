"""Directions are drawn as the density says, and the density is one."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shading.fibres import ALONG, OPTICS, UP, parameters, unit
from weaveusd.shading.laws import density_integral, sphere
from weaveusd.shading.microcylinder import evaluate
from weaveusd.shading.sampling import pdf, sample


@pytest.mark.parametrize("gaussian", [False, True])
@pytest.mark.parametrize("key", OPTICS)
def test_the_density_integrates_to_one(key, gaussian):
    params = parameters(key, tau=0.3, gaussian=gaussian)
    for theta in (0.0, 0.6, -1.3):
        assert density_integral(params, theta, 0.3).whole == pytest.approx(1, abs=2e-6)


@pytest.mark.parametrize(
    ("key", "gaussian"),
    [(key, False) for key in OPTICS] + [(key, True) for key in list(OPTICS)[::6]],
)
def test_samples_follow_their_density(key, gaussian):
    params = parameters(key, tau=0.3, albedo=0.5, gaussian=gaussian)
    wi, n, t = unit(0.4, 0.3, 0.7), unit(0.2, -0.1, 1.0), unit(1.0, 0.0, -0.2)
    t = t - n * (n @ t)
    t /= np.linalg.norm(t)
    u = np.random.default_rng(2).random((200_000, 3))
    drawn = sample(wi, n, t, params, u)
    np.testing.assert_allclose(np.linalg.norm(drawn.wo, axis=-1), 1, atol=1e-12)
    np.testing.assert_allclose(drawn.pdf, pdf(wi, drawn.wo, n, t, params), rtol=1e-12)

    # The weights' mean is the albedo, whatever was sampled.
    frame = np.stack([np.cross(n, t), t, n])
    local, weight = sphere(float(np.arcsin(wi @ t)), params)
    value = evaluate(wi, local @ frame, n, t, params)
    albedo = np.einsum("ij,ij->", weight, value[..., 0])
    error = drawn.weight[:, 0].std() / np.sqrt(len(u))
    assert abs(drawn.weight[:, 0].mean() - albedo) < 4.5 * error

    # Inclination and side fall as often into each box as the density says.
    density = pdf(wi, local @ frame, n, t, params) * weight
    theta, side = np.arcsin(local[..., 1]), local[..., 2] > 0
    got = drawn.wo @ frame.T
    for low, high in [(-1.6, -0.5), (-0.5, -0.1), (-0.1, 0.3), (0.3, 1.6)]:
        for above in (True, False):
            inside = np.clip(theta, low, high) == theta
            expected = density[inside & (side == above)].sum()
            box = (np.arcsin(got[:, 1]) >= low) & (np.arcsin(got[:, 1]) < high)
            found = np.mean(box & ((got[:, 2] > 0) == above))
            assert abs(found - expected) < 0.006


def test_nothing_leaves_on_the_far_side_without_transmission():
    params = parameters("linen/linen", tau=0.0)
    below = unit(0.3, 0.1, -0.8)
    assert evaluate(UP, below, UP, ALONG, params).max() == 0
    assert pdf(UP, below, UP, ALONG, params) == 0


def test_black_yarn_without_a_surface_is_never_sampled():
    params = parameters("linen/linen", albedo=0.0)._replace(k_s=0.0)
    assert pdf(UP, unit(0.3, 0.1, 0.8), UP, ALONG, params) == 0


def test_any_leading_shape_is_welcome():
    params = parameters("linen/linen")
    wi = np.tile(unit(0.1, 0.2, 1.0), (4, 5, 1))
    assert pdf(wi, UP, UP, ALONG, params).shape == (4, 5)
    drawn = sample(wi, UP, ALONG, params, np.full((4, 5, 3), 0.4))
    assert drawn.wo.shape == (4, 5, 3)
    assert drawn.weight.shape == (4, 5, 3)
