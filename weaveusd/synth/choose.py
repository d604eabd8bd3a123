"""Which thread a texel sees, and where on that thread it lies."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from weaveusd.synth import plan
from weaveusd.synth.compiled import compiled, inlined
from weaveusd.synth.plan import THICKNESS, TWIST
from weaveusd.synth.surface import (
    ACROSS,
    ALONG,
    BASE,
    HALF_HEIGHT,
    HALF_WIDTH,
    INFINITE,
    PIECE,
    PSI,
    RADIUS,
    STRAIGHT,
    WEFT,
    WEFT_EDGE,
    WEFT_PSI,
    WEFT_SIZE,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from weaveusd.synth.noise import Blend

    Doubles = NDArray[np.float64]

FRINGE = 0.6
"""How far the hairs of a yarn reach beside it, in half widths."""

FAINTEST = 1 / 255
"""Hairs of less opacity are none: eight bits would hold a gap with a yarn in it."""


@compiled
def choose(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    start, texels, j, columns, rows, warp, weft, by_row, by_column,
    scratch, thread_of, float_of, opacity, yarn_id,
):  # fmt: skip
    """Choose the threads of `texels` texels of row `j`, from column `start` on.

    Fills the inputs of `surface.bend` in `scratch`, `thread_of` and `float_of` (-1 where no float
    is) of the piece, and the row's `opacity` and `yarn_id`. Returns whether a float has a conic
    spine and whether a yarn has plies.
    """
    column_thread, column_offset = columns.thread, columns.offset
    column_position, column_beside, cell_end = columns.position, columns.beside, columns.end
    warp_at, warp_floats, warp_hair, warp_yarns = warp.at, warp.floats, warp.hair, warp.yarn
    half_width, half_height, room = warp.half_width, warp.half_height, warp.room
    axis, sunk, psi, plies = warp.axis, warp.sunk, warp.psi, warp.plies
    thick, twist = warp.thick, warp.twist
    weft_at, weft_floats = weft.at, weft.floats

    r, off_y, y, beside_y = rows.thread[j], rows.offset[j], rows.position[j], rows.beside[j]
    weft_yarn, weft_hair, weft_half = weft.yarn[r], weft.hair[r], weft.half_height[r]
    weft_axis, weft_sunk = weft.axis[r], weft.sunk[r]
    follow(scratch, WEFT_SIZE, start, texels, 1.0, weft.thick[r], by_column, THICKNESS)
    follow(scratch, WEFT_PSI, start, texels, weft.psi[r], weft.twist[r], by_column, TWIST)
    widen(scratch, texels, weft.half_width[r], weft.room[r])
    thick_left, thick_right, thick_low, thick_high = _knots(by_row, THICKNESS, j)
    twist_left, twist_right, twist_low, twist_high = _knots(by_row, TWIST, j)

    conics, plied = False, weft.plies[r] > 0.0
    i = 0
    while i < texels:
        # What is the same for all texels of the end's cell.
        c = column_thread[start + i]
        stop = min(texels, cell_end[c] - start)
        size = 1.0 + (thick_low * thick[c, thick_left] + thick_high * thick[c, thick_right])
        warp_edge = min(half_width[c] * size, room[c])
        warp_psi = psi[c] + (twist_low * twist[c, twist_left] + twist_high * twist[c, twist_right])
        warp_half, warp_yarn = half_height[c] * size, warp_yarns[c]
        f, g = warp_at[r, c], weft_at[r, c]
        warp_on_top = f >= 0
        if not warp_on_top:
            f = warp_at[beside_y, c]
        warp_base, warp_along, straight, radius = sunk[c], 0.0, INFINITE, 1.0
        if f >= 0:
            warp_base, warp_along = axis[c], y - warp_floats[f, plan.MIDDLE]
            straight, radius = warp_floats[f, plan.STRAIGHT], warp_floats[f, plan.RADIUS]
            conics |= not math.isnan(warp_floats[f, plan.R_HAT])
        plied |= plies[c] > 0.0
        while i < stop:
            column = start + i
            off_x = column_offset[column]
            weft_edge = scratch[WEFT_EDGE * PIECE + i]
            on_warp, on_weft = abs(off_x) < warp_edge, abs(off_y) < weft_edge
            if on_warp and (warp_on_top or not on_weft):
                thread_of[i], float_of[i], is_weft = c, f, 0.0
                opacity[column, 0], yarn_id[column, 0] = 1.0, warp_yarn
                _lie(
                    scratch, i, off_x, warp_edge, warp_half, warp_psi,
                    warp_along, straight, radius, warp_base,
                )  # fmt: skip
            elif on_weft:
                h = g if g >= 0 else weft_at[r, column_beside[column]]
                thread_of[i], float_of[i], is_weft = r, h, 1.0
                opacity[column, 0], yarn_id[column, 0] = 1.0, weft_yarn
                half = weft_half * scratch[WEFT_SIZE * PIECE + i]
                weft_psi = scratch[WEFT_PSI * PIECE + i]
                if h >= 0:
                    conics |= not math.isnan(weft_floats[h, plan.R_HAT])
                    _lie(
                        scratch, i, -off_y, weft_edge, half, weft_psi,
                        column_position[column] - weft_floats[h, plan.MIDDLE],
                        weft_floats[h, plan.STRAIGHT], weft_floats[h, plan.RADIUS], weft_axis,
                    )  # fmt: skip
                else:
                    _lie(
                        scratch, i, -off_y, weft_edge, half, weft_psi,
                        0.0, INFINITE, 1.0, weft_sunk,
                    )  # fmt: skip
            else:
                of_warp = _fringe(warp_hair[c], abs(off_x), warp_edge)
                of_weft = _fringe(weft_hair, abs(off_y), weft_edge)
                alpha = 1.0 - (1.0 - of_warp) * (1.0 - of_weft)
                if alpha < FAINTEST:
                    alpha = 0.0
                is_weft = 1.0 if of_weft > of_warp else 0.0
                thread_of[i], float_of[i] = (r if of_weft > of_warp else c), -1
                yarn = weft_yarn if of_weft > of_warp else warp_yarn
                opacity[column, 0], yarn_id[column, 0] = alpha, (yarn if alpha > 0.0 else -1)
                # A flat surface without thickness, at the lower crown.
                low = min(sunk[c] + half_height[c], weft_sunk + weft_half)
                _lie(scratch, i, 0.0, 1.0, 0.0, 0.0, 0.0, INFINITE, 1.0, low)
            scratch[WEFT * PIECE + i] = is_weft
            i += 1
    return conics, plied


@compiled
def follow(  # type: ignore[no-untyped-def]
    scratch, field, start, texels, mean, knots, blend, kind
):
    """Fill a field with a pick's `mean` and its deviation; `knots` (knots,) are the pick's."""
    left, right = blend.left[kind], blend.right[kind]
    low, high = blend.left_weight[kind], blend.right_weight[kind]
    for i in range(texels):
        k = start + i
        scratch[field * PIECE + i] = mean + (low[k] * knots[left[k]] + high[k] * knots[right[k]])


@compiled
def widen(scratch: Doubles, texels: int, half_width: float, room: float) -> None:
    """Compute a pick's half width from its thickness; it stays within its `room`."""
    for i in range(texels):
        scratch[WEFT_EDGE * PIECE + i] = min(half_width * scratch[WEFT_SIZE * PIECE + i], room)


@inlined
def _knots(blend: Blend, kind: int, texel: int) -> Any:
    """Return the two knots beside a texel and their weights."""
    return (
        blend.left[kind, texel], blend.right[kind, texel],
        blend.left_weight[kind, texel], blend.right_weight[kind, texel],
    )  # fmt: skip


@inlined
def _lie(
    scratch: Doubles, i: int, across: float, half_width: float, half_height: float, psi: float,
    along: float, straight: float, radius: float, base: float,
) -> None:  # fmt: skip
    """Note where texel `i` lies on its yarn."""
    scratch[ACROSS * PIECE + i] = across
    scratch[HALF_WIDTH * PIECE + i] = half_width
    scratch[HALF_HEIGHT * PIECE + i] = half_height
    scratch[PSI * PIECE + i] = psi
    scratch[ALONG * PIECE + i] = along
    scratch[STRAIGHT * PIECE + i] = straight
    scratch[RADIUS * PIECE + i] = radius
    scratch[BASE * PIECE + i] = base


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
