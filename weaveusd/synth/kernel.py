"""The texel kernel: which yarn a texel sees, and how that yarn's surface lies there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit, prange

from weaveusd.synth.noise import MAX_SIGMAS
from weaveusd.synth.spine import CIRCLE, circle_bend, conic_bend, frame, sin_cos
from weaveusd.synth.tones import SLOTS, STEPS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.synth.plan import Cells, Threads
    from weaveusd.synth.tones import Tones

FRINGE = 0.6
"""How far the hairs of a yarn reach beside it, in half widths."""

FAINTEST = 1 / 255
"""Hairs of less opacity are none: eight bits would hold a gap with a yarn in it."""

STRAND_1, STRAND_3 = 0.5 / math.pi, 0.25 - 0.5 / math.pi
"""Coefficients of sin v and its cube that stand for v / 2π where plies wind."""

BUNDLES, BUNDLE_MM = 12, 0.6
"""Bundles of fibres side by side on a mélange's face, and how long one stays on the surface."""


@njit(cache=True, parallel=True, nogil=True)
def fill_rows(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    first, columns: Cells, rows: Cells, warp: Threads, weft: Threads, width_mm, height_mm,
    tones: Tones, normal, tangent, height, opacity, yarn_id, base_color, system, fibre_angle,
):  # fmt: skip
    """Fill texel rows `first`, `first` + 1, … of every channel array (rows, width, components).

    At a crossing the thread that the drawdown puts on top is seen where it is wide enough, and
    the other one beside it. In the gap beside a crossing the thread that runs there belongs to
    its float, or to the float next to it, or is seen from above as it passes under both
    neighbours. Where no thread is, opacity is that of loose hairs; without hairs it is 0, the
    normal is up and the yarn id -1.
    """
    for k in prange(normal.shape[0]):
        j = first + k
        r, off_y, y = rows.thread[j], rows.offset[j], rows.position[j]
        s_y = y / height_mm
        warp_scale = np.empty(len(warp.center))
        for c in range(len(warp_scale)):
            warp_scale[c] = 1.0 + _wander(warp.thick[c], s_y)
        for i in range(normal.shape[1]):
            c, off_x, x = columns.thread[i], columns.offset[i], columns.position[i]
            warp_size = warp_scale[c]
            weft_size = 1.0 + _wander(weft.thick[r], x / width_mm)
            warp_edge = min(warp.half_width[c] * warp_size, warp.room[c])
            weft_edge = min(weft.half_width[r] * weft_size, weft.room[r])
            on_warp, on_weft = abs(off_x) < warp_edge, abs(off_y) < weft_edge
            n_x, n_y, n_z, t_x, t_y, t_z, yarn, alpha = 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1, 0.0
            f = warp.at[r, c]
            if on_warp and not on_weft and f < 0:
                f = warp.at[rows.beside[j], c]
            g = weft.at[r, c]
            if on_weft and not on_warp and g < 0:
                g = weft.at[r, columns.beside[i]]

            if on_warp and (f >= 0 or not on_weft):
                n_x, n_y, n_z, t_x, t_y, t_z, z = _surface(
                    warp, c, f, off_x, warp_edge, warp_size, y, height_mm
                )
                yarn, alpha = warp.yarn[c], 1.0
                _color(base_color[k, i], tones, warp, c, off_x / warp_edge, y, height_mm)
            elif on_weft:
                a_x, a_y, n_z, s_x, s_z, t_z, z = _surface(
                    weft, r, g, -off_y, weft_edge, weft_size, x, width_mm
                )
                n_x, n_y, t_x, t_y = a_y, -a_x, s_z, -s_x
                yarn, alpha = weft.yarn[r], 1.0
                _color(base_color[k, i], tones, weft, r, -off_y / weft_edge, x, width_mm)
            else:
                across = _fringe(warp.hair[c], abs(off_x), warp_edge)
                along = _fringe(weft.hair[r], abs(off_y), weft_edge)
                z = min(warp.sunk[c] + warp.half_height[c], weft.sunk[r] + weft.half_height[r])
                alpha = 1.0 - (1.0 - across) * (1.0 - along)
                if alpha < FAINTEST:
                    alpha = 0.0
                if along > across:
                    t_x, t_y = 1.0, 0.0
                    _color(base_color[k, i], tones, weft, r, 0.0, x, width_mm)
                else:
                    _color(base_color[k, i], tones, warp, c, 0.0, y, height_mm)
                if alpha > 0.0:
                    yarn = weft.yarn[r] if along > across else warp.yarn[c]

            normal[k, i, 0], normal[k, i, 1], normal[k, i, 2] = n_x, n_y, n_z
            tangent[k, i, 0], tangent[k, i, 1], tangent[k, i, 2] = t_x, t_y, t_z
            height[k, i, 0] = z
            opacity[k, i, 0] = alpha
            yarn_id[k, i, 0] = yarn
            system[k, i, 0] = -1 if yarn < 0 else (0 if yarn == warp.yarn[c] else 1)
            flat = t_x * t_x + t_y * t_y
            fibre_angle[k, i, 0] = (t_x * t_x - t_y * t_y) / flat if flat > 0.0 else 1.0
            fibre_angle[k, i, 1] = 2.0 * t_x * t_y / flat if flat > 0.0 else 0.0


