"""The loops of the lobe maps: texels become moments, moments means, and means lobes again.

The moments of a texel are what a mean can be taken of: `MOMENTS` in this order, each times the
opacity but for the last. T, D_x and D_y are the matrix ``R diag(α_t, α_b) Rᵀ``, its mean diagonal
and what turns with 2φ. Only sums, products, quotients and square roots are used, so that all
machines agree.
"""

from __future__ import annotations

import numpy as np

from weaveusd.synth.compiled import compiled

MOMENTS = ("T", "D_x", "D_y", "T² + D²", "α round", "n_x", "n_y", "n_x² + n_y²", "opacity")
MEAN, TURN_X, TURN_Y, SQUARES, EVEN, TILT_X, TILT_Y, TILTS, WEIGHT = range(len(MOMENTS))

CLEAR = np.float32(2.0**-20)
"""Weight of a texel that is not opaque: nothing beside one that is."""

STEPS = np.float32(512)
"""Levels in which the rotation of a texel is counted: fewer digits are fewer bytes."""

ROUND = np.float32(2.0**-10)
"""Length of the rotation of a lobe without direction: one of zero would have no angle."""


@compiled
def fill_of_yarns(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    normal, fibre, opacity, yarn_id, wide, stretch, roughness, rotation
):
    """Fill in the roughness (n, W, 1) and the rotation (n, W, 3) of texels.

    `normal` and `fibre` (n, W, 3), `opacity` and `yarn_id` (n, W, 1) are float32. `wide` is
    (yarns,), the roughness of each, `stretch` its p in (cos 2φ, sin 2φ, 0) p. The angle is measured
    about the normal, from X laid into the plane of the surface. Texels that are not opaque are
    loose hairs: rough, without a direction.
    """
    zero, one, two = np.float32(0), np.float32(1), np.float32(2)
    for k in range(opacity.shape[0]):
        for i in range(opacity.shape[1]):
            solid = opacity[k, i, 0] == one
            yarn = int(yarn_id[k, i, 0])
            roughness[k, i, 0] = wide[yarn] if solid else one
            p = stretch[yarn] if solid else zero
            # Across the fibre is n × t: by its components along X and beside it, in that plane.
            n_y, n_z = normal[k, i, 1], normal[k, i, 2]
            along = n_y * fibre[k, i, 2] - n_z * fibre[k, i, 1]
            beside = fibre[k, i, 0]
            square = along * along + beside * beside
            rotation[k, i, 0], rotation[k, i, 1], rotation[k, i, 2] = ROUND, zero, zero
            if p > ROUND and square > zero:
                scale = p / square * STEPS
                rotation[k, i, 0] = np.rint((along * along - beside * beside) * scale) / STEPS
                rotation[k, i, 1] = np.rint(two * along * beside * scale) / STEPS


@compiled
def fill_moments(  # type: ignore[no-untyped-def]
    normal, opacity, yarn_id, rotation, mean, even, rough, moments, preview
):
    """Fill in the moments (n, W, MOMENTS) of texels, and their preview roughness (n, W, 1).

    `rotation` is that of `fill_of_yarns`. `mean` (yarns,) is (α_t + α_b) / 2 of each yarn, `even` α
    of its lobe without direction and `rough` the roughness of that.
    """
    one = np.float32(1)
    for k in range(opacity.shape[0]):
        for i in range(opacity.shape[1]):
            n_x, n_y = normal[k, i, 0], normal[k, i, 1]
            cover = opacity[k, i, 0]
            weight = max(cover, CLEAR)
            alpha = round_ = one
            preview[k, i, 0] = one
            if cover == one:
                yarn = int(yarn_id[k, i, 0])
                alpha, round_ = mean[yarn], even[yarn]
                preview[k, i, 0] = rough[yarn]
            d_x, d_y = alpha * rotation[k, i, 0], alpha * rotation[k, i, 1]
            moments[k, i, MEAN] = weight * alpha
            moments[k, i, TURN_X] = weight * d_x
            moments[k, i, TURN_Y] = weight * d_y
            moments[k, i, SQUARES] = weight * (alpha * alpha + d_x * d_x + d_y * d_y)
            moments[k, i, EVEN] = weight * round_
            moments[k, i, TILT_X] = weight * n_x
            moments[k, i, TILT_Y] = weight * n_y
            moments[k, i, TILTS] = weight * (n_x * n_x + n_y * n_y)
            moments[k, i, WEIGHT] = weight


