"""What the texels of a piece have in common: the numbers of the ends and picks that cross there."""

from __future__ import annotations

from weaveusd.synth.compiled import step
from weaveusd.synth.noise import beside
from weaveusd.synth.paint import shade
from weaveusd.synth.piece import (
    OFFSET,
    PIECE,
    TOP,
    WARP_BASE,
    WARP_BLUE,
    WARP_CROWN,
    WARP_EDGE,
    WARP_GREEN,
    WARP_GROOVE,
    WARP_HALF,
    WARP_MIDDLE,
    WARP_PHASE,
    WARP_PLIES,
    WARP_PSI,
    WARP_R_HAT,
    WARP_RADIUS,
    WARP_RED,
    WARP_STRAIGHT,
    WARP_TONE,
    WARP_TURNS,
    WARP_YARN,
    WEFT_ALONG,
    WEFT_BASE,
    WEFT_EDGE,
    WEFT_HALF,
    WEFT_PSI,
    WEFT_R_HAT,
    WEFT_RADIUS,
    WEFT_STRAIGHT,
    WEFT_TONE,
)
from weaveusd.synth.plan import MIDDLE, R_HAT, RADIUS, STRAIGHT, THICKNESS, TONE, TWIST


@step
def lay_columns(s, texels, thread, offset, warp, tones):  # type: ignore[no-untyped-def]
    """Lay out what the ends `thread` (texels,) are in all rows."""
    for i in range(texels):
        c = thread[i]
        yarn = warp.yarn[c]
        s[OFFSET * PIECE + i], s[WARP_YARN * PIECE + i] = offset[i], yarn
        s[WARP_RED * PIECE + i] = tones.color[yarn, 0, 0]
        s[WARP_GREEN * PIECE + i] = tones.color[yarn, 0, 1]
        s[WARP_BLUE * PIECE + i] = tones.color[yarn, 0, 2]
        s[WARP_CROWN * PIECE + i] = warp.sunk[c] + warp.half_height[c]
        s[WARP_PLIES * PIECE + i], s[WARP_TURNS * PIECE + i] = warp.plies[c], warp.turns[c]
        s[WARP_PHASE * PIECE + i], s[WARP_GROOVE * PIECE + i] = warp.phase[c], warp.groove[c]


@step
def lay_ends(s, texels, j, thread, warp, by_row, tones):  # type: ignore[no-untyped-def]
    """Lay out size, fibre and color of the ends `thread` (texels,) in row `j`."""
    half_width, half_height, room, psi = warp.half_width, warp.half_height, warp.room, warp.psi
    thick_left, thick_right, thick_low, thick_high = beside(warp.thick, by_row, THICKNESS, j)
    twist_left, twist_right, twist_low, twist_high = beside(warp.twist, by_row, TWIST, j)
    tone_left, tone_right, tone_low, tone_high = beside(warp.tone, by_row, TONE, j)
    yarns, scales = warp.yarn, tones.scale
    edge, half, angle, scale = 0.0, 0.0, 0.0, 0.0
    before = -1
    for i in range(texels):
        c = thread[i]
        if c != before:
            before = c
            size = 1.0 + (thick_low * thick_left[c] + thick_high * thick_right[c])
            edge, half = min(half_width[c] * size, room[c]), half_height[c] * size
            angle = psi[c] + (twist_low * twist_left[c] + twist_high * twist_right[c])
            scale = shade(scales[yarns[c], 0], tone_low * tone_left[c] + tone_high * tone_right[c])
        s[WARP_EDGE * PIECE + i], s[WARP_HALF * PIECE + i] = edge, half
        s[WARP_PSI * PIECE + i], s[WARP_TONE * PIECE + i] = angle, scale


@step
def lay_crossings(  # type: ignore[no-untyped-def]
    s, texels, r, pick_beside, thread, end_beside, position, warp, weft, conic
):
    """Lay out the floats of the ends `thread` (texels,) and of pick `r` where they cross.

    Between two crossings a thread that is under belongs to the float that it has at the end or
    pick beside, on the texel's side.
    """
    warp_beside, warp_at, warp_floats = warp.at[pick_beside], warp.at[r], warp.floats
    weft_at, weft_floats = weft.at[r], weft.floats
    axis, sunk, weft_axis, weft_sunk = warp.axis, warp.sunk, weft.axis[r], weft.sunk[r]
    for i in range(texels):
        c = thread[i]
        f, under, g, h = warp_at[c], warp_beside[c], weft_at[c], weft_at[end_beside[i]]
        s[TOP * PIECE + i] = 1.0 if f >= 0 else 0.0
        f, h = f if f >= 0 else under, g if g >= 0 else h
        low, high = sunk[c], axis[c]
        # Float -1 is the last one of the table: it stands for a thread that lies under all.
        s[WARP_MIDDLE * PIECE + i] = warp_floats[f, MIDDLE]
        s[WARP_STRAIGHT * PIECE + i] = warp_floats[f, STRAIGHT]
        s[WARP_RADIUS * PIECE + i] = warp_floats[f, RADIUS]
        s[WARP_BASE * PIECE + i] = high if f >= 0 else low
        s[WEFT_ALONG * PIECE + i] = position[i] - weft_floats[h, MIDDLE]
        s[WEFT_STRAIGHT * PIECE + i] = weft_floats[h, STRAIGHT]
        s[WEFT_RADIUS * PIECE + i] = weft_floats[h, RADIUS]
        s[WEFT_BASE * PIECE + i] = weft_axis if h >= 0 else weft_sunk
        if conic:
            s[WARP_R_HAT * PIECE + i] = warp_floats[f, R_HAT]
            s[WEFT_R_HAT * PIECE + i] = weft_floats[h, R_HAT]


@step
def lay_pick(s, start, texels, r, weft, by_column, tones):  # type: ignore[no-untyped-def]
    """Lay out size, fibre and color of pick `r` at `texels` texels from column `start` on."""
    half_width, half_height, room = weft.half_width[r], weft.half_height[r], weft.room[r]
    psi, scales = weft.psi[r], tones.scale[weft.yarn[r], 0]
    _follow(s, WEFT_HALF, start, texels, 1.0, weft.thick, r, by_column, THICKNESS)
    _follow(s, WEFT_PSI, start, texels, psi, weft.twist, r, by_column, TWIST)
    _follow(s, WEFT_TONE, start, texels, 0.0, weft.tone, r, by_column, TONE)
    for i in range(texels):
        size = s[WEFT_HALF * PIECE + i]
        s[WEFT_EDGE * PIECE + i] = min(half_width * size, room)
        s[WEFT_HALF * PIECE + i] = half_height * size
    if len(weft.tone) == 1:
        tone = shade(scales, s[WEFT_TONE * PIECE])
        for i in range(texels):
            s[WEFT_TONE * PIECE + i] = tone
    else:
        for i in range(texels):
            s[WEFT_TONE * PIECE + i] = shade(scales, s[WEFT_TONE * PIECE + i])


@step
def _follow(  # type: ignore[no-untyped-def]
    s, field, start, texels, mean, knots, r, blend, kind
):
    """Fill a field with the `mean` of pick `r` and its deviation; `knots` are (knots, picks)."""
    if len(knots) == 1:
        for i in range(texels):
            s[field * PIECE + i] = mean + knots[0, r]
        return
    left, right = blend.left[kind, start:], blend.right[kind, start:]
    low, high = blend.left_weight[kind, start:], blend.right_weight[kind, start:]
    for i in range(texels):
        s[field * PIECE + i] = mean + (low[i] * knots[left[i], r] + high[i] * knots[right[i], r])