@njit(cache=True, nogil=True, inline="always")
def _surface(
    threads: Threads, k: int, f: int, across: float, a: float, size: float, along: float,
    repeat: float,
) -> Any:  # fmt: skip
    """Return normal, tangent (yarn frame) and height of thread `k` in float `f`, or under (-1).

    `a` is the half width there and `size` the thickness relative to the thread's mean.
    """
    b = threads.half_height[k] * size
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
    axis = threads.axis[k] if f >= 0 else threads.sunk[k]
    z = axis + z_spine + b * cos_v * cos_u
    sin_psi, cos_psi = sin_cos(threads.psi[k] + _wander(threads.twist[k], along / repeat))
    n_x, n_y, n_z, t_x, t_y, t_z = frame(sin_u, cos_u, sin_v, cos_v, b / a, sin_psi, cos_psi)
    if threads.plies[k] > 0.0:
        n_x, n_y, n_z, dip = _groove(threads, k, a, sin_v, cos_v, along, repeat, n_x, n_y, n_z)
        z -= dip
        lean = t_x * n_x + t_y * n_y + t_z * n_z
        t_x, t_y, t_z = t_x - lean * n_x, t_y - lean * n_y, t_z - lean * n_z
        scale = 1.0 / math.sqrt(t_x * t_x + t_y * t_y + t_z * t_z)
        t_x, t_y, t_z = t_x * scale, t_y * scale, t_z * scale
    return n_x, n_y, n_z, t_x, t_y, t_z, z


@njit(cache=True, nogil=True, inline="always")
def _groove(
    threads: Threads, k: int, a: float, sin_v: float, cos_v: float, along: float, repeat: float,
    n_x: float, n_y: float, n_z: float,
) -> Any:  # fmt: skip
    """Return the normal between plies and how deep the surface dips there.

    A strand's place across is w = 2 frac(p) − 1, p being `_strand`; the surface dips by
    g w² cos v, and the normal is that of the height so changed.
    """
    p = _strand(threads, k, sin_v, along / repeat)
    w = 2.0 * (p - math.floor(p)) - 1.0
    depth = threads.groove[k]
    w_x = 2.0 * threads.plies[k] * (STRAND_1 + 3.0 * STRAND_3 * sin_v * sin_v) / a
    w_y = 2.0 * threads.turns[k] / repeat
    g_x = n_x / n_z + depth * (2.0 * w * w_x * cos_v - w * w * sin_v / (a * cos_v))
    g_y = n_y / n_z + depth * 2.0 * w * w_y * cos_v
    up = 1.0 / math.sqrt(g_x * g_x + g_y * g_y + 1.0)
    return g_x * up, g_y * up, up, depth * w * w * cos_v


@njit(cache=True, nogil=True, inline="always")
def _strand(threads: Threads, k: int, sin_v: float, s: float) -> Any:
    """Return the strand at the section angle v and the share `s` of the repeat, not whole.

    Strands wind around the yarn: p = plies v / 2π + turns s. In place of v / 2π stands an odd
    cubic of sin v that has its slope at the crown and its value ±¼ at the sides.
    """
    around = sin_v * (STRAND_1 + STRAND_3 * sin_v * sin_v)
    return threads.plies[k] * around + threads.turns[k] * s + threads.phase[k]


@njit(cache=True, nogil=True, inline="always")
def _color(
    out: NDArray[np.float32], tones: Tones, threads: Threads, k: int, sin_v: float, along: float,
    repeat: float,
) -> None:  # fmt: skip
    """Write the color of thread `k` at the section angle v and the place `along` it."""
    yarn, s = threads.yarn[k], along / repeat
    color = 0
    if tones.colors[yarn] > 1:
        if tones.by_ply[yarn]:
            strand = math.floor(_strand(threads, k, sin_v, s))
            color = int(strand) % tones.colors[yarn]
        else:
            color = tones.slots[yarn, _bundle(threads, k, sin_v, along / repeat, repeat)]
    g = min(max(_wander(threads.tone[k], s), -MAX_SIGMAS), MAX_SIGMAS)
    place = (g + MAX_SIGMAS) * ((STEPS - 1) / (2.0 * MAX_SIGMAS))
    low = min(int(place), STEPS - 2)
    share = place - low
    for c in range(3):
        here = tones.table[yarn, color, low, c]
        out[c] = here + share * (tones.table[yarn, color, low + 1, c] - here)


@njit(cache=True, nogil=True, inline="always")
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


@njit(cache=True, nogil=True, inline="always")
def _hash(value: np.uint64) -> Any:
    """Return 64 well mixed bits of 64 bits (the finalizer of splitmix64)."""
    value = (value ^ (value >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    value = (value ^ (value >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return value ^ (value >> np.uint64(31))


@njit(cache=True, nogil=True, inline="always")
def _fringe(hairiness: float, distance: float, edge: float) -> float:
    """Return how much of the light loose hairs catch at a distance from a yarn's axis.

    As much as the hairiness at the yarn's edge, falling to nothing with the square of the
    distance over `FRINGE` half widths.
    """
    if hairiness <= 0.0:
        return 0.0
    free = 1.0 - (distance - edge) / (FRINGE * edge)
    return hairiness * free * free if free > 0.0 else 0.0


@njit(cache=True, nogil=True, inline="always")
def _wander(knots: NDArray[np.float64], s: float) -> Any:
    """Return a thread's deviation at the share `s` of the repeat.

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
