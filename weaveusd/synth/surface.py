"""How the surface of the yarns lies in a piece of a row: bend, frame, grooves between plies.

The steps change the fields of the piece in place, and know neither threads nor drawdown.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.synth.compiled import step
from weaveusd.synth.piece import (
    ACROSS,
    ALONG,
    BASE,
    COS_U,
    COS_V,
    DEPTH,
    HALF_HEIGHT,
    HALF_WIDTH,
    HEIGHT,
    N_X,
    N_Y,
    N_Z,
    PIECE,
    PLIES,
    PSI,
    RADIUS,
    RATE,
    SIN_U,
    SIN_V,
    SPINE,
    STRAIGHT,
    STRAND,
    T_X,
    T_Y,
    T_Z,
    WARP_GROOVE,
    WARP_PHASE,
    WARP_PLIES,
    WARP_R_HAT,
    WARP_TURNS,
    WEFT,
    WEFT_R_HAT,
)
from weaveusd.synth.spine import circle_bend, conic_bend, floor, frame, nearest, sin_cos
from weaveusd.synth.strands import strand, strand_slope

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


@step
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


@step
def bend_conics(s: Doubles, texels: int) -> None:
    """Replace inclination and height where the float that is seen is a conic."""
    for i in range(texels):
        on_weft = s[WEFT * PIECE + i] > 0.0
        r_hat = s[WEFT_R_HAT * PIECE + i] if on_weft else s[WARP_R_HAT * PIECE + i]
        if math.isnan(r_hat) or s[HALF_HEIGHT * PIECE + i] == 0.0:
            continue
        along = s[ALONG * PIECE + i]
        y = abs(along) - s[STRAIGHT * PIECE + i]
        b_cos_v = s[HALF_HEIGHT * PIECE + i] * s[COS_V * PIECE + i]
        sin_u, cos_u, spine = conic_bend(y, r_hat, s[RADIUS * PIECE + i], b_cos_v)
        s[SIN_U * PIECE + i] = sin_u if along > 0.0 else -sin_u
        s[COS_U * PIECE + i], s[SPINE * PIECE + i] = cos_u, spine


@step
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


@step
def wind(  # type: ignore[no-untyped-def]
    s, texels, r, y_mm, position, weft, width_mm, height_mm
):
    """Note how the plies of each texel's yarn wind, `r` being the row's pick; gaps have none."""
    plies, turns, phase, depth = weft.plies[r], weft.turns[r], weft.phase[r], weft.groove[r]
    for i in range(texels):
        on_weft = s[WEFT * PIECE + i] > 0.0
        warp_plies, warp_turns = s[WARP_PLIES * PIECE + i], s[WARP_TURNS * PIECE + i]
        warp_phase, warp_depth = s[WARP_PHASE * PIECE + i], s[WARP_GROOVE * PIECE + i]
        own_plies, own_turns = plies if on_weft else warp_plies, turns if on_weft else warp_turns
        own_phase, own_depth = phase if on_weft else warp_phase, depth if on_weft else warp_depth
        repeat = width_mm if on_weft else height_mm
        along = position[i] if on_weft else y_mm
        s[PLIES * PIECE + i] = own_plies
        s[STRAND * PIECE + i] = strand(
            own_plies, own_turns, own_phase, s[SIN_V * PIECE + i], along / repeat
        )
        s[RATE * PIECE + i] = own_turns / repeat
        s[DEPTH * PIECE + i] = own_depth if s[HALF_HEIGHT * PIECE + i] > 0.0 else 0.0


@step
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


@step
def write_surface(s, texels, normal, tangent, height):  # type: ignore[no-untyped-def]
    """Write the piece, turned from the yarns' frames to the cloth's.

    `normal` and `tangent` (3 texels,) have the components of a texel side by side.
    """
    for i in range(texels):
        on_weft = s[WEFT * PIECE + i] > 0.0
        x, y = s[N_X * PIECE + i], s[N_Y * PIECE + i]
        normal[3 * i] = y if on_weft else x
        normal[3 * i + 1] = -x if on_weft else y
        normal[3 * i + 2] = s[N_Z * PIECE + i]
    for i in range(texels):
        on_weft = s[WEFT * PIECE + i] > 0.0
        x, y = s[T_X * PIECE + i], s[T_Y * PIECE + i]
        tangent[3 * i] = y if on_weft else x
        tangent[3 * i + 1] = -x if on_weft else y
        tangent[3 * i + 2] = s[T_Z * PIECE + i]
    for i in range(texels):
        height[i] = s[HEIGHT * PIECE + i]
