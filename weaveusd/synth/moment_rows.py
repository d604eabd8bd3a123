"""The loop that adds texels to moment maps: what `synth.moments` defines, texel by texel.

Sums are doubles and run from left to right and from the top row down, for all bands alike.
"""

from __future__ import annotations

import numpy as np

from weaveusd.synth.compiled import compiled, inlined, step
from weaveusd.synth.moments import (
    ACROSS,
    ACROSS_XX,
    ALBEDO,
    ASIDE,
    FALLING,
    FALLING_S,
    FALLING_SS,
    FLAT,
    RISING,
    RISING_S,
    RISING_SS,
    SHARE,
    STRAIGHT,
    TWIST,
    TWIST_PP,
)
from weaveusd.synth.piece import PIECE

N, T, FLATNESS, CURVATURE, S, X, P = (PIECE * field for field in (0, 3, 6, 7, 8, 9, 10))
"""Where the numbers of a piece lie in the room for them."""
ROOM = 11 * PIECE


@compiled
def sum_rows(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    first, full, normal, tangent, opacity, system, yarn_id, base_color,
    flatness, curvature, gain, kind, cell, inside, done, open_row, line, room,
):  # fmt: skip
    """Add texel rows `first`, `first` + 1, … from the top, of `full`, to the maps `done`.

    Channels are (rows, width × components) float32, the top row first. `flatness` and `curvature`
    are those of warp and weft, `gain` and `kind` those of every yarn. A column of texels lies in
    column `cell` of the maps with the share `inside` of itself, and with the rest in the next.
    `done` (systems, h, w, channels) float32 gets a row of the maps when its last texels are
    added; until then `open_row` (systems, w, channels) holds its sums. `line`, of its shape, and
    `room` (ROOM,) are for the work.
    """
    rows, width = opacity.shape
    height, columns = done.shape[1], done.shape[2]
    for k in range(rows):
        line[:] = 0.0
        for start in range(0, width, PIECE):
            stop = min(width, start + PIECE)
            texels = stop - start
            _turn(start, texels, normal[k], system[k], room, N)
            _turn(start, texels, tangent[k], system[k], room, T)
            for i in range(texels):
                weft = system[k, start + i] > 0.5
                room[FLATNESS + i] = flatness[1] if weft else flatness[0]
                room[CURVATURE + i] = curvature[1] if weft else curvature[0]
            _places(texels, room)
            _add_piece(
                start, stop, opacity[k], system[k], yarn_id[k], base_color[k], gain, kind,
                cell, inside, columns / width, room, line,
            )  # fmt: skip
        # In units of 1/height of a texel: where it and its row of the maps end.
        begin = (first + k) * height
        r = begin // full
        within = min(height, (r + 1) * full - begin)
        _add_line(line, within / full, open_row)
        if begin + within == (r + 1) * full:
            _close_row(r, open_row, done)
            _add_line(line, (height - within) / full, open_row)


@step
def _turn(start, texels, vectors, system, room, field):  # type: ignore[no-untyped-def]
    """Fill three fields of `room` from `field` on: across and along the yarn, and upwards."""
    for i in range(texels):
        at = 3 * (start + i)
        x, y = np.float64(vectors[at]), np.float64(vectors[at + 1])
        weft = system[start + i] > 0.5
        room[field + i] = -y if weft else x
        room[field + PIECE + i] = x if weft else y
        room[field + 2 * PIECE + i] = vectors[at + 2]


@step
def _places(texels, room):  # type: ignore[no-untyped-def]
    """Fill in S, X and P of `texels` texels."""
    for i in range(texels):
        n_x, n_y, n_z = room[N + i], room[N + PIECE + i], room[N + 2 * PIECE + i]
        t_x, t_y, t_z = room[T + i], room[T + PIECE + i], room[T + 2 * PIECE + i]
        k = room[CURVATURE + i]
        up = np.sqrt(n_y * n_y + n_z * n_z)
        scale = 1.0 / max(up, 1e-12)
        sin_u, cos_u = n_y * scale, n_z * scale
        flat = room[FLATNESS + i] * up
        x = n_x / np.sqrt(n_x * n_x + flat * flat)
        room[S + i] = sin_u * (1.0 + k * np.sqrt(max(1.0 - x * x, 0.0))) / (1.0 + k)
        room[X + i] = x
        p = t_x * up - n_x * (t_y * sin_u + t_z * cos_u)
        room[P + i] = p if t_y * cos_u - t_z * sin_u < 0.0 else -p


@step
def _add_piece(  # type: ignore[no-untyped-def]
    start, stop, opacity, system, yarn_id, base_color, gain, kind, cell, inside, scale, room, line
):
    """Add texels `start` to `stop` - 1 of a row to `line`."""
    for i in range(start, stop):
        a, yarn = np.float64(opacity[i]), int(yarn_id[i])
        if a == 0.0 or yarn < 0:
            continue
        sums = line[1 if system[i] > 0.5 else 0]
        weight = scale * inside[i] * a
        c = cell[i]
        _add_texel(i - start, weight, room, base_color, 3 * i, gain[yarn], kind[yarn], sums[c])
        if inside[i] < 1.0:
            weight = scale * (1.0 - inside[i]) * a
            _add_texel(
                i - start, weight, room, base_color, 3 * i, gain[yarn], kind[yarn], sums[c + 1]
            )


@inlined
def _add_texel(i, weight, room, base_color, at, gain, kind, sums):  # type: ignore[no-untyped-def]
    """Add one texel with `weight` to the `sums` of a texel of the maps."""
    s, x, p = room[S + i], room[X + i], room[P + i]
    if s > STRAIGHT:
        sums[RISING] += weight
        sums[RISING_S] += weight * s
        sums[RISING_SS] += weight * s * s
    elif s < -STRAIGHT:
        sums[FALLING] += weight
        sums[FALLING_S] += weight * s
        sums[FALLING_SS] += weight * s * s
    else:
        sums[FLAT] += weight
    sums[ACROSS] += weight * x
    sums[ASIDE] += weight * abs(x)
    sums[ACROSS_XX] += weight * x * x
    sums[TWIST] += weight * p
    sums[TWIST_PP] += weight * p * p
    for component in range(3):
        sums[ALBEDO + component] += weight * min(1.0, gain * base_color[at + component])
    sums[SHARE + kind] += weight


@step
def _add_line(line, share, open_row):  # type: ignore[no-untyped-def]
    """Add `share` of a row of texels to the row of the maps that is open."""
    systems, columns, channels = line.shape
    for s in range(systems):
        for c in range(columns):
            for m in range(channels):
                open_row[s, c, m] += share * line[s, c, m]


@step
def _close_row(r, open_row, done):  # type: ignore[no-untyped-def]
    """Move the sums of the open row to row `r` of the maps, and begin anew."""
    systems, columns, channels = open_row.shape
    for s in range(systems):
        for c in range(columns):
            for m in range(channels):
                done[s, r, c, m] = open_row[s, c, m]
                open_row[s, c, m] = 0.0
