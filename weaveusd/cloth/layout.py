"""Where threads lie and how floats bend, in millimetres."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.cloth.floats import cyclic_runs
from weaveusd.cloth.model import Floats

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bools = NDArray[np.bool_]
    Doubles = NDArray[np.float64]

MAX_INCLINATION = math.pi / 2 - 0.02
"""No point of a yarn's surface is steeper along the yarn than this (physics.md C)."""


@dataclass(frozen=True, slots=True, eq=False)
class System:
    """The threads of one system: cell borders, width and thickness in mm, and who bends how.

    `crimp` and `u_max` are what recipes state; NaN, or None for all threads, where they follow
    from the threads that touch.
    """

    edge_mm: Doubles  # (threads + 1,)
    width_mm: Doubles  # (threads,)
    height_mm: Doubles  # (threads,)
    end_bend: Bools  # (threads,) True where the spine is straight but for its ends
    crimp: Doubles | None = None  # (threads,) arc length over chord, less one
    u_max: Doubles | None = None  # (threads,) inclination at the ends of floats, radians


def edges(pitch_mm: Doubles) -> Doubles:
    """Return the borders (n + 1,) of cells that are `pitch_mm` (n,) wide, from 0 on."""
    return np.concatenate([[0.0], np.cumsum(pitch_mm)])


def lay_floats(on_top: Bools, own: System, crossing: System, crimp_share: float) -> Floats:
    """Return the floats of a system, with their place and bend (physics.md B and C).

    `on_top` (threads, crossings) is True where the system is on top; `own` and `crossing` are
    its threads and those that cross it. A float's length is the sum of the cells it covers and
    half the gap of the cell at either end. `crimp_share` is the part of the crimp height
    thickness + thickness that this system takes; the inclination at the ends follows from it as
    u_max = 2 atan(h / e₂), e₂ the float's length for a circular spine and at most one crossing
    pitch for an end-bend. Where a thread's crimp is stated, all its floats bend by the angle that
    gives it; a stated inclination comes before both. It is limited so that the surface's corners
    stay below `MAX_INCLINATION` (`corner_limit`).

    `at` comes back as (threads, crossings).
    """
    thread, start, count, at = cyclic_runs(on_top)
    crossings = on_top.shape[1]
    pitch = np.diff(crossing.edge_mm)
    repeat = crossing.edge_mm[-1]
    before, after = (start - 1) % crossings, (start + count) % crossings
    gap_before = 0.5 * (pitch - crossing.width_mm)[before]
    gap_after = 0.5 * (pitch - crossing.width_mm)[after]
    first = crossing.edge_mm[start]
    stop = start + count
    covered = crossing.edge_mm[stop % crossings] + repeat * (stop // crossings) - first
    length = covered + gap_before + gap_after
    center = first - gap_before + 0.5 * length
    closed = count == crossings
    length = np.where(closed, repeat, length)
    center = np.where(closed, 0.5 * repeat, center)

    end_bend = own.end_bend[thread]
    mean_pitch = repeat / crossings
    bend = np.where(end_bend, np.minimum(mean_pitch, 0.5 * length), 0.5 * length)
    height = crimp_share * (own.height_mm[thread] + crossing.height_mm.mean())
    reach = np.where(end_bend, np.minimum(mean_pitch, length), length)
    u_max = 2 * np.arctan(height / np.maximum(reach, 1e-9))
    if own.crimp is not None:
        bent = np.where(end_bend, 2 * bend, length) * ~closed
        total = np.zeros(len(own.height_mm))
        np.add.at(total, thread, bent)
        of_crimp = crimp_inclination(own.crimp, total, repeat)[thread]
        u_max = np.where(np.isnan(of_crimp), u_max, of_crimp)
    if own.u_max is not None:
        u_max = np.where(np.isnan(own.u_max[thread]), u_max, own.u_max[thread])
    u_max = np.minimum(u_max, corner_limit(0.5 * own.height_mm[thread], bend))
    u_max = np.where(closed, 0.0, u_max)
    return Floats(thread, start, count, length, center, bend, u_max, at)


def crimp_inclination(crimp: Doubles, bent_mm: Doubles, repeat_mm: float) -> Doubles:
    """Return the inclination (threads,) in radians that gives threads their `crimp`.

    A thread of chord `repeat_mm` whose floats on the face bend over `bent_mm` in all, and as
    much on the back, has the crimp ``2 (bent / repeat) (u / sin u - 1)``: circular arcs. It is
    solved for u in 0…π/2 by bisection. NaN where the crimp is NaN or nothing bends.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(bent_mm > 0, 1 + crimp * repeat_mm / (2 * bent_mm), np.nan)
    low, high = np.zeros(len(crimp)), np.full(len(crimp), 0.5 * math.pi)
    for _ in range(60):
        middle = 0.5 * (low + high)
        # np.sinc(x) is sin(πx)/(πx), and one at 0.
        below = 1 / np.sinc(middle / np.pi) < ratio
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return np.where(np.isnan(ratio), np.nan, 0.5 * (low + high))


def corner_limit(half_height_mm: Doubles, bend_mm: Doubles) -> Doubles:
    """Return the largest inclination (F,) at which no corner exceeds `MAX_INCLINATION`.

    The corner of a float, at its end and its side, is steeper than its crown:
    sin u_max ≤ 1 / (1 / sin(limit) + b / e) for the half thickness b and the bend's length e.
    """
    return np.asarray(np.arcsin(1 / (1 / math.sin(MAX_INCLINATION) + half_height_mm / bend_mm)))


def swing_mm(height_mm: Doubles, crossing_height_mm: Doubles, crimp_share: float) -> Doubles:
    """Return how far the axis of each thread (threads,) leaves the cloth's middle plane.

    Threads touch where they cross, so that both systems together swing by their thicknesses; a
    system that takes the share s of that swings by ± s/2 of it.
    """
    return np.asarray(0.5 * crimp_share * (height_mm + crossing_height_mm.mean()))
