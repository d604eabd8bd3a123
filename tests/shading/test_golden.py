"""The reference agrees with values that were found without it (tests/golden/make_shading.py)."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tests.golden import make_shading
from weaveusd.shading import microcylinder, published
from weaveusd.shading.fibre import in_fibre_frame
from weaveusd.shading.microcylinder import Parameters
from weaveusd.shading.normalization import normalization, surface_albedo, volume_albedo

SHARED = Path(__file__).parents[3] / "shared" / "golden" / "published_bsdf.json"
PROFILES = {"gauss": "gaussian", "cauchy_thesis": "cauchy", "cauchy": "cauchy_cut"}
FIELDS = ("eta", "k_d", "k_s", "gamma_s", "gamma_v", "tau", "A", "gaussian")


@cache
def golden():
    return json.loads(make_shading.FILE.read_text())


def of(case):
    """Frame and parameters of a case."""
    return tuple(case[k] for k in ("wi", "wo", "n", "t")), Parameters(*(case[k] for k in FIELDS))


def test_lobes_are_those_found_without_our_code():
    for case in golden()["cases"]:
        frame, params = of(case)
        f_r, f_v = microcylinder.lobes(*frame, params)
        np.testing.assert_allclose(f_r, case["f_R"], rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(f_v, case["f_V"], rtol=1e-9, atol=1e-15)
        value = microcylinder.evaluate(*frame, params)
        np.testing.assert_allclose(value, case["eval"], rtol=1e-7, atol=1e-15)


def test_normalizations_are_those_of_adaptive_quadrature():
    for case in golden()["cases"][::2]:
        _, params = of(case)
        found = normalization(*params[:5], params.gaussian)
        assert found == pytest.approx(case["N_V"], rel=1e-7)


def test_directional_albedos_are_those_of_adaptive_quadrature():
    cases = {(c["optics"], c["gaussian"]): of(c)[1] for c in golden()["cases"]}
    for row in golden()["albedos"]:
        o, gaussian = cases[row["optics"], row["gaussian"]], row["gaussian"]
        for k, theta in enumerate(row["inclination"]):
            surface = surface_albedo(theta, o.eta, o.k_s, o.gamma_s, gaussian)
            volume = volume_albedo(theta, o.eta, o.k_d, o.gamma_v, gaussian)
            assert surface == pytest.approx(row["E_R"][k], rel=1e-6)
            assert volume == pytest.approx(row["E_V"][k], rel=1e-6)


def test_published_lobes_are_those_found_without_our_code():
    for case in golden()["cases"]:
        frame, params = of(case)
        expected = case["published"]
        f_s, f_v = published.lobes(*frame, params, profile=expected["kind"])
        np.testing.assert_allclose(f_s, expected["f_s"], rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(f_v, expected["f_v"], rtol=1e-9, atol=1e-15)
        fibre = in_fibre_frame(*frame)
        if fibre.n_dot_o > 0:
            masked = published.evaluate(*frame, params, profile=expected["kind"], masking="sadeghi")
            albedo = (1 - params.tau) * np.array(params.A)
            value = expected["M"] * fibre.cos_o * (f_s + albedo * f_v)
            np.testing.assert_allclose(masked, value, rtol=1e-9, atol=1e-15)


@pytest.mark.skipif(not SHARED.is_file(), reason="../shared/golden is not beside the checkout")
def test_the_published_form_is_that_of_the_golden_file():
    for case in json.loads(SHARED.read_text())["values"]:
        params = Parameters(*(case[k] for k in ("eta", "kd", "ks", "gs", "gv", "tau", "A")))
        frame = tuple(case[k] for k in ("wi", "wo", "n", "t"))
        profile = PROFILES[case["kind"]]
        f_s, f_v = published.lobes(*frame, params, profile=profile)
        np.testing.assert_allclose(f_s, case["fs"], rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(f_v, case["fv"], rtol=1e-9, atol=1e-15)
        value = published.evaluate(*frame, params, profile=profile, masking=case["masking"])
        np.testing.assert_allclose(value, case["eval"], rtol=1e-9, atol=1e-15)


@pytest.mark.slow
def test_the_golden_file_is_what_its_script_writes():
    def equal(found, expected):
        if isinstance(expected, dict):
            assert found.keys() == expected.keys()
            for key, value in expected.items():
                equal(found[key], value)
        elif isinstance(expected, list):
            for one, other in zip(found, expected, strict=True):
                equal(one, other)
        elif isinstance(expected, float):
            assert found == pytest.approx(expected, rel=1e-9, abs=1e-15)
        else:
            assert found == expected

    equal(make_shading.values(), golden())