@compiled
def halve_rows(  # type: ignore[no-untyped-def]
    rows, first, full, cell, inside, line, open_row, done
):
    """Add `rows` (n, W, K) of a level of `full` rows, from row `first` on, to the level below.

    A column lies in column `cell` of the level below with the share `inside` of itself, and with
    the rest in the next. Rows that are complete go to `done` (m, w, K), whose number is returned;
    `open_row` (w, K) holds the sums of the one that is not. `line` (w, K) is for the work. Sums are
    doubles and run from left to right and from the top row down, for all bands alike.
    """
    columns, kinds = open_row.shape
    height = max(1, full // 2)
    complete = 0
    for k in range(rows.shape[0]):
        line[:] = 0.0
        for i in range(rows.shape[1]):
            c, share = cell[i], inside[i]
            for m in range(kinds):
                line[c, m] += share * rows[k, i, m]
            if share < 1.0:
                for m in range(kinds):
                    line[c + 1, m] += (1.0 - share) * rows[k, i, m]
        # In units of 1/height of a row: where it and its row of the level below end.
        begin = (first + k) * height
        target = begin // full
        within = min(height, (target + 1) * full - begin)
        scale = columns / rows.shape[1] / full
        for c in range(columns):
            for m in range(kinds):
                open_row[c, m] += within * scale * line[c, m]
        if begin + within == (target + 1) * full:
            for c in range(columns):
                for m in range(kinds):
                    done[complete, c, m] = open_row[c, m]
                    open_row[c, m] = (height - within) * scale * line[c, m]
            complete += 1
    return complete


@compiled
def fill_lobes(moments, towards, roughness, rotation, preview):  # type: ignore[no-untyped-def]
    """Fill in roughness (n, W, 1), rotation (n, W, 3) and preview roughness (n, W, 1) of texels.

    `moments` are (n, W, MOMENTS). `towards` (7,) float32 says what the whole tile's lobe becomes:
    the matrix G, xx, xy and yy; the variances of all its normals and of all its lobes; a factor
    for the lobe without direction; and the least α. G and the factor count by the shares of both
    variances that lie below the texel: by their product, as a float of one yarn is no tile.
    `rotation` is zero at first.
    """
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    g_x, g_y, g_z, of_normals, of_lobes, even_factor, least = towards
    for k in range(moments.shape[0]):
        for i in range(moments.shape[1]):
            weight = moments[k, i, WEIGHT]
            mean = moments[k, i, MEAN] / weight
            d_x, d_y = moments[k, i, TURN_X] / weight, moments[k, i, TURN_Y] / weight
            n_x, n_y = moments[k, i, TILT_X] / weight, moments[k, i, TILT_Y] / weight
            tilts = max(zero, moments[k, i, TILTS] / weight - n_x * n_x - n_y * n_y)
            share = min(one, tilts / of_normals) if of_normals > zero else zero
            if of_lobes > zero:
                lobes = moments[k, i, SQUARES] / weight - mean * mean - d_x * d_x - d_y * d_y
                share *= min(one, max(zero, lobes) / of_lobes)
            # G's part, times the lobe, times that part again.
            p, q, r = one + share * (g_x - one), share * g_y, one + share * (g_z - one)
            xx, yy = mean + d_x, mean - d_x
            u_x, u_y = p * xx + q * d_y, p * d_y + q * yy
            v_x, v_y = q * xx + r * d_y, q * d_y + r * yy
            xx, xy, yy = u_x * p + u_y * q, u_x * q + u_y * r, v_x * q + v_y * r
            mean, d_x, d_y = half * (xx + yy), half * (xx - yy), xy
            turn = np.sqrt(d_x * d_x + d_y * d_y)
            wide, narrow = min(one, mean + turn), min(one, max(least, mean - turn))
            roughness[k, i, 0] = np.sqrt(np.sqrt(half * (wide * wide + narrow * narrow)))
            length = (wide - narrow) / (wide + narrow)
            if turn > zero and length > ROUND:
                rotation[k, i, 0], rotation[k, i, 1] = d_x / turn * length, d_y / turn * length
            else:
                rotation[k, i, 0], rotation[k, i, 1] = ROUND, zero
            even = moments[k, i, EVEN] / weight * (one + share * (even_factor - one))
            preview[k, i, 0] = np.sqrt(min(one, max(least, even)))
