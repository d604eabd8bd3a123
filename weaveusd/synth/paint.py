"""What color a texel has: tones along the yarn, plies of a mouliné, fibres of a mélange."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.synth.compiled import inlined, step
from weaveusd.synth.noise import MAX_SIGMAS, beside
from weaveusd.synth.piece import (
    PIECE,
    SIN_V,
    WARP_BLUE,
    WARP_GREEN,
    WARP_RED,
    WARP_TONE,
    WEFT,
    WEFT_TONE,
)
from weaveusd.synth.plan import TONE
from weaveusd.synth.strands import strand
from weaveusd.synth.tones import SLOTS, STEPS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.synth.plan import Threads
    from weaveusd.synth.tones import Tones

    Doubles = NDArray[np.float64]

BUNDLES, BUNDLE_MM = 12, 0.6
"""Bundles of fibres side by side on a mélange's face, and how long one stays on the surface."""

PER_SIGMA = (STEPS - 1) / (2.0 * MAX_SIGMAS)


@step
def paint(s, texels, weft_color, base_color):  # type: ignore[no-untyped-def]
    """Write the colors of a piece; those of gaps are the colors of the yarn beside them.

    `weft_color` (3,) is that of the pick, `base_color` (3 texels,) has the components of a texel
    side by side.
    """
    weft_red, weft_green, weft_blue = weft_color[0], weft_color[1], weft_color[2]
    for i in range(texels):
        on_weft = s[WEFT * PIECE + i] > 0.0
        tone, weft_tone = s[WARP_TONE * PIECE + i], s[WEFT_TONE * PIECE + i]
        red, green = s[WARP_RED * PIECE + i], s[WARP_GREEN * PIECE + i]
        blue, scale = s[WARP_BLUE * PIECE + i], weft_tone if on_weft else tone
        base_color[3 * i] = (weft_red if on_weft else red) * scale
        base_color[3 * i + 1] = (weft_green if on_weft else green) * scale
        base_color[3 * i + 2] = (weft_blue if on_weft else blue) * scale


@step
def mix(  # type: ignore[no-untyped-def]
    s, start, texels, j, columns, rows, warp, weft, by_row, by_column, width_mm, height_mm,
    tones, base_color,
):  # fmt: skip
    """Write the colors of those texels of row `j` whose yarn has several."""
    colors, thread, position = tones.colors, columns.thread, columns.position
    r, y_mm = rows.thread[j], rows.position[j]
    for i in range(texels):
        x, sin_v = start + i, s[SIN_V * PIECE + i]
        c = thread[x]
        on_weft = s[WEFT * PIECE + i] > 0.0
        yarn = weft.yarn[r] if on_weft else warp.yarn[c]
        if colors[yarn] == 1:
            continue
        if on_weft:
            color = _mixed(tones, weft, r, sin_v, position[x], width_mm)
            left, right, low, high = beside(weft.tone, by_column, TONE, x)
            g = low * left[r] + high * right[r]
        else:
            color = _mixed(tones, warp, c, sin_v, y_mm, height_mm)
            left, right, low, high = beside(warp.tone, by_row, TONE, j)
            g = low * left[c] + high * right[c]
        scale = shade(tones.scale[yarn, color], g)
        for n in range(3):
            base_color[3 * i + n] = tones.color[yarn, color, n] * scale


@inlined
def shade(scales: Doubles, deviation: float) -> float:
    """Return the scale of a color, so many standard deviations from its mean.

    `scales` (STEPS,) are those of its tones.
    """
    place = (min(max(deviation, -MAX_SIGMAS), MAX_SIGMAS) + MAX_SIGMAS) * PER_SIGMA
    low = min(int(place), STEPS - 2)
    scale: float = scales[low] + (place - low) * (scales[low + 1] - scales[low])
    return scale


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
