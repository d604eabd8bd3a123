"""Which sample of which pixel a path is: told by the time of its ray.

A BSDF that draws what it is made of needs random numbers, and best such as lie evenly over the
samples of a pixel; Mitsuba gives the value of a BSDF none at all. Nothing moves while a picture of
ours is taken, so the time of a ray is free to say what a hit can tell by nothing else.

The numbers of a pixel's samples follow the additive recurrence whose steps are powers of the root
of x^(n+1) = x + 1, from an offset of the pixel's own: any run of it lies evenly in n dimensions.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

_BITS = 12
"""Bits for the sample, and for the offset of its pixel: single precision counts up to 2^24."""

_MASK = (1 << _BITS) - 1
_ODD = 0x9E3779B1


def numbered(ray: Any, sample: Any, pixel: Any, seed: int) -> Any:
    """Return `ray` as that of a sample, an index within its pixel, for `evenly` to know."""
    # Opaque, a seed leaves the kernel as it is.
    offset = mi.sample_tea_32(pixel, dr.opaque(mi.UInt32, seed), 4)[0] % _MASK + 1
    ray.time = mi.Float(((sample & _MASK) << _BITS) + offset)
    return ray


def evenly(time: Any, count: int) -> list[Any]:
    """Return `count` numbers in 0…1 of the ray with that time, of no use where it is 0."""
    code = mi.UInt32(time)
    sample, offset = code >> _BITS, code & _MASK
    found: list[Any] = []
    for number, step in enumerate(_steps(count)):
        begin = offset * ((2 * number + 1) * _ODD & 0xFFFFFFFF)
        found.append(mi.Float((sample * step + begin) >> 8) * 2.0**-24)
    return found


def _steps(count: int) -> list[int]:
    """Return the steps of the recurrence in so many dimensions, in units of 2^-32."""
    root = 1.5
    for _ in range(60):
        root = (1 + root) ** (1 / (count + 1))
    return [round(root ** -(k + 1) * 2**32) for k in range(count)]
