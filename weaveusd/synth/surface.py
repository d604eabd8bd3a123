"""How the surface of the yarns lies in a piece of a row: bend, frame, grooves between plies.

A piece's numbers lie in one flat array, field after field, `PIECE` texels each. As every offset
is a constant, compilers see that fields do not overlap and compute several texels at once. The
steps change the fields in place, and know neither threads nor drawdown.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.synth.compiled import compiled
from weaveusd.synth.plan import R_HAT
from weaveusd.synth.spine import circle_bend, conic_bend, floor, frame, nearest, sin_cos
from weaveusd.synth.strands import strand, strand_slope

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

PIECE = 128
"""Texels worked on together: their numbers stay in the fastest cache."""

INFINITE = math.inf

# What `choose` says of a texel, in the frame of its yarn; lengths in mm, angles in radians.
(
    ACROSS,  # distance from the yarn's axis, across
    HALF_WIDTH,
    HALF_HEIGHT,  # 0 in gaps
    ALONG,  # distance from the float's middle, along the yarn, but for whole repeats
    STRAIGHT,  # half length of the float's straight part
    RADIUS,  # of the circular spine
    BASE,  # height of the axis at the float's middle
    PSI,  # angle of the fibre
    WEFT,  # 1 on weft, 0 on warp
    # What the steps make of it.
    SIN_V, COS_V, SIN_U, COS_U, SPINE,
    N_X, N_Y, N_Z, T_X, T_Y, T_Z, HEIGHT,
    # The row's pick at every texel, whether it is seen or not.
    WEFT_SIZE, WEFT_EDGE, WEFT_PSI,
    # The plies of the yarn.
    PLIES, STRAND, RATE, DEPTH,
) = range(28)  # fmt: skip
FIELDS = 28


@compiled
def bend(s: Doubles, texels: int, width_mm: float, height_mm: float) -> None:
    """Compute section angle v, inclination u and the spine's height, as if all were circles."""
    for i in range(texels):
        sin_v = s[ACROSS * PIECE + i] / s[HALF_WIDTH * PIECE + i]
        cos_v = math.sqrt(1.0 - sin_v * sin_v)
        repeat = width_mm if s[WEFT * PIECE + i] > 0.0 else height_mm
        along = s[ALONG * PIECE + i]
        along -= repeat * nearest(along / repeat)
        y = abs(along) - s[STRAIGHT * PIECE + i]
        sin_u, cos_u, spine = circle_bend(
            y, s[RADIUS * PIECE + i], s[HALF_HEIGHT * PIECE + i] * cos_v
        )
        s[ALONG * PIECE + i] = along
        s[SIN_V * PIECE + i], s[COS_V * PIECE + i] = sin_v, cos_v
        s[SIN_U * PIECE + i] = sin_u if along > 0.0 else -sin_u
        s[COS_U * PIECE + i], s[SPINE * PIECE + i] = cos_u, spine


@compiled
def bend_conics(  # type: ignore[no-untyped-def]
    s, texels, threads, is_weft, float_of
):
    """Replace inclination and height where a float of `threads`, warp or weft, is a conic."""
    for i in range(texels):
        f = float_of[i]
        if f < 0 or (s[WEFT * PIECE + i] > 0.0) != is_weft:
            continue
        r_hat = threads.floats[f, R_HAT]
        if math.isnan(r_hat):
            continue
        along = s[ALONG * PIECE + i]
        y = abs(along) - s[STRAIGHT * PIECE + i]
        b_cos_v = s[HALF_HEIGHT * PIECE + i] * s[COS_V * PIECE + i]
        sin_u, cos_u, spine = conic_bend(y, r_hat, s[RADIUS * PIECE + i], b_cos_v)
        s[SIN_U * PIECE + i] = sin_u if along > 0.0 else -sin_u
        s[COS_U * PIECE + i], s[SPINE * PIECE + i] = cos_u, spine


@compiled
def turn(s: Doubles, texels: int) -> None:
    """Compute height, normal and fibre of a single yarn's surface, in the yarn's frame."""
    for i in range(texels):
        sin_v, cos_v = s[SIN_V * PIECE + i], s[COS_V * PIECE + i]
        sin_u, cos_u = s[SIN_U * PIECE + i], s[COS_U * PIECE + i]
        b = s[HALF_HEIGHT * PIECE + i]
        sin_psi, cos_psi = sin_cos(s[PSI * PIECE + i])
        n_x, n_y, n_z, t_x, t_y, t_z = frame(
            sin_u, cos_u, sin_v, cos_v, b / s[HALF_WIDTH * PIECE + i], sin_psi, cos_psi
        )
        s[N_X * PIECE + i], s[N_Y * PIECE + i], s[N_Z * PIECE + i] = n_x, n_y, n_z
        s[T_X * PIECE + i], s[T_Y * PIECE + i], s[T_Z * PIECE + i] = t_x, t_y, t_z
        s[HEIGHT * PIECE + i] = s[BASE * PIECE + i] + s[SPINE * PIECE + i] + b * cos_v * cos_u


