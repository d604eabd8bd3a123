"""What yarns do within an area of cloth: moments of their frames, apart for warp and weft.

A yarn's frame follows from three numbers: the inclination u of its spine, the place X = sin v on
its section, and the twist ψ of its fibres. With ρ its thickness over its width and
w² = ρ² X² + 1 − X²,

    n = (ρ X/w, cos v/w · sin u, cos v/w · cos u)
    t = cos ψ (0, cos u, −sin u) − sin ψ (cos v/w, −ρ X/w · sin u, −ρ X/w · cos u)

in the frame x across the yarn, y along, z out of the cloth. Along a round bend sin u depends on X
too, S = sin u (1 + k cos v)/(1 + k) does not; k is the yarn's half thickness over the radius of
the bend. Means of S, S², X, X², ψ and ψ² over texels are linear: means over the whole follow from
means over the parts. Warp and weft are kept apart, and so are rising, flat and falling texels,
since a frame halfway between two of them is the frame of nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]
    Doubles = NDArray[np.float64]

FLAT, RISE, RISE_S, RISE_SS, FALL, FALL_S, FALL_SS, X, XX, TWIST, TWIST2 = range(11)
COLOR = 11
MOMENTS = 14
"""Sums kept of a system: shares of flat, rising and falling texels, S and S² of the latter two,
X, X², ψ, ψ², and the albedo, all times the opacity."""

SYSTEMS = 2
"""Warp and weft, in this order."""

FLATTEST = 1e-3
"""A texel with a smaller |S| is flat."""

_TEXELS = 1 << 17
"""Texels looked at together."""

_SAMPLE = 1 << 16
_STRIDE = 1000003
"""A prime, so that the sample lies all over the texels."""


@dataclass(frozen=True, slots=True, eq=False)
class Threads:
    """What the textures do not say of the yarns: which are weft, and how flat they are."""

    is_weft: NDArray[np.bool_]  # (yarns,)
    flatness: Floats  # (yarns,) ρ, thickness over width


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """Sums over the texels of every cell, and what warp and weft have in common everywhere."""

    sums: Doubles  # (rows, columns, systems, MOMENTS)
    texels: Doubles  # (rows, columns) number of texels
    bend: tuple[float, float]  # k of warp and weft
    flatness: tuple[float, float]  # ρ of warp and weft


def moments(
    arrays: Mapping[str, NDArray[Any]], threads: Threads, cells: tuple[int, int]
) -> Moments:
    """Return the moments of a cloth in cells, (rows, columns) of them, none without a texel.

    `arrays` are the channels that `packing.pack` takes, (H, W, components), valid, row 0 at v = 0.
    """
    height, width = arrays["normal"].shape[:2]
    rows, columns = cells
    if not (1 <= rows <= height and 1 <= columns <= width):
        raise ValueError(f"cells {rows} x {columns}, expected 1 to {height} x {width}")
    flatness, bend = _shapes(arrays, threads)
    across = np.arange(columns) * width // columns
    starts = np.arange(rows + 1) * height // rows
    owner = np.repeat(np.arange(rows), np.diff(starts))
    sums = np.zeros((rows, columns, SYSTEMS, MOMENTS))
    step = max(1, _TEXELS // width)
    for first in range(0, height, step):
        band = slice(first, first + step)
        texels = _texels({name: a[band] for name, a in arrays.items()}, threads, flatness, bend)
        touched, begins = np.unique(owner[band], return_index=True)
        tall = np.add.reduceat(texels, begins, axis=0)
        sums[touched] += np.add.reduceat(tall, across, axis=1)
    counts = np.diff(starts)[:, None] * np.diff(np.append(across, width))[None, :]
    return Moments(sums, counts.astype(np.float64), bend, flatness)


def coarser(fine: Moments) -> Moments:
    """Return the moments in cells of about two by two, exact since moments are linear."""
    rows, columns = fine.texels.shape
    down = np.arange(max(1, rows // 2)) * rows // max(1, rows // 2)
    across = np.arange(max(1, columns // 2)) * columns // max(1, columns // 2)
    sums = np.add.reduceat(np.add.reduceat(fine.sums, down, axis=0), across, axis=1)
    texels = np.add.reduceat(np.add.reduceat(fine.texels, down, axis=0), across, axis=1)
    return Moments(sums, texels, fine.bend, fine.flatness)


def _texels(
    arrays: Mapping[str, NDArray[Any]],
    threads: Threads,
    flatness: Sequence[float],
    bend: Sequence[float],
) -> Doubles:
    """Return what each texel adds to the sums, (H, W, systems, MOMENTS)."""
    yarn = np.rint(_single(arrays["yarn_id"])).astype(np.intp)
    opacity = np.where(yarn < 0, 0, _single(arrays["opacity"])).astype(np.float64)
    out = np.zeros((*yarn.shape, SYSTEMS, MOMENTS))
    for system in range(SYSTEMS):
        of = (yarn >= 0) & (threads.is_weft[yarn] == bool(system))
        sin_u, x, twist = _invert(arrays["normal"][of], arrays["tangent"][of], system, flatness)
        k = bend[system]
        s = sin_u * (1 + k * np.sqrt(1 - x * x)) / (1 + k)
        rise, fall = s > FLATTEST, s < -FLATTEST
        color = np.asarray(arrays["base_color"], np.float64)[of]
        values = np.stack(
            [~(rise | fall), rise, rise * s, rise * s * s, fall, fall * s, fall * s * s,
             x, x * x, twist, twist * twist, *color.T], -1,
        )  # fmt: skip
        out[of, system] = values * opacity[of][:, None]
    return out


def _invert(
    normal: NDArray[Any], tangent: NDArray[Any], system: int, flatness: Sequence[float]
) -> tuple[Doubles, Doubles, Doubles]:
    """Return sin u, X and ψ of frames (N, 3) in the cloth's frame."""
    n, t = (_in_yarn(np.asarray(v, np.float64), system) for v in (normal, tangent))
    # A yarn looks the same with its fibre reversed.
    t = t * np.where(t[:, 1:2] < 0, -1, 1)
    level = np.maximum(np.hypot(n[:, 1], n[:, 2]), 1e-9)
    sin_u, cos_u = n[:, 1] / level, n[:, 2] / level
    side = np.clip(n[:, 0], -1, 1)
    up = np.sqrt(1 - side**2)
    rho = flatness[system]
    x = side / np.maximum(np.hypot(side, rho * up), 1e-9)
    along = t[:, 1] * cos_u - t[:, 2] * sin_u
    around = t[:, 0] * up - side * (t[:, 1] * sin_u + t[:, 2] * cos_u)
    return sin_u, np.clip(x, -1, 1), np.arctan2(-around, along)


