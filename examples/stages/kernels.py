"""The loops of the relaxation, compiled; see relax.py for what they mean."""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit

PLANE, ELLIPSOID, BOX = 0, 1, 2


@njit(cache=True)
def advance(
    p, v, rest, triangles, slopes, areas, hinges, weights, spans, w, colliders, friction, stiffness,
    steps, dt, conditions,
):  # fmt: skip
    """Step positions `p` and velocities `v` (V, 3), in place."""
    gravity, drag, pressure, volume, apart = conditions
    before = np.empty_like(p)
    for step in range(steps):
        if pressure > 0:
            _inflate(p, v, w, triangles, pressure, volume, dt)
        for i in range(len(p)):
            for k in range(3):
                before[i, k] = p[i, k]
            if w[i] > 0:
                v[i, 1] -= gravity * dt
                for k in range(3):
                    p[i, k] += v[i, k] * dt
        # A sweep favors whom it meets last, so every other one runs backwards.
        forward = step % 2 == 0
        _stretch(p, w, triangles, slopes, areas, stiffness, dt, forward)
        _bend(p, w, hinges, weights, spans, stiffness[2], dt, forward)
        if apart > 0:
            _keep_apart(p, rest, w, apart)
        _collide(p, before, w, colliders, friction)
        keep = max(0.0, 1 - drag * dt) / dt
        for i in range(len(p)):
            for k in range(3):
                v[i, k] = (p[i, k] - before[i, k]) * keep


@njit(cache=True)
def _inflate(p, v, w, triangles, pressure, volume, dt):
    """Push every triangle outwards."""
    now = 0.0
    for a, b, c in triangles:
        now += (
            p[a, 0] * (p[b, 1] * p[c, 2] - p[b, 2] * p[c, 1])
            + p[a, 1] * (p[b, 2] * p[c, 0] - p[b, 0] * p[c, 2])
            + p[a, 2] * (p[b, 0] * p[c, 1] - p[b, 1] * p[c, 0])
        )
    now /= 6
    push = pressure * min(volume / max(now, 0.02 * volume) - 1, 1.0)
    if push <= 0:
        return
    for t in triangles:
        a, b, c = t
        for k in range(3):
            m, n = (k + 1) % 3, (k + 2) % 3
            force = (
                push / 6 * ((p[b, m] - p[a, m]) * (p[c, n] - p[a, n])
                            - (p[b, n] - p[a, n]) * (p[c, m] - p[a, m]))
            )  # fmt: skip
            for i in t:
                v[i, k] += force * w[i] * dt


@njit(cache=True)
def _stretch(p, w, triangles, slopes, areas, stiffness, dt, forward):
    """Mend stretch along weft and warp, then shear, triangle by triangle."""
    count = len(triangles)
    for step in range(count):
        f = step if forward else count - 1 - step
        a, b, c = triangles[f]
        soft = 1 / (areas[f] * stiffness[0] * dt * dt)
        for k in range(2):
            sb, sc = slopes[f, 0, k], slopes[f, 1, k]
            sa = -sb - sc
            gx = sa * p[a, 0] + sb * p[b, 0] + sc * p[c, 0]
            gy = sa * p[a, 1] + sb * p[b, 1] + sc * p[c, 1]
            gz = sa * p[a, 2] + sb * p[b, 2] + sc * p[c, 2]
            length = sqrt(gx * gx + gy * gy + gz * gz)
            yielding = w[a] * sa * sa + w[b] * sb * sb + w[c] * sc * sc + soft
            move = -(length - 1) / (yielding * max(length, 1e-9))
            for i, s in ((a, sa), (b, sb), (c, sc)):
                p[i, 0] += w[i] * s * move * gx
                p[i, 1] += w[i] * s * move * gy
                p[i, 2] += w[i] * s * move * gz
        _shear(p, w, a, b, c, slopes[f], 1 / (areas[f] * stiffness[1] * dt * dt))


@njit(cache=True)
def _shear(p, w, a, b, c, slope, soft):
    """Mend the angle between weft and warp in one triangle."""
    ub, uc, vb, vc = slope[0, 0], slope[1, 0], slope[0, 1], slope[1, 1]
    ua, va = -ub - uc, -vb - vc
    along = 0.0
    sizes = [0.0, 0.0, 0.0]
    for k in range(3):
        gu = ua * p[a, k] + ub * p[b, k] + uc * p[c, k]
        gv = va * p[a, k] + vb * p[b, k] + vc * p[c, k]
        along += gu * gv
        sizes[0] += (ua * gv + va * gu) ** 2
        sizes[1] += (ub * gv + vb * gu) ** 2
        sizes[2] += (uc * gv + vc * gu) ** 2
    move = -along / (w[a] * sizes[0] + w[b] * sizes[1] + w[c] * sizes[2] + soft)
    for k in range(3):
        gu = ua * p[a, k] + ub * p[b, k] + uc * p[c, k]
        gv = va * p[a, k] + vb * p[b, k] + vc * p[c, k]
        p[a, k] += w[a] * move * (ua * gv + va * gu)
        p[b, k] += w[b] * move * (ub * gv + vb * gu)
        p[c, k] += w[c] * move * (uc * gv + vc * gu)


