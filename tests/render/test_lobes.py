from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.render.cloths import PRESETS
from tests.render.yarns import KEYS, arguments, cases
from weaveusd.render import lobes

GOLDEN = Path(__file__).parents[3] / "shared" / "golden" / "microcylinder.json"


def reference(c: dict[str, Any], gaussian: bool = False) -> Any:
    """The formula of the module's docstring, straight from its angles."""
    n = c["n"] * np.where(np.sum(c["n"] * c["wi"], axis=1) < 0, -1, 1)[:, None]
    b = np.cross(n, c["t"])

    def angles(w: Any) -> tuple[Any, Any]:
        theta = np.arcsin(np.clip(np.sum(w * c["t"], axis=1), -1, 1))
        return theta, np.arctan2(np.sum(w * b, axis=1), np.sum(w * n, axis=1))

    def profile(gamma: Any, x: Any) -> Any:
        if gaussian:
            return np.exp(-0.5 * (x / gamma) ** 2) / (gamma * np.sqrt(2 * np.pi))
        return gamma / (np.pi * (x**2 + gamma**2))

    def fresnel(cosine: Any) -> Any:
        eta = c["eta"]
        inside = np.sqrt(1 - (1 - cosine**2) / eta**2)
        s = (cosine - eta * inside) / (cosine + eta * inside)
        p = (eta * cosine - inside) / (eta * cosine + inside)
        return (s**2 + p**2) / 2

    (ti, pi), (to, po) = angles(c["wi"]), angles(c["wo"])
    th, td = (ti + to) / 2, (ti - to) / 2
    pd = np.mod(pi - po + np.pi, 2 * np.pi) - np.pi
    ci, co = np.cos(ti), np.cos(to)
    m = np.maximum(ci, co)
    side = np.sum(n * c["wo"], axis=1)
    same = side > 0
    f_r = c["k_s"] * 3 / (4 * np.sqrt(2)) * fresnel(np.cos(td) * np.cos(pd / 2)) * np.cos(pd / 2)
    f_r = np.where(same, f_r * 0.5 * profile(c["gamma_s"], th) / m**2, 0)
    volume = (1 - c["k_d"]) * 0.5 * profile(c["gamma_v"], th) / m**2
    volume += c["k_d"] * 0.5 / (ci + co)
    f_v = np.where(same, 1 - c["tau"], c["tau"]) * 0.5 * (1 - fresnel(ci)) * (1 - fresnel(co))
    f_v = f_v * volume
    return (f_r[:, None] + c["A"] * (c["N_V"] * f_v)[:, None]) * np.abs(side)[:, None]


def value(wi: Any, wo: Any, n: Any, t: Any, yarn: Any) -> Any:
    fibre = lobes.fibre(wi, n, t)
    return lobes.value(yarn, fibre, fibre.direction(wo))


def steepest(c: dict[str, Any]) -> Any:
    """Larger inclination of both directions to the yarn's normal plane, in degrees."""
    sines = [np.abs(np.sum(c[w] * c["t"], axis=1)) for w in ("wi", "wo")]
    return np.degrees(np.arcsin(np.clip(np.maximum(*sines), 0, 1)))


def assert_close(found: Any, expected: Any, inclination: Any) -> None:
    limit = np.where(inclination > 80, 1e-3, 2e-4)[:, None]
    assert np.all(np.abs(found - expected) <= limit * np.abs(expected) + 1e-9)


@pytest.mark.parametrize("gaussian", [False, True])
def test_values_are_those_of_the_formula_in_double_precision(mi: Any, gaussian: bool) -> None:
    c = cases(512)
    found = np.array(value(*arguments(mi, c, gaussian=gaussian))).T
    assert_close(found, reference(c, gaussian), steepest(c))


def test_a_gaussian_lobe_is_no_cauchy_lobe(mi: Any) -> None:
    c = cases(512)
    gaussian, cauchy = (np.array(value(*arguments(mi, c, gaussian=g)))[1] for g in (True, False))
    assert np.sum(np.abs(gaussian - cauchy)) > 0.2 * np.sum(cauchy)