@compiled
def wind(  # type: ignore[no-untyped-def]
    s, texels, start, columns, y_mm, warp, weft, thread_of, width_mm, height_mm
):
    """Note how the plies of each texel's yarn wind; gaps have none."""
    warp_plies, warp_turns, warp_phase, warp_depth = warp.plies, warp.turns, warp.phase, warp.groove
    weft_plies, weft_turns, weft_phase, weft_depth = weft.plies, weft.turns, weft.phase, weft.groove
    position = columns.position
    for i in range(texels):
        k = thread_of[i]
        if s[WEFT * PIECE + i] > 0.0:
            plies, turns, phase, depth = weft_plies[k], weft_turns[k], weft_phase[k], weft_depth[k]
            along, repeat = position[start + i], width_mm
        else:
            plies, turns, phase, depth = warp_plies[k], warp_turns[k], warp_phase[k], warp_depth[k]
            along, repeat = y_mm, height_mm
        s[PLIES * PIECE + i] = plies
        s[STRAND * PIECE + i] = strand(plies, turns, phase, s[SIN_V * PIECE + i], along / repeat)
        s[RATE * PIECE + i] = turns / repeat
        s[DEPTH * PIECE + i] = depth if s[HALF_HEIGHT * PIECE + i] > 0.0 else 0.0


@compiled
def groove(s: Doubles, texels: int) -> None:
    """Sink the surface between plies, and turn normal and fibre with it.

    A strand's place across is w = 2 frac(p) − 1, p being `strand`; the surface dips by
    g w² cos v, and the normal is that of the height so changed.
    """
    for i in range(texels):
        sin_v, cos_v = s[SIN_V * PIECE + i], s[COS_V * PIECE + i]
        a, depth = s[HALF_WIDTH * PIECE + i], s[DEPTH * PIECE + i]
        p = s[STRAND * PIECE + i]
        w = 2.0 * (p - floor(p)) - 1.0
        w_x = 2.0 * s[PLIES * PIECE + i] * strand_slope(sin_v) / a
        w_y = 2.0 * s[RATE * PIECE + i]
        old_x, old_y, old_z = s[N_X * PIECE + i], s[N_Y * PIECE + i], s[N_Z * PIECE + i]
        n_x = old_x / old_z + depth * (2.0 * w * w_x * cos_v - w * w * sin_v / (a * cos_v))
        n_y = old_y / old_z + depth * 2.0 * w * w_y * cos_v
        n_z = 1.0 / math.sqrt(n_x * n_x + n_y * n_y + 1.0)
        n_x, n_y = n_x * n_z, n_y * n_z
        t_x, t_y, t_z = s[T_X * PIECE + i], s[T_Y * PIECE + i], s[T_Z * PIECE + i]
        lean = t_x * n_x + t_y * n_y + t_z * n_z
        t_x, t_y, t_z = t_x - lean * n_x, t_y - lean * n_y, t_z - lean * n_z
        scale = 1.0 / math.sqrt(t_x * t_x + t_y * t_y + t_z * t_z)
        s[N_X * PIECE + i], s[N_Y * PIECE + i], s[N_Z * PIECE + i] = n_x, n_y, n_z
        s[T_X * PIECE + i], s[T_Y * PIECE + i] = t_x * scale, t_y * scale
        s[T_Z * PIECE + i] = t_z * scale
        s[HEIGHT * PIECE + i] -= depth * w * w * cos_v


@compiled
def write_surface(s, texels, start, normal, tangent, height):  # type: ignore[no-untyped-def]
    """Write the piece into the row's channels, turned from the yarns' frames to the cloth's."""
    for i in range(texels):
        on_weft = s[WEFT * PIECE + i] > 0.0
        x, y = s[N_X * PIECE + i], s[N_Y * PIECE + i]
        normal[start + i, 0] = y if on_weft else x
        normal[start + i, 1] = -x if on_weft else y
        normal[start + i, 2] = s[N_Z * PIECE + i]
    for i in range(texels):
        on_weft = s[WEFT * PIECE + i] > 0.0
        x, y = s[T_X * PIECE + i], s[T_Y * PIECE + i]
        tangent[start + i, 0] = y if on_weft else x
        tangent[start + i, 1] = -x if on_weft else y
        tangent[start + i, 2] = s[T_Z * PIECE + i]
    for i in range(texels):
        height[start + i, 0] = s[HEIGHT * PIECE + i]
