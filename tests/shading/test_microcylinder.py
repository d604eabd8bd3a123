"""The reference BSDF keeps its laws and the golden values."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from scipy.optimize import minimize_scalar

from tests.shading.fibres import ALONG, OPTICS, UP, parameters, unit
from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.laws import directional_albedo, reciprocity_error
from weaveusd.shading.microcylinder import Parameters, evaluate, lobes
from weaveusd.shading.normalization import normalization

GOLDEN = Path(__file__).parents[3] / "shared" / "golden"
golden = pytest.mark.skipif(not GOLDEN.is_dir(), reason="../shared/golden is not here")

KEYS = ("eta", "k_d", "k_s", "gamma_s", "gamma_v", "tau", "A")


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
def test_no_fibre_scatters_more_than_it_receives(key, gaussian):
    params = parameters(key, tau=0.25, gaussian=gaussian)
    for theta in np.linspace(-1.55, 1.55, 7):
        for phi in (0.0, 1.4):
            assert directional_albedo(params, theta, phi).whole <= 1 + 1e-6


@pytest.mark.parametrize("gaussian", [False, True])
@pytest.mark.parametrize("key", OPTICS)
def test_light_runs_both_ways(key, gaussian):
    assert reciprocity_error(parameters(key, tau=0.2, gaussian=gaussian)) < 1e-9


def test_any_leading_shape_is_welcome():
    params = parameters("linen/linen")
    wi = np.tile(unit(0.1, 0.2, 1.0), (4, 5, 1))
    assert evaluate(wi, UP, UP, ALONG, params).shape == (4, 5, 3)


def test_a_yarn_has_two_equal_faces():
    params = parameters("silk/silk_weft")
    wi, wo = unit(0.3, 0.2, 0.8), unit(-0.2, 0.1, 0.9)
    np.testing.assert_allclose(
        evaluate(wi, wo, UP, ALONG, params), evaluate(wi, wo, -UP, ALONG, params), rtol=1e-12
    )
