"""The bent tube: golden geometry, and the laws it follows."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from weaveusd.synth.spine import (
    circle_bend,
    circle_radius,
    conic_bend,
    conic_parameters,
    conic_spine,
    frame,
    sin_cos,
)

GOLDEN = Path(__file__).parents[3] / "shared" / "golden" / "geometry.json"


@pytest.mark.skipif(not GOLDEN.is_file(), reason="../shared/golden is not here")
def test_golden_geometry_holds():
    for case in json.loads(GOLDEN.read_text())["values"]:
        a = 0.5 * case["width"]
        b = a * case["b_over_a"]
        sin_v = case["x"] / a
        cos_v = math.sqrt(1 - sin_v**2)
        y, length = abs(case["y"]), case["length"]
        if case["spine"] == "conic":
            shape = conic_parameters(length, case["umax"], b, case["kappa"])
            sin_u, cos_u, z = conic_bend(y, *shape, b * cos_v)
        else:
            bend = min(case["bend"], 0.5 * length) if case["spine"] == "end" else 0.5 * length
            radius = circle_radius(bend, case["umax"], b)
            sin_u, cos_u, z = circle_bend(y - (0.5 * length - bend), radius, b * cos_v)
        sin_u = math.copysign(sin_u, case["y"])
        found = frame(sin_u, cos_u, sin_v, cos_v, case["b_over_a"], *sin_cos(case["psi"]))
        assert math.asin(sin_u) == pytest.approx(case["u"], abs=1e-9)
        assert z + b * (cos_v * cos_u - 1) == pytest.approx(case["z"], abs=1e-9)
        n_x, n_y, n_z, t_x, t_y, t_z = found
        if case["weft"]:
            n_x, n_y, t_x, t_y = n_y, -n_x, t_y, -t_x
        np.testing.assert_allclose([n_x, n_y, n_z], case["n"], atol=1e-9)
        np.testing.assert_allclose([t_x, t_y, t_z], case["t"], atol=1e-9)


@pytest.mark.parametrize("kappa", [-0.9, -0.5, -0.2, 0.0, 0.4, 2.0])
@pytest.mark.parametrize("u_max", [0.15, 0.4, 0.9])
def test_a_conic_passes_its_ends_and_slopes_like_its_spine(kappa, u_max):
    length, b = 3.0, 0.2
    r_hat, scale = conic_parameters(length, u_max, b, kappa)
    sin_u, cos_u, _ = conic_bend(0.5 * length, r_hat, scale, b)
    assert math.asin(sin_u) == pytest.approx(u_max, abs=1e-9)
    assert cos_u == pytest.approx(math.cos(u_max), abs=1e-9)
    h = 1e-6
    (y0, z0, _), (y1, z1, _) = (
        conic_spine(math.sin(0.5 * u_max + s), r_hat, scale) for s in (-h, h)
    )
    assert (z1 - z0) / (y1 - y0) == pytest.approx(-math.tan(0.5 * u_max), rel=1e-4)


def test_a_conic_without_eccentricity_is_a_circle():
    u_max, b, length = 0.6, 0.2, 2.0
    radius = circle_radius(0.5 * length, u_max, b)
    shape = conic_parameters(length, u_max, b, 0.0)
    for y in np.linspace(0, 1, 9):
        np.testing.assert_allclose(
            conic_bend(y, *shape, 0.8 * b), circle_bend(y, radius, 0.8 * b), atol=1e-12
        )


def test_frames_are_orthonormal():
    rng = np.random.default_rng(0)
    for u, v, psi, flat in rng.uniform([-1.5, -1.5, -1.5, 0.1], [1.5, 1.5, 1.5, 1.5], (500, 4)):
        f = np.array(frame(np.sin(u), np.cos(u), np.sin(v), np.cos(v), flat, *sin_cos(psi)))
        n, t = f[:3], f[3:]
        assert n @ n == pytest.approx(1, abs=1e-12)
        assert t @ t == pytest.approx(1, abs=1e-12)
        assert n @ t == pytest.approx(0, abs=1e-12)


def test_sine_and_cosine_are_right_to_a_billionth():
    angles = np.linspace(-np.pi, np.pi, 4001)
    found = np.array([sin_cos(a) for a in angles])
    np.testing.assert_allclose(found[:, 0], np.sin(angles), atol=1e-12)
    np.testing.assert_allclose(found[:, 1], np.cos(angles), atol=1e-12)
