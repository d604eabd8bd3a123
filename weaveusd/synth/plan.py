"""A weave as flat tables that the texel kernel reads: cells, threads and floats."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.cloth.layout import corner_limit, swing_mm
from weaveusd.synth.noise import Blend, blends, settled, wander
from weaveusd.synth.spine import circle_radius, conic_parameters

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.cloth.model import Floats, Weave
    from weaveusd.yarn.model import Yarn

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int32]
    Places = NDArray[np.uint32]

GROOVE = 0.35
"""Depth of the groove between two plies, in half thicknesses of the yarn; n plies: 2/n of it."""

TWIST, THICKNESS, TONE, PHASE, BEND = range(5)
"""Streams of random numbers, apart from each other for every system and seed."""


# Numbers of a float lie side by side, as a texel needs them together.
(
    MIDDLE,  # its centre along the thread
    STRAIGHT,  # half length without bend; infinite where the thread never bends
    RADIUS,  # R₀ of a circle, scale of a conic
    R_HAT,  # shape of a conic, NaN of a circle
) = range(4)


class Threads(NamedTuple):
    """One system of threads; lengths in mm, heights over the cloth's highest crown."""

    center: Doubles  # (threads,)
    room: Doubles  # (threads,) half the pitch: no yarn is wider
    half_width: Doubles  # (threads,)
    half_height: Doubles  # (threads,)
    axis: Doubles  # (threads,) height of the yarn's axis at its crown, over the crossing system
    sunk: Doubles  # (threads,) height of the axis while the thread is under
    yarn: Indices  # (threads,)
    psi: Doubles  # (threads,) mean angle of the fibre to the axis, radians
    twist: Doubles  # (knots, threads) deviation of that angle along the thread, periodic
    thick: Doubles  # (knots, threads) relative deviation of width and thickness
    tone: Doubles  # (knots, threads) deviation of lightness in standard deviations
    plies: Doubles  # (threads,) plies, 0 for a single yarn
    turns: Doubles  # (threads,) strands that pass a point of the surface in the repeat, S positive
    phase: Doubles  # (threads,) strand at the beginning of the repeat
    groove: Doubles  # (threads,) depth of the groove between plies, mm
    hair: Doubles  # (threads,) hairiness 0…1
    at: Indices  # (picks, ends) float on top, -1 where the other system is
    floats: Doubles  # (F + 1, 4) MIDDLE, STRAIGHT, RADIUS and R_HAT; the last is no float
    conic: bool  # whether any float is a conic
    plied: bool  # whether any yarn has plies
    hairy: bool  # whether any yarn has hairs


class Cells(NamedTuple):
    """Where the texels of one axis lie among the threads that they cross."""

    position: Doubles  # (texels,) mm
    thread: Places  # (texels,) thread whose cell the texel is in
    offset: Doubles  # (texels,) distance from that thread's centre, mm
    beside: Places  # (texels,) the thread next to it on the texel's side


def lay_threads(weave: Weave, seed: int) -> tuple[Threads, Threads]:
    """Return warp and weft of `weave`, with the irregularities of `seed`."""
    warp_height, weft_height = weave.warp_height_mm, weave.weft_height_mm
    warp_swing = swing_mm(warp_height, weft_height, weave.crimp_balance)
    weft_swing = swing_mm(weft_height, warp_height, 1 - weave.crimp_balance)
    width, height = weave.repeat_mm
    warp = _threads(
        weave.warp_edge_mm, weave.warp_width_mm, warp_height, warp_swing,
        weave.warp_yarn, weave.warp_floats, weave.yarns, height, (seed, 0),
    )  # fmt: skip
    weft = _threads(
        weave.weft_edge_mm, weave.weft_width_mm, weft_height, weft_swing,
        weave.weft_yarn, weave.weft_floats, weave.yarns, width, (seed, 1),
    )  # fmt: skip
    top = max(_top(warp), _top(weft))
    return _lowered(warp, top), _lowered(weft, top)


def lay_cells(edge_mm: Doubles, texels: int) -> Cells:
    """Return where `texels` equal texels over the whole of `edge_mm` (threads + 1,) lie."""
    threads = len(edge_mm) - 1
    position = (np.arange(texels) + 0.5) * (edge_mm[-1] / texels)
    thread = np.clip(np.searchsorted(edge_mm, position, side="right") - 1, 0, threads - 1)
    center = 0.5 * (edge_mm[1:] + edge_mm[:-1])
    # A hair's breadth inwards: on the border of two yarns that touch there is no gap.
    offset = (position - center[thread]) * (1 - 1e-9)
    beside = (thread + np.where(offset < 0, -1, 1)) % threads
    return Cells(position, thread.astype(np.uint32), offset, beside.astype(np.uint32))


def lay_along(threads: Threads, texels: int) -> Blend:
    """Return how texels along `threads` blend the deviations `TWIST`, `THICKNESS` and `TONE`."""
    return blends([len(d) for d in (threads.twist, threads.thick, threads.tone)], texels)


