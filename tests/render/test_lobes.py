from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.render.cloths import PRESETS
from weaveusd.render import lobes

GOLDEN = Path(__file__).parents[3] / "shared" / "golden" / "microcylinder.json"
KEYS = ("eta", "k_d", "k_s", "gamma_s", "gamma_v", "tau", "N_V")


def unit(vectors: Any) -> Any:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def cases(count: int, seed: int = 7) -> dict[str, Any]:
    """Random frames, directions and optics, in double precision."""
    rng = np.random.default_rng(seed)
    n = unit(rng.normal(size=(count, 3)))
    t = rng.normal(size=(count, 3))
    t = unit(t - n * np.sum(n * t, axis=1, keepdims=True))
    rows = np.array(list(PRESETS.values()))[np.arange(count) % len(PRESETS)]
    return {
        "n": n,
        "t": t,
        "wi": unit(rng.normal(size=(count, 3))),
        "wo": unit(rng.normal(size=(count, 3))),
        "A": rng.uniform(0, 1, (count, 3)),
        "eta": rows[:, 0],
        "k_d": rows[:, 1],
        "k_s": rng.uniform(0, 1, count),
        "gamma_s": np.radians(rows[:, 2]),
        "gamma_v": np.radians(rows[:, 3]),
        "tau": np.where(np.arange(count) % 2, 0.3, 0.0),
        "N_V": rows[:, 4],
    }


def reference(c: dict[str, Any]) -> Any:
    """The formula of the module's docstring, straight from its angles."""
    n = c["n"] * np.where(np.sum(c["n"] * c["wi"], axis=1) < 0, -1, 1)[:, None]
    b = np.cross(n, c["t"])

    def angles(w: Any) -> tuple[Any, Any]:
        theta = np.arcsin(np.clip(np.sum(w * c["t"], axis=1), -1, 1))
        return theta, np.arctan2(np.sum(w * b, axis=1), np.sum(w * n, axis=1))

    def cauchy(gamma: Any, x: Any) -> Any:
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
    f_r = np.where(same, f_r * 0.5 * cauchy(c["gamma_s"], th) / m**2, 0)
    volume = (1 - c["k_d"]) * 0.5 * cauchy(c["gamma_v"], th) / m**2
    volume += c["k_d"] * 0.5 / (ci + co)
    f_v = np.where(same, 1 - c["tau"], c["tau"]) * 0.5 * (1 - fresnel(ci)) * (1 - fresnel(co))
    f_v = f_v * volume
    return (f_r[:, None] + c["A"] * (c["N_V"] * f_v)[:, None]) * np.abs(side)[:, None]


def arguments(mi: Any, c: dict[str, Any]) -> tuple[Any, ...]:
    """The cases as Dr.Jit arrays: wi, wo, n, t, parameters."""

    def vector(key: str) -> Any:
        return mi.Vector3f(np.asarray(c[key], np.float32).T)

    yarn = lobes.LobeParameters(
        mi.Color3f(np.asarray(c["A"], np.float32).T),
        *(mi.Float(np.asarray(c[key], np.float32)) for key in KEYS),
    )
    return vector("wi"), vector("wo"), vector("n"), vector("t"), yarn


def steepest(c: dict[str, Any]) -> Any:
    """Larger inclination of both directions to the yarn's normal plane, in degrees."""
    sines = [np.abs(np.sum(c[w] * c["t"], axis=1)) for w in ("wi", "wo")]
    return np.degrees(np.arcsin(np.clip(np.maximum(*sines), 0, 1)))


def assert_close(found: Any, expected: Any, inclination: Any) -> None:
    limit = np.where(inclination > 80, 1e-3, 2e-4)[:, None]
    assert np.all(np.abs(found - expected) <= limit * np.abs(expected) + 1e-9)


def test_values_are_those_of_the_formula_in_double_precision(mi: Any) -> None:
    c = cases(512)
    wi, wo, n, t, yarn = arguments(mi, c)
    value = np.array(lobes.evaluate(wi, wo, n, t, yarn)).T
    assert_close(value, reference(c), steepest(c))


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
    value = np.array(lobes.evaluate(*arguments(mi, c))).T
    assert value[:, 0] == pytest.approx(KNOWN_VALUES, rel=2e-4)


@pytest.mark.skipif(not GOLDEN.is_file(), reason="../shared/golden is not beside the checkout")
def test_values_agree_with_the_golden_file(mi: Any) -> None:
    rows = json.loads(GOLDEN.read_text())
    c = {key: np.array([row[key] for row in rows]) for key in ("wi", "wo", "n", "t", "A", *KEYS)}
    value = np.array(lobes.evaluate(*arguments(mi, c))).T
    assert_close(value, np.array([row["eval"] for row in rows]), steepest(c))


