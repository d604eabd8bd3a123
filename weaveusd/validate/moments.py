"""The judge's own statement of a texel's moments, from docs/distance.md.

Neither the makers' kernel nor the renderer's is used here. A map is judged by what is left of it
once every texel of the textures has been taken off: nothing, but for rounding.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import MOMENT_MAPS
from weaveusd.validate.compiled import compiled
from weaveusd.validate.textures import HALVES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.validate.textures import Band, Floats32, Words

    Bytes = NDArray[np.uint8]
    Doubles = NDArray[np.float64]
    Members = NDArray[np.int64]

OTHER_KIND, OTHER_SYSTEM = 4, -1
"""Members: a yarn whose kind has no component of its own, and one of the other system."""

STRAIGHT = 1e-3
"""|S| up to which a yarn is straight."""

NEAR_STRAIGHT = 2.0**-7
"""Relative distance to `STRAIGHT` within which rounded frames do not tell the class."""

SMALLEST = 2.0**-24
"""Components of half floats that are very small are off by up to half of this."""

NEAR_ACROSS = 2.0**-8
"""Cosine of a fibre to its yarn below which rounded frames do not tell which end is ahead."""

CHANNELS = 4 * len(MOMENT_MAPS)


class Remainder:
    """What is left of the maps of one system; rows count from the image's top.

    `maps` is (h, w, 4 for each of `contract.MOMENT_MAPS`), zeros where there is no map. `members`
    says for each id of a texel, (256,), which component of the map of kinds its yarn adds to.
    `left` ends as zeros but for rounding. `loose`, (h, w), is what rounded frames leave open.
    """

    def __init__(
        self,
        maps: Floats32,
        *,
        is_weft: bool,
        section: tuple[float, float],
        members: Members,
        gains: Doubles,
    ) -> None:
        self.left = np.array(maps, np.float32)
        self.loose = np.zeros(maps.shape[:2], np.float32)
        self._is_weft, self._section = is_weft, np.array(section, np.float64)
        self._members, self._gains = members, gains
        self._texel = np.zeros(CHANNELS)

    def take_off(self, band: Band, height: int) -> None:
        """Take off the texels of a band of textures of `height` rows in all."""
        _take_off(
            band.first, height, self._is_weft, self._section, self._members, self._gains,
            band.pixels["yarn_id.png"], band.pixels["opacity.png"],
            band.words("normal.exr"), band.words("tangent.exr"), band.words("base_color.exr"),
            HALVES, self._texel, self.left, self.loose,
        )  # fmt: skip


@compiled
def _fill(
    a: float,
    n: tuple[float, float, float],
    t: tuple[float, float, float],
    flatness: float,
    curvature: float,
    texel: Doubles,
) -> float:
    """Fill in the first twelve means of a texel of opacity `a`; return what rounding leaves open.

    With n and t in the yarn's frame (x across, y along, z up), ρ and k its section,

        X = n_x / √(n_x² + ρ² up²)     up² = n_y² + n_z²     sin u = n_y / up
        S = sin u (1 + k √(1 − X²)) / (1 + k)
        P = −(t_x up − n_x (t_y sin u + t_z cos u)), the fibre turned so that it leads ahead.
    """
    up = max(math.sqrt(n[1] * n[1] + n[2] * n[2]), 1e-12)
    sin_u, cos_u = n[1] / up, n[2] / up
    x = n[0] / math.sqrt(n[0] * n[0] + flatness * flatness * up * up)
    s = sin_u * (1 + curvature * math.sqrt(max(1 - x * x, 0.0))) / (1 + curvature)
    ahead = t[1] * cos_u - t[2] * sin_u
    p = -(t[0] * up - n[0] * (t[1] * sin_u + t[2] * cos_u))
    if ahead < 0:
        p = -p
    rising, falling = 0.0, 0.0
    if s > STRAIGHT:
        rising = a
    elif s < -STRAIGHT:
        falling = a
    texel[0], texel[1], texel[2], texel[3] = a - rising - falling, rising, falling, a * x
    texel[4], texel[5] = rising * s, rising * s * s
    texel[6], texel[7] = falling * s, falling * s * s
    texel[8], texel[9], texel[10], texel[11] = a * abs(x), a * x * x, a * p, a * p * p
    unclear = 0.0
    if abs(abs(s) - STRAIGHT) < NEAR_STRAIGHT * STRAIGHT + SMALLEST / up:
        unclear += a
    if abs(ahead) < NEAR_ACROSS:
        unclear += 2 * a
    return unclear


@compiled
def _take_off(
    first: int,
    height: int,
    is_weft: bool,
    section: Doubles,
    members: Members,
    gains: Doubles,
    ids: Bytes,
    opacities: Bytes,
    normals: Words,
    tangents: Words,
    colors: Words,
    table: Floats32,
    texel: Doubles,
    left: Floats32,
    loose: Floats32,
) -> None:
    """Take what each texel adds to the means off `left`; `first` is the image row of row 0.

    Its albedo A is the base color times the yarn's gain, at most 1. A texel lies in up to four
    texels of the map, in each with the share of its area.
    """
    rows, columns = left.shape[0], left.shape[1]
    width = ids.shape[1]
    for j in range(ids.shape[0]):
        row = (first + j) * rows // height
        above = min(rows, (row + 1) * height - (first + j) * rows)
        for i in range(width):
            number = ids[j, i, 0]
            member = members[number]
            if member == OTHER_SYSTEM or opacities[j, i, 0] == 0:
                continue
            a = opacities[j, i, 0] / 255.0
            n_x, n_y = np.float64(table[normals[j, i, 0]]), np.float64(table[normals[j, i, 1]])
            t_x, t_y = np.float64(table[tangents[j, i, 0]]), np.float64(table[tangents[j, i, 1]])
            if is_weft:
                n_x, n_y = -n_y, n_x
                t_x, t_y = -t_y, t_x
            n = n_x, n_y, np.float64(table[normals[j, i, 2]])
            t = t_x, t_y, np.float64(table[tangents[j, i, 2]])
            texel[:] = 0
            unclear = _fill(a, n, t, section[0], section[1], texel)
            for k in range(3):
                texel[12 + k] = a * min(table[colors[j, i, k]] * gains[number], 1.0)
            texel[15] = a
            if member != OTHER_KIND:
                texel[16 + member] = a

            column = i * columns // width
            before = min(columns, (column + 1) * width - i * columns)
            for k in range(4):
                down, right = k // 2, k % 2
                tall = rows - above if down else above
                wide = columns - before if right else before
                if tall == 0 or wide == 0:
                    continue
                weight = tall / height * (wide / width)
                for c in range(texel.shape[0]):
                    left[row + down, column + right, c] -= weight * texel[c]
                loose[row + down, column + right] += weight * unclear