def _in_yarn(vectors: Doubles, system: int) -> Doubles:
    """Return vectors (N, 3) of the cloth's frame in that of the yarns of a system."""
    if system == 0:
        return vectors
    return np.stack([-vectors[:, 1], vectors[:, 0], vectors[:, 2]], -1)


def _shapes(
    arrays: Mapping[str, NDArray[Any]], threads: Threads
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return ρ and k of warp and weft, from a sample of texels.

    ρ is the mean over the texels of a system. k is that with which S² and cos v are uncorrelated.
    """
    yarn = np.rint(_single(arrays["yarn_id"])).astype(np.intp).ravel()
    sample = np.unique(np.arange(min(yarn.size, _SAMPLE)) * _STRIDE % yarn.size)
    normal, tangent = (arrays[name].reshape(-1, 3) for name in ("normal", "tangent"))
    rho, bend = [1.0, 1.0], [0.0, 0.0]
    for system in range(SYSTEMS):
        of = sample[(yarn[sample] >= 0) & (threads.is_weft[yarn[sample]] == bool(system))]
        if not of.size:
            continue
        rho[system] = float(np.mean(threads.flatness[yarn[of]], dtype=np.float64))
        sin_u, x, _ = _invert(normal[of], tangent[of], system, rho)
        bend[system] = _bend(sin_u, np.sqrt(1 - x * x))
    return (rho[0], rho[1]), (bend[0], bend[1])


def _bend(sin_u: Doubles, cos_v: Doubles) -> float:
    bent = np.abs(sin_u) > 0.02
    if np.count_nonzero(bent) < 16:
        return 0.0
    square, cosine = sin_u[bent] ** 2, cos_v[bent] - np.mean(cos_v[bent])
    low, high = 0.0, 8.0
    for _ in range(30):
        k = 0.5 * (low + high)
        tilt = np.mean(square * ((1 + k * cos_v[bent]) / (1 + k)) ** 2 * cosine)
        low, high = (k, high) if tilt < 0 else (low, k)
    return 0.5 * (low + high)


def _single(array: NDArray[Any]) -> NDArray[Any]:
    return array[..., 0] if array.ndim == 3 else array
