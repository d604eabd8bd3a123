from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.render.cloths import PRESETS
from tests.render.yarns import KEYS, arguments, cases, preset_yarn
from weaveusd.render import lobes, sampling
from weaveusd.shading import sampling as reference
from weaveusd.shading.microcylinder import Parameters

FLAT = ("polyester flat", "crepe flat", "shot warp")
GRAZING_COSINE = 0.05


def density(wi: Any, wo: Any, n: Any, t: Any, yarn: Any) -> Any:
    fibre = lobes.fibre(wi, n, t)
    return sampling.density(yarn, fibre, fibre.direction(wo))


def upright(mi: Any, wi: Any) -> Any:
    return lobes.fibre(wi, mi.Vector3f(0, 0, 1), mi.Vector3f(0, 1, 0))


@pytest.mark.parametrize("preset", list(PRESETS))
@pytest.mark.parametrize("gaussian", [False, True])
def test_sampling_is_that_of_the_reference(mi: Any, preset: str, gaussian: bool) -> None:
    c = cases(512, seed=3)
    # Along the fibre single precision runs out of digits.
    kept = np.abs(np.einsum("kij,ij->ki", np.stack((c["wi"], c["wo"])), c["t"])).max(0) < 0.98
    c = {key: array[kept] for key, array in c.items()}
    wi, wo, n, t, _ = arguments(mi, c)
    yarn = preset_yarn(mi, preset, tau=0.3, gaussian=gaussian)
    eta, k_d, gamma_s, gamma_v, n_v = PRESETS[preset]
    widths = math.radians(gamma_s), math.radians(gamma_v)
    params = Parameters(eta, k_d, 1.0, *widths, 0.3, (0.5,) * 3, gaussian)

    pdf = reference.pdf(c["wi"], c["wo"], c["n"], c["t"], params, n_v=n_v)
    np.testing.assert_allclose(np.array(density(wi, wo, n, t, yarn)), pdf, rtol=1e-4)

    # A number that falls on a border between strategies may be taken for either.
    fibre = lobes.fibre(wi, n, t)
    choice, point = numbers(mi, int(kept.sum()))
    u = np.stack([np.array(choice), *np.array(point)], -1)
    drawn = reference.sample(c["wi"], c["n"], c["t"], params, u, n_v=n_v).wo
    ours = np.array(fibre.vector(sampling.sample(yarn, fibre, choice, point))).T
    assert np.mean(np.abs(ours - drawn).max(axis=1) < 1e-3) > 0.99


@pytest.mark.parametrize("gaussian", [False, True])
def test_the_density_is_zero_wherever_the_value_is(mi: Any, gaussian: bool) -> None:
    c = cases(4096)
    c["tau"] = np.zeros(4096)
    wi, wo, n, t, yarn = arguments(mi, c, gaussian=gaussian)
    fibre = lobes.fibre(wi, n, t)
    value = np.array(lobes.value(yarn, fibre, fibre.direction(wo)))
    dark = value.max(axis=0) == 0
    assert dark.any()
    pdf = np.array(density(wi, wo, n, t, yarn))
    assert not pdf[dark].any()
    assert pdf[~dark].all()


def test_black_yarn_without_a_surface_is_never_sampled(mi: Any) -> None:
    c = cases(16)
    c["A"], c["k_s"] = np.zeros((16, 3)), np.zeros(16)
    assert not np.array(density(*arguments(mi, c))).any()


@pytest.mark.parametrize("preset", list(PRESETS))
@pytest.mark.parametrize("tau", [0.0, 0.3])
@pytest.mark.parametrize("gaussian", [False, True])
def test_the_density_integrates_to_one(mi: Any, preset: str, tau: float, gaussian: bool) -> None:
    # In the yarn's own coordinates: dω = cos θ dθ dφ, θ spaced finely where the lobe is.
    sin_i, cos_i = math.sin(0.6), math.cos(0.6)
    sines = np.linspace(-np.pi / 2, np.pi / 2, 4001)
    theta = (sines[1:] + sines[:-1]) / 2
    phi = (np.arange(256) + 0.5) / 256 * 2 * np.pi
    grid_t, grid_p = (g.ravel() for g in np.meshgrid(theta, phi, indexing="ij"))
    wo = np.stack(
        (np.cos(grid_t) * np.sin(grid_p), np.sin(grid_t), np.cos(grid_t) * np.cos(grid_p))
    )
    fibre = upright(mi, mi.Vector3f(0.3 * cos_i, sin_i, math.sqrt(0.91) * cos_i))
    direction = fibre.direction(mi.Vector3f(wo.astype(np.float32)))
    yarn = preset_yarn(mi, preset, tau=tau, gaussian=gaussian)
    pdf = np.array(sampling.density(yarn, fibre, direction), np.float64)
    cell = (sines[1] - sines[0]) * 2 * np.pi / 256
    assert np.sum(pdf * np.cos(grid_t)) * cell == pytest.approx(1, abs=2e-3)