def test_a_yarn_reflects_the_same_both_ways(mi: Any) -> None:
    c = cases(512)
    forth = reference(c) / np.abs(np.sum(c["n"] * c["wo"], axis=1))[:, None]
    wi, wo, n, t, yarn = arguments(mi, c)
    back = np.array(lobes.evaluate(wo, wi, n, t, yarn)).T
    back /= np.abs(np.sum(c["n"] * c["wi"], axis=1))[:, None]
    np.testing.assert_allclose(back, forth, rtol=3e-3, atol=1e-7)


def test_both_faces_of_a_yarn_are_alike(mi: Any) -> None:
    wi, wo, n, t, yarn = arguments(mi, cases(64))
    front, back = lobes.evaluate(wi, wo, n, t, yarn), lobes.evaluate(wi, wo, -n, t, yarn)
    np.testing.assert_allclose(np.array(front), np.array(back), rtol=1e-4, atol=1e-7)


def test_the_density_is_zero_wherever_the_value_is(mi: Any) -> None:
    c = cases(4096)
    c["tau"] = np.zeros(4096)
    wi, wo, n, t, yarn = arguments(mi, c)
    value, pdf = lobes.evaluate_pdf(wi, wo, n, t, yarn)
    dark = np.array(value).max(axis=0) == 0
    assert dark.any()
    assert not np.array(pdf)[dark].any()


def test_black_yarn_without_a_surface_is_never_sampled(mi: Any) -> None:
    c = cases(16)
    c["A"], c["k_s"] = np.zeros((16, 3)), np.zeros(16)
    assert not np.array(lobes.pdf(*arguments(mi, c))).any()


@pytest.mark.parametrize("preset", list(PRESETS))
@pytest.mark.parametrize("tau", [0.0, 0.3])
def test_the_density_integrates_to_one(mi: Any, preset: str, tau: float) -> None:
    # In the yarn's own coordinates: dω = cos θ dθ dφ, θ spaced finely where the lobe is.
    eta, k_d, gamma_s, gamma_v, norm = PRESETS[preset]
    sin_i, cos_i = math.sin(0.6), math.cos(0.6)
    sines = np.linspace(-np.pi / 2, np.pi / 2, 4001)
    theta = (sines[1:] + sines[:-1]) / 2
    phi = (np.arange(256) + 0.5) / 256 * 2 * np.pi
    grid_t, grid_p = (g.ravel() for g in np.meshgrid(theta, phi, indexing="ij"))
    wo = np.stack(
        (np.cos(grid_t) * np.sin(grid_p), np.sin(grid_t), np.cos(grid_t) * np.cos(grid_p))
    )
    yarn = lobes.LobeParameters(
        mi.Color3f(0.5), mi.Float(eta), mi.Float(k_d), mi.Float(1), mi.Float(np.radians(gamma_s)),
        mi.Float(np.radians(gamma_v)), mi.Float(tau), mi.Float(norm),
    )  # fmt: skip
    wi = mi.Vector3f(0.3 * cos_i, sin_i, math.sqrt(0.91) * cos_i)
    n, t = mi.Vector3f(0, 0, 1), mi.Vector3f(0, 1, 0)
    pdf = np.array(lobes.pdf(wi, mi.Vector3f(wo.astype(np.float32)), n, t, yarn), np.float64)
    cell = (sines[1] - sines[0]) * 2 * np.pi / 256
    assert np.sum(pdf * np.cos(grid_t)) * cell == pytest.approx(1, abs=2e-3)


@pytest.mark.parametrize("preset", list(PRESETS))
@pytest.mark.parametrize("inclination", [0.0, 50.0, 85.0])
def test_no_yarn_returns_more_light_than_it_gets(mi: Any, preset: str, inclination: float) -> None:
    count = 1 << 16
    eta, k_d, gamma_s, gamma_v, norm = PRESETS[preset]
    yarn = lobes.LobeParameters(
        mi.Color3f(1.0), mi.Float(eta), mi.Float(k_d), mi.Float(1), mi.Float(np.radians(gamma_s)),
        mi.Float(np.radians(gamma_v)), mi.Float(0.3), mi.Float(norm),
    )  # fmt: skip
    rng = mi.PCG32(size=count)
    choice, point = rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32())
    tilt = math.radians(inclination)
    wi = mi.Vector3f(0, math.sin(tilt), math.cos(tilt))
    n, t = mi.Vector3f(0, 0, 1), mi.Vector3f(0, 1, 0)
    wo = lobes.sample(choice, point, wi, n, t, yarn)
    value, pdf = lobes.evaluate_pdf(wi, wo, n, t, yarn)
    weight = np.array(value)[0] / np.maximum(np.array(pdf), 1e-20)
    assert weight.mean() < 1.0 + 4 * weight.std() / np.sqrt(count)


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
        value, pdf = lobes.evaluate_pdf(*directions, yarn)
        assert np.array(value) == pytest.approx(expected[k], rel=1e-3, abs=1e-9)
        assert (pdf == 0) == (expected[k].max() == 0)
