"""Paths of light through a loaded scene, summed in an order that never changes.

Mitsuba's own film adds samples to pixels from many threads at once, so that the last bits of a
picture differ from run to run. Here the samples of a pixel lie side by side and one thread adds
them up. A pixel is the mean over its square.

Those samples are spread evenly, by correlated multi-jitter (Kensler 2013), over the pixel, the
lights and the lobes, wherever the work is a wavefront: what varies slowly is then found with few.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import drjit as dr
import mitsuba as mi
import numpy as np

from weaveusd.render.looking import look
from weaveusd.render.numbering import numbered

if TYPE_CHECKING:
    from numpy.typing import NDArray

SAMPLES_A_PASS = 1 << 23
"""Samples traced at once; memory grows with them."""

_NEXT_SEED = 0x9E3779B1


def trace(
    scene: Any,
    size: tuple[int, int],
    spp: int,
    seed: int,
    progress: Callable[[float], None] | None = None,
) -> NDArray[np.float32]:
    """Return the radiance (height, width, 3) seen by the scene's first sensor, read-only.

    `size` is (width, height). `progress` hears the share that is done after every pass.
    """
    if _is_jit():
        look(scene)
    # A scalar pass is walked pixel by pixel and takes no memory, but a sign of life is due.
    most = SAMPLES_A_PASS // (size[0] * size[1]) if _is_jit() else spp // 8
    most = max(1, min(most, spp))
    total = np.zeros((size[1], size[0], 3), np.float64)
    done, number = 0, 0
    while done < spp:
        now = _whole_grid(min(most, spp - done))
        pass_seed = (seed + number * _NEXT_SEED) % (1 << 32)
        if _is_jit():
            total += _wavefront(scene, size, now, pass_seed)
        else:
            total += np.asarray(mi.render(scene, spp=now, seed=pass_seed), np.float64) * now
        done, number = done + now, number + 1
        if progress is not None:
            progress(done / spp)
    image = (total / spp).astype(np.float32)
    image.flags.writeable = False
    return image


def _wavefront(scene: Any, size: tuple[int, int], spp: int, seed: int) -> NDArray[np.float64]:
    """Return the sums over `spp` samples of every pixel, all traced at once."""
    width, height = size
    count = width * height * spp
    sensor, integrator = scene.sensors()[0], scene.integrator()
    sampler = mi.load_dict({"type": "multijitter", "sample_count": spp})
    sampler.set_samples_per_wavefront(spp)
    # Multi-jitter hashes its seed weakly: pictures of neighboring seeds would be alike.
    sampler.seed(mi.sample_tea_32(seed, spp, 4)[0], count)

    index = dr.arange(mi.UInt32, count)
    pixel = index // spp
    corner = mi.Vector2f(mi.Float(pixel % width), mi.Float(pixel // width))
    position = (corner + sampler.next_2d()) / mi.Vector2f(width, height)
    aperture = sampler.next_2d() if sensor.needs_aperture_sample() else mi.Point2f(0.5)
    ray, weight = sensor.sample_ray(0.0, sampler.next_1d(), position, aperture)
    ray = numbered(mi.RayDifferential3f(ray), index % spp, pixel, seed)
    radiance, _, _ = integrator.sample(scene, sampler, ray)
    radiance = radiance * weight
    sums = [np.array(dr.block_sum(channel, spp), np.float64) for channel in _evaluated(radiance)]
    return np.stack(sums, axis=-1).reshape(height, width, 3)


def _whole_grid(samples: int) -> int:
    """Return the most samples, up to so many, that fill a grid nearly as high as wide."""
    rows = math.isqrt(samples)
    return samples // rows * rows


def _evaluated(radiance: Any) -> tuple[Any, Any, Any]:
    dr.eval(radiance)
    return radiance.x, radiance.y, radiance.z


def _is_jit() -> bool:
    return bool(dr.is_jit_v(mi.Float))