@njit(cache=True)
def _bend(p, w, hinges, weights, spans, stiffness, dt, forward):
    """Flatten every hinge."""
    if stiffness <= 0:
        return
    count = len(hinges)
    for step in range(count):
        e = step if forward else count - 1 - step
        soft = spans[e] / (stiffness * dt * dt)
        yielding = soft
        for j in range(4):
            yielding += w[hinges[e, j]] * weights[e, j] * weights[e, j]
        for k in range(3):
            bend = 0.0
            for j in range(4):
                bend += weights[e, j] * p[hinges[e, j], k]
            move = -bend / yielding
            for j in range(4):
                i = hinges[e, j]
                p[i, k] += w[i] * weights[e, j] * move


@njit(cache=True)
def _collide(p, before, w, colliders, friction):
    """Push vertices out of what is solid, and hold them back where they touch it."""
    for i in range(len(p)):
        if w[i] == 0:
            continue
        for row in colliders:
            depth, nx, ny, nz = _depth(p[i], row)
            if depth <= 0:
                continue
            n = (nx, ny, nz)
            inward = 0.0
            for k in range(3):
                p[i, k] += depth * n[k]
                inward += (p[i, k] - before[i, k]) * n[k]
            slip = 0.0
            for k in range(3):
                slip += (p[i, k] - before[i, k] - inward * n[k]) ** 2
            slip = sqrt(slip)
            if slip > 0:
                held = min(1.0, friction * depth / slip)
                for k in range(3):
                    p[i, k] -= held * (p[i, k] - before[i, k] - inward * n[k])


@njit(cache=True)
def _depth(point, row):
    """Return how deep a point is in a collider, and the way out."""
    if row[0] == PLANE:
        return row[2] - point[1], 0.0, 1.0, 0.0
    x, y, z = point[0] - row[1], point[1] - row[2], point[2] - row[3]
    # Rows of the rotation are the collider's axes.
    a = row[7] * x + row[8] * y + row[9] * z
    b = row[10] * x + row[11] * y + row[12] * z
    c = row[13] * x + row[14] * y + row[15] * z
    h, i, j = row[4], row[5], row[6]
    if row[0] == ELLIPSOID:
        far = sqrt((a / h) ** 2 + (b / i) ** 2 + (c / j) ** 2)
        if far >= 1 or far == 0:
            return 0.0, 0.0, 0.0, 0.0
        na, nb, nc = a / (h * h), b / (i * i), c / (j * j)
        steep = sqrt(na * na + nb * nb + nc * nc)
        depth = (1 - far) * far / steep
        na, nb, nc = na / steep, nb / steep, nc / steep
    else:
        da, db, dc = h - abs(a), i - abs(b), j - abs(c)
        depth = min(da, db, dc)
        if depth <= 0:
            return 0.0, 0.0, 0.0, 0.0
        na, nb, nc = 0.0, 0.0, 0.0
        if depth == da:
            na = 1.0 if a > 0 else -1.0
        elif depth == db:
            nb = 1.0 if b > 0 else -1.0
        else:
            nc = 1.0 if c > 0 else -1.0
    return (
        depth,
        row[7] * na + row[10] * nb + row[13] * nc,
        row[8] * na + row[11] * nb + row[14] * nc,
        row[9] * na + row[12] * nb + row[15] * nc,
    )


@njit(cache=True)
def _cell(x, y, z, size):
    return ((x * 92837111) ^ (y * 689287499) ^ (z * 283923481)) % size


@njit(cache=True)
def _keep_apart(p, rest, w, apart):
    """Push vertices of different folds apart, found through a grid of cells `apart` wide."""
    count = len(p)
    size = 2 * count
    cells = np.floor(p / apart).astype(np.int64)
    starts = np.zeros(size + 1, np.int64)
    home = np.empty(count, np.int64)
    for i in range(count):
        home[i] = _cell(cells[i, 0], cells[i, 1], cells[i, 2], size)
        starts[home[i]] += 1
    for k in range(size):
        starts[k + 1] += starts[k]
    members = np.empty(count, np.int64)
    for i in range(count):
        starts[home[i]] -= 1
        members[starts[home[i]]] = i
    for i in range(count):
        for dx in range(-1, 2):
            for dy in range(-1, 2):
                for dz in range(-1, 2):
                    k = _cell(cells[i, 0] + dx, cells[i, 1] + dy, cells[i, 2] + dz, size)
                    for m in range(starts[k], starts[k + 1]):
                        if members[m] > i:
                            _part(p, rest, w, i, members[m], apart)


@njit(cache=True)
def _part(p, rest, w, i, j, apart):
    """Push two vertices to their least distance."""
    gap = (p[i, 0] - p[j, 0]) ** 2 + (p[i, 1] - p[j, 1]) ** 2 + (p[i, 2] - p[j, 2]) ** 2
    if gap >= apart * apart or gap == 0 or w[i] + w[j] == 0:
        return
    first = 0.0
    for k in range(3):
        first += (rest[i, k] - rest[j, k]) ** 2
    if gap >= first:
        return
    least = min(apart, sqrt(first))
    length = sqrt(gap)
    push = (least - length) / (length * (w[i] + w[j]))
    for k in range(3):
        way = (p[i, k] - p[j, k]) * push
        p[i, k] += w[i] * way
        p[j, k] -= w[j] * way
