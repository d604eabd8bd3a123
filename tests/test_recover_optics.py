"""Optics come back from a picture by gradient: the example, smaller."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

from weaveusd.errors import RendererUnavailableError
from weaveusd.render import variant

EXAMPLE = Path(__file__).parents[1] / "examples" / "recover_optics.py"


@pytest.fixture(scope="module")
def example():
    try:
        return runpy.run_path(str(EXAMPLE))
    except RendererUnavailableError as error:
        pytest.skip(str(error))


@pytest.fixture
def mi(example):
    import mitsuba

    mitsuba.set_variant(variant.LLVM)
    return mitsuba


def test_derivatives_are_those_of_finite_differences(mi, example):
    import drjit as dr

    swatch = example["Swatch"]("shot_silk", size=16, texels=24)
    target = swatch.target(spp=64)
    start = example["wrong_start"](swatch.truth)
    n_v = swatch.normalizations(start.gamma_s)
    at = np.concatenate([np.log(start.gamma_s), start.albedo.ravel()])

    def image(values):
        swatch.dress(*values, n_v)
        return swatch.image(spp=4096, seed=1)

    def split(values):
        return mi.Float(values[:2]), mi.Float(values[2:])

    other = dr.detach(image(split(at)))
    values = split(at)
    dr.enable_grad(values)
    dr.backward(example["loss"](image(values), other, target))
    slopes = np.concatenate([np.array(dr.grad(value)) for value in values])
    for k, slope in enumerate(slopes):
        step = np.zeros_like(at)
        step[k] = 0.02
        ends = [
            np.array(example["loss"](image(split(v)), other, target)).item()
            for v in (at + step, at - step)
        ]
        assert slope == pytest.approx((ends[0] - ends[1]) / 0.04, rel=0.05, abs=1e-3)


def test_steps_lead_towards_the_truth(mi, example):
    swatch = example["Swatch"]("linen", size=16, texels=24)
    start = example["wrong_start"](swatch.truth)
    steps = list(example["recover"](swatch, start, swatch.target(spp=32), steps=24, spp=4))
    before, after = np.abs([start.albedo, steps[-1][1].albedo] - swatch.truth.albedo).mean((1, 2))
    assert after < 0.35 * before
    assert steps[-1][0] < 0.1 * steps[0][0]


@pytest.mark.slow
def test_optics_are_recovered_from_a_picture(mi, example):
    swatch = example["Swatch"]("shot_silk", size=32, texels=48)
    truth, target = swatch.truth, swatch.target()
    start = example["wrong_start"](truth)
    *_, (_, found) = example["recover"](swatch, start, target, steps=200)
    np.testing.assert_allclose(found.gamma_s, truth.gamma_s, rtol=0.2)
    np.testing.assert_allclose(found.albedo, truth.albedo, atol=0.04)
