"""The reference BSDF keeps its laws and the golden values."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from scipy.optimize import minimize_scalar

from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.laws import density_integral, directional_albedo, reciprocity_error, sphere
from weaveusd.shading.microcylinder import Parameters, evaluate, lobes, pdf, sample
from weaveusd.shading.normalization import normalization
from weaveusd.yarn.recipe import preset_names, read_preset

GOLDEN = Path(__file__).parents[3] / "shared" / "golden"
golden = pytest.mark.skipif(not GOLDEN.is_dir(), reason="../shared/golden is not here")

UP = np.array([0.0, 0.0, 1.0])
ALONG = np.array([0.0, 1.0, 0.0])
KEYS = ("eta", "k_d", "k_s", "gamma_s", "gamma_v", "tau", "A")

OPTICS = {
    f"{name}/{yarn.name}": yarn.optics
    for name in reversed(preset_names())
    for yarn in read_preset(name).yarns
}
# Yarns that scatter alike are one case.
OPTICS = {key: optics for optics, key in {o: k for k, o in OPTICS.items()}.items()}


def parameters(
    key: str, tau: float | None = None, albedo: float = 1.0, gaussian: bool = False
) -> Parameters:
    o = OPTICS[key]
    tau = o.tau if tau is None else tau
    return Parameters(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v, tau, np.full(3, albedo), gaussian)


def unit(*v: float) -> np.ndarray:
    return np.array(v) / np.linalg.norm(v)


@golden
def test_golden_values_hold():
    for case in json.loads((GOLDEN / "microcylinder.json").read_text()):
        params = Parameters(*(case[k] for k in KEYS))
        frame = (case["wi"], case["wo"], case["n"], case["t"])
        f_r, f_v = lobes(*frame, params)
        np.testing.assert_allclose(f_r, case["f_R"], rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(f_v, case["f_V"], rtol=1e-9, atol=1e-15)
        value = evaluate(*frame, params, n_v=case["N_V"])
        np.testing.assert_allclose(value, case["eval"], rtol=1e-9, atol=1e-15)


@golden
def test_golden_normalizations_hold_as_far_as_they_were_integrated():
    """Ours are converged to 1e-9, the golden ones differ by up to 1.4e-5 in either direction."""
    for case in json.loads((GOLDEN / "microcylinder.json").read_text()):
        params = Parameters(*(case[k] for k in KEYS))
        assert normalization(*params[:5]) == pytest.approx(case["N_V"], rel=1.5e-5)


def test_the_normalization_is_converged():
    """Against adaptive quadrature and a fine search."""
    eta, k_d, k_s, gamma_s, gamma_v = 1.46, 0.3, 1.0, *np.radians([12, 24])

    def longitudinal(ti, to, gamma):
        cauchy = gamma / (np.pi * ((0.5 * (ti + to)) ** 2 + gamma**2))
        return 0.5 * cauchy / max(np.cos(ti), np.cos(to)) ** 2

    def volume(ti):
        def integrand(to):
            enter, leave = (1 - float(reflectance(np.cos(a), eta)) for a in (ti, to))
            scatter = (1 - k_d) * longitudinal(ti, to, gamma_v)
            scatter += k_d * 0.5 / (np.cos(ti) + np.cos(to))
            return enter * leave * scatter * np.cos(to) ** 2

        kinks = [-ti, ti]
        return quad(integrand, -np.pi / 2, np.pi / 2, points=kinks, limit=200, epsabs=1e-12)[0]

    def surface(ti):
        def integrand(phi, to):
            half = np.cos(phi / 2)
            f = float(reflectance(np.cos(0.5 * (ti - to)) * half, eta))
            return f * half * np.cos(phi) * longitudinal(ti, to, gamma_s) * np.cos(to) ** 2

        inner = [
            dblquad(integrand, a, b, -np.pi / 2, np.pi / 2, epsabs=1e-11)[0]
            for a, b in pairwise([-np.pi / 2, -ti, ti, np.pi / 2])
        ]
        return k_s * 3 / (4 * np.sqrt(2)) * sum(inner)

    best = minimize_scalar(lambda t: -volume(t), bounds=(0.7, 1.0), method="bounded",
                           options={"xatol": 1e-8})  # fmt: skip
    expected = (1 - surface(np.pi / 2 - 1e-3)) / -best.fun
    found = normalization(eta, k_d, k_s, float(gamma_s), float(gamma_v))
    assert found == pytest.approx(expected, rel=1e-8)


@golden
def test_golden_fresnel_holds():
    values = json.loads((GOLDEN / "fresnel.json").read_text())["values"]
    eta, cos, expected = np.array([[v["eta"], v["cos"], v["F"]] for v in values]).T
    np.testing.assert_allclose(reflectance(cos, eta), expected, atol=1e-12)


@pytest.mark.parametrize("gaussian", [False, True])
@pytest.mark.parametrize("key", OPTICS)
def test_the_density_integrates_to_one(key, gaussian):
    params = parameters(key, tau=0.3, gaussian=gaussian)
    for theta in (0.0, 0.6, -1.3):
        assert density_integral(params, theta, 0.3).whole == pytest.approx(1, abs=2e-6)


@pytest.mark.parametrize("gaussian", [False, True])
@pytest.mark.parametrize("key", OPTICS)
def test_no_fibre_scatters_more_than_it_receives(key, gaussian):
    params = parameters(key, tau=0.25, gaussian=gaussian)
    for theta in np.linspace(-1.55, 1.55, 7):
        for phi in (0.0, 1.4):
            assert directional_albedo(params, theta, phi).whole <= 1 + 1e-6


@pytest.mark.parametrize("gaussian", [False, True])
@pytest.mark.parametrize("key", OPTICS)
def test_light_runs_both_ways(key, gaussian):
    assert reciprocity_error(parameters(key, tau=0.2, gaussian=gaussian)) < 1e-9


@pytest.mark.parametrize(
    ("key", "numbers", "gaussian"),
    [(key, 2 + k % 2, False) for k, key in enumerate(OPTICS)]
    + [(key, 3, True) for key in list(OPTICS)[::6]],
)
def test_samples_follow_their_density(key, numbers, gaussian):
    params = parameters(key, tau=0.3, albedo=0.5, gaussian=gaussian)
    wi, n, t = unit(0.4, 0.3, 0.7), unit(0.2, -0.1, 1.0), unit(1.0, 0.0, -0.2)
    t = t - n * (n @ t)
    t /= np.linalg.norm(t)
    u = np.random.default_rng(2).random((200_000, numbers))
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


def test_any_leading_shape_is_welcome():
    params = parameters("linen/linen")
    wi = np.tile(unit(0.1, 0.2, 1.0), (4, 5, 1))
    assert evaluate(wi, UP, UP, ALONG, params).shape == (4, 5, 3)
    assert pdf(wi, UP, UP, ALONG, params).shape == (4, 5)
    drawn = sample(wi, UP, ALONG, params, np.full((4, 5, 2), 0.4))
    assert drawn.wo.shape == (4, 5, 3)
    assert drawn.weight.shape == (4, 5, 3)


def test_nothing_leaves_on_the_far_side_without_transmission():
    params = parameters("linen/linen", tau=0.0)
    below = unit(0.3, 0.1, -0.8)
    assert evaluate(UP, below, UP, ALONG, params).max() == 0
    assert pdf(UP, below, UP, ALONG, params) == 0


def test_a_yarn_has_two_equal_faces():
    params = parameters("silk/silk_weft")
    wi, wo = unit(0.3, 0.2, 0.8), unit(-0.2, 0.1, 0.9)
    np.testing.assert_allclose(
        evaluate(wi, wo, UP, ALONG, params), evaluate(wi, wo, -UP, ALONG, params), rtol=1e-12
    )