def _top(threads: Threads) -> float:
    """Return the height of the highest crown over the cloth's middle plane."""
    # Blended knots a and b, weights of norm one, reach √(a² + b²) where both are positive.
    thick = np.maximum(threads.thick, 0)
    if len(thick) > 1:
        thick = np.sqrt(thick**2 + np.roll(thick, -1, 0) ** 2)
    return float((threads.axis + threads.half_height * (1 + thick.max(0))).max())


def _lowered(threads: Threads, top: float) -> Threads:
    return threads._replace(axis=threads.axis - top, sunk=threads.sunk - top)


def _threads(
    edge_mm: Doubles,
    width_mm: Doubles,
    height_mm: Doubles,
    swing_mm: Doubles,
    yarn: Indices,
    floats: Floats,
    yarns: tuple[Yarn, ...],
    length_mm: float,
    seed: tuple[int, int],
) -> Threads:
    half = 0.5 * height_mm
    irregular = [y.irregularity for y in yarns]
    plies = np.array([y.plies if y.plies > 1 else 0 for y in yarns], float)
    bend = np.array([i.bend for i in irregular])[yarn][floats.thread]
    spines = _spines(floats, half, yarn, yarns, bend, (*seed, BEND))
    return Threads(
        center=0.5 * (edge_mm[1:] + edge_mm[:-1]),
        room=0.5 * np.diff(edge_mm),
        half_width=0.5 * width_mm,
        half_height=half,
        axis=swing_mm,
        sunk=-swing_mm,
        yarn=yarn,
        psi=settled([y.twist_angle for y in yarns])[yarn],
        twist=np.clip(
            wander([y.twist_deviation for y in yarns], [y.twist_correlation_mm for y in yarns],
                   yarn, length_mm, (*seed, TWIST)), -1, 1),
        thick=np.clip(
            wander([i.thickness for i in irregular],
                   [i.thickness_correlation_mm for i in irregular],
                   yarn, length_mm, (*seed, THICKNESS)), -0.6, 0.6),
        tone=wander([float(i.color > 0) for i in irregular],
                    [i.color_correlation_mm for i in irregular],
                    yarn, length_mm, (*seed, TONE)),
        plies=plies[yarn],
        turns=np.array([_turns(y, length_mm) for y in yarns])[yarn],
        phase=np.random.Generator(np.random.PCG64((*seed, PHASE))).random(len(yarn)),
        groove=np.where(plies > 0, 2 * GROOVE / np.maximum(plies, 1), 0)[yarn] * half,
        hair=np.array([i.hairiness for i in irregular])[yarn],
        at=floats.at,
        floats=spines,
        conic=not np.isnan(spines[:, R_HAT]).all(),
        plied=bool((plies > 0).any()),
        hairy=any(i.hairiness > 0 for i in irregular),
    )  # fmt: skip


def _turns(yarn: Yarn, length_mm: float) -> float:
    """Return plies times turns in the repeat, whole, so that the strands meet at its border."""
    if yarn.plies < 2:
        return 0.0
    strands = yarn.plies * round(yarn.twist_per_m / 1000 * length_mm)
    return float(strands if yarn.twist_direction == "S" else -strands)


def _spines(
    floats: Floats,
    half: Doubles,
    yarn: Indices,
    yarns: tuple[Yarn, ...],
    deviation: Doubles,
    seed: tuple[int, ...],
) -> Doubles:
    """Return the numbers (F + 1, 4) of each float's spine, and last of a thread without float."""
    count = len(floats.thread)
    noise = settled(np.random.Generator(np.random.PCG64(seed)).standard_normal(count))
    b = half[floats.thread]
    u_max = settled(floats.u_max) * np.clip(1 + deviation * np.clip(noise, -3, 3), 0.05, 2)
    u_max = np.minimum(u_max, settled(corner_limit(b, floats.bend_mm)))
    straight = np.full(count, np.inf)
    radius, r_hat = np.ones(count), np.full(count, np.nan)
    bent = u_max > 0
    straight[bent] = 0.5 * floats.length_mm[bent] - floats.bend_mm[bent]
    radius[bent] = circle_radius(floats.bend_mm[bent], u_max[bent], b[bent])
    is_conic = np.array([y.spine == "conic" for y in yarns])[yarn][floats.thread] & bent
    for i in np.flatnonzero(is_conic):
        kappa = yarns[yarn[floats.thread[i]]].kappa
        length, u = float(floats.length_mm[i]), float(u_max[i])
        straight[i] = 0.0
        r_hat[i], radius[i] = conic_parameters(length, u, float(b[i]), kappa)
    spines = np.stack([floats.center_mm, straight, radius, r_hat], axis=1)
    return np.concatenate([spines, [(0.0, np.inf, 1.0, np.nan)]])
