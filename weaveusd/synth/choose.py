"""Which thread a texel sees, and where on that thread it lies."""

from __future__ import annotations

import math

from weaveusd.synth.compiled import inlined, step
from weaveusd.synth.piece import (
    ACROSS,
    ALONG,
    BASE,
    HALF_HEIGHT,
    HALF_WIDTH,
    OFFSET,
    PIECE,
    PSI,
    RADIUS,
    STRAIGHT,
    TOP,
    WARP_BASE,
    WARP_CROWN,
    WARP_EDGE,
    WARP_HALF,
    WARP_MIDDLE,
    WARP_PSI,
    WARP_RADIUS,
    WARP_STRAIGHT,
    WARP_YARN,
    WEFT,
    WEFT_ALONG,
    WEFT_BASE,
    WEFT_EDGE,
    WEFT_HALF,
    WEFT_PSI,
    WEFT_RADIUS,
    WEFT_STRAIGHT,
)

INFINITE = math.inf

FRINGE = 0.6
"""How far the hairs of a yarn reach beside it, in half widths."""

FAINTEST = 1 / 255
"""Hairs of less opacity are none: eight bits would hold a gap with a yarn in it."""


@step
def choose(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    s, texels, y, off_y, weft_yarn, weft_crown, opacity, yarn_id
):
    """Choose between end, pick and gap, and write `opacity` and `yarn_id` (texels,).

    `y` is the row's place and `off_y` its distance from the axis of its pick, whose crown is at
    `weft_crown` while it is under; in mm. The end is seen where it is on top, or beside the
    pick; the pick where the end is not.
    """
    beside_pick, weft_id = abs(off_y), float(weft_yarn)
    for i in range(texels):
        offset = s[OFFSET * PIECE + i]
        warp_edge, weft_edge = s[WARP_EDGE * PIECE + i], s[WEFT_EDGE * PIECE + i]
        on_weft = beside_pick < weft_edge
        on_end = abs(offset) < warp_edge
        warp = on_end & ((s[TOP * PIECE + i] > 0.0) | (not on_weft))
        weft = on_weft & (not warp)
        warp_along = y - s[WARP_MIDDLE * PIECE + i]
        warp_half, weft_half = s[WARP_HALF * PIECE + i], s[WEFT_HALF * PIECE + i]
        warp_psi, weft_psi = s[WARP_PSI * PIECE + i], s[WEFT_PSI * PIECE + i]
        weft_along = s[WEFT_ALONG * PIECE + i]
        warp_straight, weft_straight = s[WARP_STRAIGHT * PIECE + i], s[WEFT_STRAIGHT * PIECE + i]
        warp_radius, weft_radius = s[WARP_RADIUS * PIECE + i], s[WEFT_RADIUS * PIECE + i]
        warp_base, weft_base = s[WARP_BASE * PIECE + i], s[WEFT_BASE * PIECE + i]
        warp_id = s[WARP_YARN * PIECE + i]
        low = min(s[WARP_CROWN * PIECE + i], weft_crown)
        # A gap is a flat surface without thickness, at the lower crown.
        s[WEFT * PIECE + i] = 1.0 if weft else 0.0
        s[ACROSS * PIECE + i] = offset if warp else (-off_y if weft else 0.0)
        s[HALF_WIDTH * PIECE + i] = warp_edge if warp else (weft_edge if weft else 1.0)
        s[HALF_HEIGHT * PIECE + i] = warp_half if warp else (weft_half if weft else 0.0)
        s[PSI * PIECE + i] = warp_psi if warp else (weft_psi if weft else 0.0)
        s[ALONG * PIECE + i] = warp_along if warp else (weft_along if weft else 0.0)
        s[STRAIGHT * PIECE + i] = warp_straight if warp else (weft_straight if weft else INFINITE)
        s[RADIUS * PIECE + i] = warp_radius if warp else (weft_radius if weft else 1.0)
        s[BASE * PIECE + i] = warp_base if warp else (weft_base if weft else low)
        opacity[i] = 1.0 if warp | weft else 0.0
        yarn_id[i] = warp_id if warp else (weft_id if weft else -1.0)


@step
def fill_gaps(  # type: ignore[no-untyped-def]
    s, texels, off_y, weft_yarn, weft_hair, thread, warp_hair, opacity, yarn_id
):
    """Fill the gaps of a piece with the loose hairs of the yarns beside them."""
    for i in range(texels):
        if s[HALF_HEIGHT * PIECE + i] > 0.0:
            continue
        hair = warp_hair[thread[i]]
        of_warp = _fringe(hair, abs(s[OFFSET * PIECE + i]), s[WARP_EDGE * PIECE + i])
        of_weft = _fringe(weft_hair, abs(off_y), s[WEFT_EDGE * PIECE + i])
        alpha = 1.0 - (1.0 - of_warp) * (1.0 - of_weft)
        if alpha < FAINTEST:
            alpha = 0.0
        yarn = float(weft_yarn) if of_weft > of_warp else s[WARP_YARN * PIECE + i]
        s[WEFT * PIECE + i] = 1.0 if of_weft > of_warp else 0.0
        opacity[i], yarn_id[i] = alpha, (yarn if alpha > 0.0 else -1.0)


@inlined
def _fringe(hairiness: float, distance: float, edge: float) -> float:
    """Return how much of the light loose hairs catch at a distance from a yarn's axis.

    As much as the hairiness at the yarn's edge, falling to nothing with the square of the
    distance over `FRINGE` half widths.
    """
    if hairiness <= 0.0:
        return 0.0
    free = 1.0 - (distance - edge) / (FRINGE * edge)
    return hairiness * free * free if free > 0.0 else 0.0
