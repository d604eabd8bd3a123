"""The number of a sample, told by the time of its ray."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

PIXELS, SAMPLES = 5, 64


def drawn(seed: int, count: int = 6) -> Any:
    """Numbers (count, pixels, samples) of the rays of a few pixels."""
    import drjit as dr
    import mitsuba as mi

    from weaveusd.render.numbering import evenly, numbered

    index = dr.arange(mi.UInt32, PIXELS * SAMPLES)
    ray = numbered(SimpleNamespace(time=None), index % SAMPLES, index // SAMPLES, seed)
    return np.array([np.array(n) for n in evenly(ray.time, count)]).reshape(count, PIXELS, SAMPLES)


def test_the_numbers_of_a_pixel_lie_evenly_in_every_dimension(mi: Any) -> None:
    places = np.sort(drawn(3), axis=-1)
    assert places.min() >= 0
    assert places.max() < 1
    even = (np.arange(SAMPLES) + 0.5) / SAMPLES
    assert np.abs(places - even).max() < 5 / SAMPLES  # of random ones about 10 / SAMPLES


def test_pixels_and_seeds_have_numbers_of_their_own(mi: Any) -> None:
    found, other = drawn(3), drawn(4)
    assert np.abs(found[:, 0, 0] - found[:, 1, 0]).min() > 1e-4
    assert np.abs(found - other).max() > 0.1
    np.testing.assert_array_equal(found, drawn(3))


@pytest.mark.parametrize("samples", [4096, 70000])
def test_a_ray_of_any_sample_is_told_from_one_that_has_no_number(mi: Any, samples: int) -> None:
    import drjit as dr

    from weaveusd.render.numbering import evenly, numbered

    ray = numbered(SimpleNamespace(time=None), dr.arange(mi.UInt32, samples), mi.UInt32(7), 1)
    assert np.array(ray.time).min() > 0
    found = np.array(evenly(ray.time, 1)[0])
    assert found.mean() == pytest.approx(0.5, abs=0.01)
