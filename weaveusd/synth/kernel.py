"""The texel kernel: which yarn a texel sees, and how that yarn's surface lies there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from numba import njit, prange

from weaveusd.synth.spine import CIRCLE, circle_bend, conic_bend, frame, sin_cos

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from weaveusd.synth.plan import Cells, Threads

    Floats32 = NDArray[np.float32]


@njit(cache=True, parallel=True, nogil=True)
def fill_rows(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    first, columns: Cells, rows: Cells, warp: Threads, weft: Threads, width_mm, height_mm,
    yarn_color, normal, tangent, height, opacity, yarn_id, base_color,
):  # fmt: skip
    """Fill texel rows `first`, `first` + 1, … of every channel array (rows, width, components).

    At a crossing the thread that the drawdown puts on top is seen where it is wide enough, and
    the other one beside it. In the gap beside a crossing the thread that runs there belongs to
    its float, or to the float next to it, or is seen from above as it passes under both
    neighbours. Where no thread is, opacity is 0, the normal is up and the yarn id -1.
    """
    for k in prange(normal.shape[0]):
        j = first + k
        r, off_y, y = rows.thread[j], rows.offset[j], rows.position[j]
        on_weft = abs(off_y) < weft.half_width[r]
        for i in range(normal.shape[1]):
            c, off_x, x = columns.thread[i], columns.offset[i], columns.position[i]
            on_warp = abs(off_x) < warp.half_width[c]
            n_x, n_y, n_z, t_x, t_y, t_z, z, yarn = 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, -1
            f = warp.at[r, c]
            if on_warp and not on_weft and f < 0:
                f = warp.at[rows.beside[j], c]
            g = weft.at[r, c]
            if on_weft and not on_warp and g < 0:
                g = weft.at[r, columns.beside[i]]

            if on_warp and (f >= 0 or not on_weft):
                n_x, n_y, n_z, t_x, t_y, t_z, z = _surface(warp, c, f, off_x, y, height_mm)
                yarn = warp.yarn[c]
            elif on_weft:
                a_x, a_y, n_z, s_x, s_y, t_z, z = _surface(weft, r, g, -off_y, x, width_mm)
                n_x, n_y, t_x, t_y = a_y, -a_x, s_y, -s_x
                yarn = weft.yarn[r]
            else:
                z = min(warp.sunk[c], weft.sunk[r])

            normal[k, i, 0], normal[k, i, 1], normal[k, i, 2] = n_x, n_y, n_z
            tangent[k, i, 0], tangent[k, i, 1], tangent[k, i, 2] = t_x, t_y, t_z
            height[k, i, 0] = z
            opacity[k, i, 0] = 0.0 if yarn < 0 else 1.0
            yarn_id[k, i, 0] = yarn
            shown = yarn if yarn >= 0 else warp.yarn[c]
            for channel in range(3):
                base_color[k, i, channel] = yarn_color[shown, channel]


@njit(cache=True, nogil=True, inline="always")
def _surface(threads: Threads, k: int, f: int, across: float, along: float, repeat: float) -> Any:
    """Return normal, tangent (yarn frame) and height of thread `k` in float `f`, or under (-1)."""
    a, b = threads.half_width[k], threads.half_height[k]
    sin_v = across / a
    cos_v = math.sqrt(1.0 - sin_v * sin_v)
    sin_u, cos_u, z_spine = 0.0, 1.0, 0.0
    if f >= 0:
        d = along - threads.middle[f]
        d -= repeat * math.floor(d / repeat + 0.5)
        y = abs(d) - threads.straight[f]
        if y > 0.0:
            if threads.kind[f] == CIRCLE:
                sin_u, cos_u, z_spine = circle_bend(y, threads.radius[f], b * cos_v)
            else:
                sin_u, cos_u, z_spine = conic_bend(
                    y, threads.r_hat[f], threads.radius[f], b * cos_v
                )
            if d < 0.0:
                sin_u = -sin_u
    crown = threads.crown[k] if f >= 0 else threads.sunk[k]
    sin_psi, cos_psi = sin_cos(threads.psi[k] + _wander(threads.wander[k], along / repeat))
    n_x, n_y, n_z, t_x, t_y, t_z = frame(sin_u, cos_u, sin_v, cos_v, b / a, sin_psi, cos_psi)
    return n_x, n_y, n_z, t_x, t_y, t_z, crown + z_spine + b * (cos_v * cos_u - 1.0)


@njit(cache=True, nogil=True, inline="always")
def _wander(knots: NDArray[np.float64], s: float) -> Any:
    """Return the twist's deviation at the share `s` of the repeat.

    Two neighbouring knots are blended and divided by the norm of their weights, so that the
    variance between knots is that at the knots.
    """
    count = len(knots)
    if count == 1:
        return knots[0]
    p = s * count
    left = math.floor(p)
    w = p - left
    i = int(left) % count
    blend = (1.0 - w) * knots[i] + w * knots[(i + 1) % count]
    return blend / math.sqrt(w * w + (1.0 - w) * (1.0 - w))
