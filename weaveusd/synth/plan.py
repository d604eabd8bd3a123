"""A weave as flat tables that the texel kernel reads: cells, threads and floats."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.synth.spine import CIRCLE, CONIC, circle_radius, conic_parameters
from weaveusd.synth.twist import twist_wander

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.cloth.model import Floats, Weave
    from weaveusd.yarn.model import Yarn

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int32]


class Threads(NamedTuple):
    """One system of threads; lengths in mm, heights over the cloth's highest crown."""

    center: Doubles  # (threads,)
    half_width: Doubles  # (threads,)
    half_height: Doubles  # (threads,)
    crown: Doubles  # (threads,) height of the crown, over the crossing system
    sunk: Doubles  # (threads,) height of the surface while the thread is under
    yarn: Indices  # (threads,)
    psi: Doubles  # (threads,) mean angle of the fibre to the axis, radians
    wander: Doubles  # (threads, knots) its deviation along the thread, periodic
    at: Indices  # (picks, ends) float on top, -1 where the other system is
    middle: Doubles  # (F,) centre of each float along its thread
    straight: Doubles  # (F,) half length without bend; infinite where the thread never bends
    kind: Indices  # (F,) spine.CIRCLE or spine.CONIC
    radius: Doubles  # (F,) R₀ of a circle, scale of a conic
    r_hat: Doubles  # (F,) shape of a conic


class Cells(NamedTuple):
    """Where the texels of one axis lie among the threads that they cross."""

    position: Doubles  # (texels,) mm
    thread: Indices  # (texels,) thread whose cell the texel is in
    offset: Doubles  # (texels,) distance from that thread's centre, mm
    beside: Indices  # (texels,) the thread next to it on the texel's side


def lay_threads(weave: Weave, seed: int) -> tuple[Threads, Threads]:
    """Return warp and weft of `weave`, with twist noise of `seed`."""
    warp_swing, weft_swing = _swing(weave)
    warp_crown = warp_swing + 0.5 * weave.warp_height_mm
    weft_crown = weft_swing + 0.5 * weave.weft_height_mm
    top = max(float(warp_crown.max()), float(weft_crown.max()))
    width, height = weave.repeat_mm
    yarns = weave.yarns
    warp = _threads(
        weave.warp_edge_mm, weave.warp_width_mm, weave.warp_height_mm, warp_swing,
        weave.warp_yarn, weave.warp_floats, yarns, height, top, (seed, 0),
    )  # fmt: skip
    weft = _threads(
        weave.weft_edge_mm, weave.weft_width_mm, weave.weft_height_mm, weft_swing,
        weave.weft_yarn, weave.weft_floats, yarns, width, top, (seed, 1),
    )  # fmt: skip
    return warp, weft


def lay_cells(edge_mm: Doubles, texels: int) -> Cells:
    """Return where `texels` equal texels over the whole of `edge_mm` (threads + 1,) lie."""
    threads = len(edge_mm) - 1
    position = (np.arange(texels) + 0.5) * (edge_mm[-1] / texels)
    thread = np.clip(np.searchsorted(edge_mm, position, side="right") - 1, 0, threads - 1)
    center = 0.5 * (edge_mm[1:] + edge_mm[:-1])
    offset = position - center[thread]
    beside = (thread + np.where(offset < 0, -1, 1)) % threads
    return Cells(position, thread.astype(np.int32), offset, beside.astype(np.int32))


def _swing(weave: Weave) -> tuple[Doubles, Doubles]:
    """Return how far the axes of ends and picks leave the cloth's middle plane, in mm."""
    warp, weft = weave.warp_height_mm, weave.weft_height_mm
    return (
        0.5 * weave.crimp_balance * (warp + weft.mean()),
        0.5 * (1 - weave.crimp_balance) * (weft + warp.mean()),
    )


def _threads(
    edge_mm: Doubles,
    width_mm: Doubles,
    height_mm: Doubles,
    swing_mm: Doubles,
    yarn: Indices,
    floats: Floats,
    yarns: tuple[Yarn, ...],
    length_mm: float,
    top_mm: float,
    seed: tuple[int, int],
) -> Threads:
    half = 0.5 * height_mm
    count = len(floats.thread)
    straight = np.full(count, np.inf)
    kind = np.full(count, CIRCLE, np.int32)
    radius, r_hat = np.ones(count), np.zeros(count)
    shape: dict[tuple[float, ...], tuple[float, float]] = {}
    for i in np.flatnonzero(floats.u_max > 0):
        of = yarns[yarn[floats.thread[i]]]
        b, u_max = float(half[floats.thread[i]]), float(floats.u_max[i])
        length, bend = float(floats.length_mm[i]), float(floats.bend_mm[i])
        if of.spine == "conic":
            key = (length, u_max, b, of.kappa)
            if key not in shape:
                shape[key] = conic_parameters(*key)
            kind[i], straight[i] = CONIC, 0.0
            r_hat[i], radius[i] = shape[key]
        else:
            straight[i], radius[i] = 0.5 * length - bend, circle_radius(bend, u_max, b)
    return Threads(
        center=0.5 * (edge_mm[1:] + edge_mm[:-1]),
        half_width=0.5 * width_mm,
        half_height=half,
        crown=swing_mm + half - top_mm,
        sunk=half - swing_mm - top_mm,
        yarn=yarn,
        psi=np.array([y.twist_angle for y in yarns])[yarn],
        wander=twist_wander(yarns, yarn, length_mm, seed),
        at=floats.at,
        middle=floats.center_mm,
        straight=straight,
        kind=kind,
        radius=radius,
        r_hat=r_hat,
    )
