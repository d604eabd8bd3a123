"""What color a texel has: tones along the yarn, plies of a mouliné, fibres of a mélange."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.synth.compiled import compiled, inlined
from weaveusd.synth.noise import MAX_SIGMAS
from weaveusd.synth.plan import TONE
from weaveusd.synth.strands import strand
from weaveusd.synth.surface import PIECE, SIN_V, WEFT
from weaveusd.synth.tones import SLOTS, STEPS

if TYPE_CHECKING:
    from weaveusd.synth.plan import Threads
    from weaveusd.synth.tones import Tones

BUNDLES, BUNDLE_MM = 12, 0.6
"""Bundles of fibres side by side on a mélange's face, and how long one stays on the surface."""

PER_SIGMA = (STEPS - 1) / (2.0 * MAX_SIGMAS)


@compiled
def paint(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    scratch, texels, start, j, columns, y_mm, warp, weft, by_row, by_column,
    width_mm, height_mm, thread_of, tones, base_color,
):  # fmt: skip
    """Write the colors of a piece; those of gaps are the colors of the yarn beside them."""
    table, colors, varies = tones.table, tones.colors, tones.varies
    warp_yarn, weft_yarn, warp_tone, weft_tone = warp.yarn, weft.yarn, warp.tone, weft.tone
    left, right = by_column.left[TONE], by_column.right[TONE]
    low_weight, high_weight = by_column.left_weight[TONE], by_column.right_weight[TONE]
    row_left, row_right = by_row.left[TONE, j], by_row.right[TONE, j]
    row_low, row_high = by_row.left_weight[TONE, j], by_row.right_weight[TONE, j]
    position = columns.position
    for i in range(texels):
        k, x, color = thread_of[i], start + i, 0
        on_weft = scratch[WEFT * PIECE + i] > 0.0
        yarn = weft_yarn[k] if on_weft else warp_yarn[k]
        if colors[yarn] > 1:
            sin_v = scratch[SIN_V * PIECE + i]
            if on_weft:
                color = _mixed(tones, weft, k, sin_v, position[x], width_mm)
            else:
                color = _mixed(tones, warp, k, sin_v, y_mm, height_mm)
        if not varies[yarn]:
            for n in range(3):
                base_color[x, n] = table[yarn, color, 0, n]
            continue
        if on_weft:
            g = low_weight[x] * weft_tone[k, left[x]] + high_weight[x] * weft_tone[k, right[x]]
        else:
            g = row_low * warp_tone[k, row_left] + row_high * warp_tone[k, row_right]
        place = (min(max(g, -MAX_SIGMAS), MAX_SIGMAS) + MAX_SIGMAS) * PER_SIGMA
        low = min(int(place), STEPS - 2)
        share = place - low
        for n in range(3):
            here = table[yarn, color, low, n]
            base_color[x, n] = here + share * (table[yarn, color, low + 1, n] - here)


@inlined
def _mixed(
    tones: Tones, threads: Threads, k: int, sin_v: float, along: float, repeat: float
) -> Any:
    """Return which of its colors thread `k` shows at a section angle v and a place along it."""
    yarn, s = threads.yarn[k], along / repeat
    if tones.by_ply[yarn]:
        p = strand(threads.plies[k], threads.turns[k], threads.phase[k], sin_v, s)
        return math.floor(p) % tones.colors[yarn]
    return tones.slots[yarn, _bundle(threads, k, sin_v, s, repeat)]


@inlined
def _bundle(threads: Threads, k: int, sin_v: float, s: float, repeat: float) -> Any:
    """Return the slot of the bundle of fibres at a place of thread `k`.

    Bundles lie side by side, lean with the twist, begin and end along the yarn, each at its own
    place; which one lies where is a hash of thread, place and the thread's random phase.
    """
    across = math.floor((sin_v + 1.0) * 0.5 * BUNDLES)
    seed = np.uint64(int(threads.phase[k] * 4294967296.0)) + np.uint64(across * 7919)
    start = _hash(seed)
    shift = float(start >> np.uint64(40)) / 16777216.0
    pieces = max(1, int(repeat / BUNDLE_MM))
    piece = math.floor((s + shift) * pieces) % pieces
    return int(_hash(seed + np.uint64((piece + 1) * 104729)) % np.uint64(SLOTS))


@inlined
def _hash(value: np.uint64) -> Any:
    """Return 64 well mixed bits of 64 bits (the finalizer of splitmix64)."""
    value = (value ^ (value >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    value = (value ^ (value >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return value ^ (value >> np.uint64(31))
