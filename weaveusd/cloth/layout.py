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
    """The threads of one system: cell borders, width and thickness in mm, and who bends how."""

    edge_mm: Doubles  # (threads + 1,)
    width_mm: Doubles  # (threads,)
    height_mm: Doubles  # (threads,)
    end_bend: Bools  # (threads,) True where the spine is straight but for its ends


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
    pitch for an end-bend. It is limited so that the surface's corners stay below
    `MAX_INCLINATION`: sin u_max ≤ 1 / (1 / sin(limit) + b / e).

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
    limit = 1 / (1 / math.sin(MAX_INCLINATION) + 0.5 * own.height_mm[thread] / bend)
    u_max = np.minimum(u_max, np.arcsin(limit))
    u_max = np.where(closed, 0.0, u_max)
    return Floats(thread, start, count, length, center, bend, u_max, at)


def crown_mm(own: System, crossing: System, crimp_share: float) -> Doubles:
    """Return the height (threads,) of each thread's crown over the cloth's middle plane.

    A thread that takes the share s of the crimp height swings by ± s/2 times the sum of both
    thicknesses; its surface is half its thickness higher.
    """
    swing = 0.5 * crimp_share * (own.height_mm + crossing.height_mm.mean())
    return np.asarray(swing + 0.5 * own.height_mm)