@pytest.mark.parametrize("preset", list(PRESETS))
@pytest.mark.parametrize("inclination", [0.0, 50.0, 85.0])
def test_no_yarn_returns_more_light_than_it_gets(mi: Any, preset: str, inclination: float) -> None:
    count, tilt = 1 << 16, math.radians(inclination)
    yarn = preset_yarn(mi, preset, tau=0.3, color=1.0)
    fibre = upright(mi, mi.Vector3f(0, math.sin(tilt), math.cos(tilt)))
    weight = weights(yarn, fibre, by_lobes, *numbers(mi, count))
    assert weight.mean() < 1.0 + 4 * weight.std() / np.sqrt(count)


@pytest.mark.parametrize("preset", list(PRESETS))
@pytest.mark.parametrize("gaussian", [False, True])
def test_samples_are_never_noisier_than_those_of_a_cosine(
    mi: Any, preset: str, gaussian: bool
) -> None:
    # Views all over a cylinder of yarn, dark, dyed and white, under an even sky.
    views, samples = 512, 256
    rng = np.random.default_rng(3)
    theta = np.arcsin(rng.uniform(-1, 1, views) * math.sqrt(1 - GRAZING_COSINE**2))
    phi = np.arcsin(rng.uniform(-1, 1, views))
    wi = np.stack((np.cos(theta) * np.sin(phi), np.sin(theta), np.cos(theta) * np.cos(phi)))
    color = np.repeat(rng.choice((0.03, 0.3, 0.8), views), samples).astype(np.float32)
    fibre = upright(mi, mi.Vector3f(np.repeat(wi.astype(np.float32), samples, axis=1)))
    yarn = preset_yarn(mi, preset, tau=0.1, color=mi.Float(color), gaussian=gaussian)
    uniform = numbers(mi, views * samples)
    ours, cosine = (
        weights(yarn, fibre, draw, *uniform).reshape(views, samples)
        for draw in (by_lobes, by_cosine)
    )
    np.testing.assert_allclose(ours.mean(), cosine.mean(), rtol=0.1)
    ratio = ours.var(axis=1).sum() / cosine.var(axis=1).sum()
    assert ratio < (1 / 3 if preset in FLAT else 1)


def numbers(mi: Any, count: int) -> tuple[Any, Any]:
    rng = mi.PCG32(size=count)
    return rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32())


def by_lobes(yarn: Any, fibre: Any, choice: Any, point: Any) -> tuple[Any, Any]:
    direction = sampling.sample(yarn, fibre, choice, point)
    return direction, sampling.density(yarn, fibre, direction)


def by_cosine(yarn: Any, fibre: Any, choice: Any, point: Any) -> tuple[Any, Any]:
    import drjit as dr
    import mitsuba as mi

    share = sampling.shares(yarn, fibre)
    across = share.cosine_across + share.volume_across
    w = mi.warp.square_to_cosine_hemisphere(point)
    other = choice < across
    wo = fibre.n * dr.select(other, -w.z, w.z) + fibre.b * w.x + fibre.t * w.y
    return fibre.direction(wo), w.z / np.pi * dr.select(other, across, 1 - across)


def weights(yarn: Any, fibre: Any, draw: Any, choice: Any, point: Any) -> Any:
    direction, pdf = draw(yarn, fibre, choice, point)
    value = np.array(lobes.value(yarn, fibre, direction), np.float64)[1]
    return value / np.maximum(np.array(pdf), 1e-20)


@pytest.mark.parametrize("gaussian", [False, True])
def test_the_scalar_variant_samples_the_same(mi: Any, gaussian: bool) -> None:
    c = cases(16)
    choice, point = numbers(mi, 16)
    wi, _, n, t, yarn = arguments(mi, c, gaussian=gaussian)
    fibre = lobes.fibre(wi, n, t)
    direction = sampling.sample(yarn, fibre, choice, point)
    expected = np.array(fibre.vector(direction)).T
    pdf = np.array(sampling.density(yarn, fibre, direction))
    choices, points = np.array(choice), np.array(point).T
    mi.set_variant("scalar_rgb")
    for k in range(16):
        one = lobes.LobeParameters(
            mi.Color3f(c["A"][k].tolist()), *(float(c[key][k]) for key in KEYS), gaussian=gaussian
        )
        wi, n, t = (mi.Vector3f(c[key][k].tolist()) for key in ("wi", "n", "t"))
        fibre = lobes.fibre(wi, n, t)
        direction = sampling.sample(one, fibre, float(choices[k]), mi.Point2f(points[k].tolist()))
        assert np.array(fibre.vector(direction)) == pytest.approx(expected[k], abs=1e-3)
        assert sampling.density(one, fibre, direction) == pytest.approx(pdf[k], rel=1e-2)