# wi, wo, albedo, preset and tau, with n = +z and t = +y; the values are those of `reference`.
KNOWN = [
    ((0, 0, 1), (0, 0, 1), 0.5, "linen", 0.0),
    ((0, 0, 1), (0.6, 0, 0.8), 0.5, "linen", 0.0),
    ((0.6, 0, 0.8), (-0.6, 0, 0.8), 0.5, "linen", 0.0),
    ((0, 0.6, 0.8), (0, -0.6, 0.8), 0.25, "polyester flat", 0.0),
    ((0, 0.6, 0.8), (0, -0.6, -0.8), 0.25, "polyester flat", 0.3),
    ((0, 0.6, 0.8), (0, -0.8, 0.6), 0.25, "polyester twisted", 0.3),
    ((0, 0.28, 0.96), (0, 0.96, 0.28), 0.75, "crepe flat", 0.0),
    ((0.96, 0, 0.28), (0, 0, 1), 0.75, "crepe twisted", 0.0),
    ((0.48, 0.36, 0.8), (-0.64, -0.48, 0.6), 0.1, "shot warp", 0.0),
    ((0.48, 0.36, 0.8), (0.64, -0.48, 0.6), 0.9, "shot weft", 0.0),
    ((0.48, 0.36, -0.8), (0.64, -0.48, -0.6), 0.9, "velvet", 0.0),
    ((0.48, 0.36, 0.8), (0.64, -0.48, -0.6), 0.9, "velvet", 0.3),
]
KNOWN_VALUES = [
    0.1618113,
    0.1289248,
    0.1281429,
    0.3326249,
    0.06413823,
    0.0381879,
    0.01178649,
    0.2087158,
    0.03968104,
    0.2620087,
    0.2515717,
    0.07125626,
]


def test_known_values_stay_what_they_were(mi: Any) -> None:
    c = {
        "wi": np.array([k[0] for k in KNOWN], float),
        "wo": np.array([k[1] for k in KNOWN], float),
        "A": np.array([[k[2]] * 3 for k in KNOWN]),
        "n": np.tile((0.0, 0.0, 1.0), (len(KNOWN), 1)),
        "t": np.tile((0.0, 1.0, 0.0), (len(KNOWN), 1)),
        "k_s": np.ones(len(KNOWN)),
        "tau": np.array([k[4] for k in KNOWN]),
    }
    rows = np.array([PRESETS[k[3]] for k in KNOWN])
    for key, column in zip(("eta", "k_d", "gamma_s", "gamma_v", "N_V"), rows.T, strict=True):
        c[key] = np.radians(column) if key.startswith("gamma") else column
    found = np.array(value(*arguments(mi, c))).T
    assert found[:, 0] == pytest.approx(KNOWN_VALUES, rel=2e-4)


@pytest.mark.skipif(not GOLDEN.is_file(), reason="../shared/golden is not beside the checkout")
def test_values_agree_with_the_golden_file(mi: Any) -> None:
    rows = json.loads(GOLDEN.read_text())
    c = {key: np.array([row[key] for row in rows]) for key in ("wi", "wo", "n", "t", "A", *KEYS)}
    found = np.array(value(*arguments(mi, c))).T
    assert_close(found, np.array([row["eval"] for row in rows]), steepest(c))


def test_a_yarn_reflects_the_same_both_ways(mi: Any) -> None:
    c = cases(512)
    forth = reference(c) / np.abs(np.sum(c["n"] * c["wo"], axis=1))[:, None]
    wi, wo, n, t, yarn = arguments(mi, c)
    back = np.array(value(wo, wi, n, t, yarn)).T
    back /= np.abs(np.sum(c["n"] * c["wi"], axis=1))[:, None]
    np.testing.assert_allclose(back, forth, rtol=3e-3, atol=1e-7)


def test_both_faces_of_a_yarn_are_alike(mi: Any) -> None:
    wi, wo, n, t, yarn = arguments(mi, cases(64))
    front, back = value(wi, wo, n, t, yarn), value(wi, wo, -n, t, yarn)
    np.testing.assert_allclose(np.array(front), np.array(back), rtol=1e-4, atol=1e-7)


def test_fresnel_is_what_the_textbook_says(mi: Any) -> None:
    def at(cosine: float, eta: float) -> float:
        return float(np.array(lobes.fresnel(mi.Float(cosine), mi.Float(eta)))[0])

    assert at(1, 1.5) == pytest.approx(0.04)
    assert at(0, 1.5) == pytest.approx(1)
    assert at(0.3, 1.0) == pytest.approx(0, abs=1e-6)
    # At Brewster's angle only one polarization returns.
    cosine = 1 / np.sqrt(1 + 1.5**2)
    assert at(cosine, 1.5) == pytest.approx(0.5 * ((1.5**2 - 1) / (1.5**2 + 1)) ** 2, rel=1e-5)


def test_the_scalar_variant_computes_the_same(mi: Any) -> None:
    c = cases(8)
    expected = reference(c)
    mi.set_variant("scalar_rgb")
    for k in range(8):
        yarn = lobes.LobeParameters(
            mi.Color3f(c["A"][k].tolist()), *(float(c[key][k]) for key in KEYS)
        )
        directions = (mi.Vector3f(c[key][k].tolist()) for key in ("wi", "wo", "n", "t"))
        wi, wo, n, t = directions
        assert np.array(value(wi, wo, n, t, yarn)) == pytest.approx(expected[k], rel=1e-3, abs=1e-9)
