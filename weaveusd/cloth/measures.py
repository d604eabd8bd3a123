"""The figures of a cloth that a mill would quote, from its weave."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from weaveusd.cloth.model import Doubles, Floats, Indices, Weave


def warp_cover(weave: Weave) -> float:
    """Return the share of the area under warp yarn, 0…1: yarn width over pitch."""
    return min(1.0, float(weave.warp_width_mm.sum()) / weave.repeat_mm[0])


def weft_cover(weave: Weave) -> float:
    """Return the share of the area under weft yarn, 0…1: yarn width over pitch."""
    return min(1.0, float(weave.weft_width_mm.sum()) / weave.repeat_mm[1])


def thickness_mm(weave: Weave) -> float:
    """Return the thickness of the cloth, from the crowns of one face to those of the other.

    Threads touch where they cross, so the crimp heights of both systems add up to the sum D of
    their thicknesses, and the warp takes `crimp_balance` of it. The cloth is as thick as the
    system that rises more: max(h + t) over both (Peirce 1937).
    """
    warp, weft = float(weave.warp_height_mm.max()), float(weave.weft_height_mm.max())
    rise = weave.crimp_balance * (warp + weft)
    return max(rise + warp, (warp + weft - rise) + weft)


def crimps(weave: Weave) -> tuple[float, ...]:
    """Return the crimp of each yarn of the cloth: arc length over chord, less one.

    A bent piece of projected length s that turns to the inclination u on both sides has the
    excess length ``s (u / sin u - 1)``, exact for a circle. A thread bends on the back as often
    as on the face, so its excess is twice that of its floats on the face. A yarn's crimp is
    the mean over its threads; one that its recipe states stands as stated.
    """
    width, height = weave.repeat_mm
    warp = _thread_crimps(weave, weave.warp_floats, weave.warp_yarn, height)
    weft = _thread_crimps(weave, weave.weft_floats, weave.weft_yarn, width)
    result = []
    for index, of in enumerate(weave.yarns):
        if of.crimp is not None:
            result.append(of.crimp)
            continue
        threads = np.concatenate([warp[weave.warp_yarn == index], weft[weave.weft_yarn == index]])
        result.append(float(threads.mean()) if threads.size else 0.0)
    return tuple(result)


def areal_density_g_m2(weave: Weave) -> float:
    """Return the weight of the cloth: the linear density of all threads, crimp included."""
    width, height = weave.repeat_mm
    crimp = crimps(weave)
    grams_per_m = [yarn.tex * 1e-3 * (1 + c) for yarn, c in zip(weave.yarns, crimp, strict=True)]
    warp = math.fsum(grams_per_m[i] for i in weave.warp_yarn) * height
    weft = math.fsum(grams_per_m[i] for i in weave.weft_yarn) * width
    return (warp + weft) * 1e3 / (width * height)


def _thread_crimps(weave: Weave, floats: Floats, yarn: Indices, repeat_mm: float) -> Doubles:
    bent_ends = np.array([y.spine == "end-bend" for y in weave.yarns])[yarn][floats.thread]
    bent_mm = np.where(bent_ends, 2 * floats.bend_mm, floats.length_mm)
    # np.sinc(x) is sin(πx)/(πx), and one at 0.
    excess = bent_mm * (1 / np.sinc(floats.u_max / np.pi) - 1)
    total = np.bincount(floats.thread, weights=excess, minlength=len(yarn))
    crimp: Doubles = 2 * total / repeat_mm
    return crimp
