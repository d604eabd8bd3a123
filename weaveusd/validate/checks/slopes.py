"""Whether normals are those of the surface that the heights describe."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.compiled import compiled
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import HALVES, Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.validate.textures import Floats32, Words

    Bytes = NDArray[np.uint8]
    Rows = tuple[NDArray[Any], ...]  # heights, normals, yarn ids, opacities

DISAGREE = Code(
    "normal-not-of-height", Status.FAIL, "Normals do not lean down the slopes of the heights."
)
STEEP = Code(
    "normal-of-other-slope",
    Status.FAIL,
    "Normals of warp or weft lean by far more, or less, than the heights slope.",
)
COARSE = Code(
    "slopes-unread", Status.SKIP, "The textures are too coarse to tell the slopes of a yarn."
)

STEEPEST = 2.0
"""Slopes beyond this are left out: there one texel of height says little."""

FLAT = 1e-3
"""A surface whose root mean square slope is less has no direction to compare."""

REACH = 2
"""Texels on either side of one that is judged, all of its own yarn."""

AGREEMENT = 0.5
"""Least correlation: 1 for true normals, -1 for a flipped axis, 0 for exchanged ones."""

GAIN = (0.7, 1.4)
"""Least and largest lean of normals for one of the heights' slopes, at least squares."""

NAMES = ("warp", "weft")

TEXELS_PER_THREAD = 12
"""Coarser textures step over the borders between threads of one yarn."""

FEWEST = 0.02
"""Least share of texels, two or more away from the border of their yarn, that is judged."""


@check(
    id="texture/slopes",
    why="A flipped or turned normal map lights every yarn from the wrong side, and looks almost "
    "right.",
    needs=("material", "textures"),
    codes=(DISAGREE, STEEP, COARSE),
)
class Slopes:
    """Normals lean down the slopes of the height texture, along both axes."""

    def __init__(self, asset: OpenAsset) -> None:
        self._asset = asset
        self._repeat_mm = asset.cloth("repeatWidth"), asset.cloth("repeatHeight")
        header = asset.textures.header("height.exr")
        self._size = header.width, header.height
        self._stated = all(isinstance(size, float) and size > 0 for size in self._repeat_mm)
        # Squares from heights, from normals, products; x then y, of warp, weft and others.
        self._sums = np.zeros((2, 3, 3))
        self._judged = np.zeros((2, 3), np.int64)
        self._system = np.full(256, 2, np.int64)
        for number, yarn in enumerate(asset.yarns, start=1):
            system = asset.yarn(yarn, "system")
            self._system[number] = NAMES.index(system) if system in NAMES else 2
        self._texels = 0
        self._above: Rows | None = None  # the last rows of the band before

    def look(self, band: Band) -> None:
        """Compare the slopes of the band, and of the rows on both sides of its upper edge."""
        if not self._stated:
            return
        pixels = band.pixels
        rows = (
            band.words("height.exr"), band.words("normal.exr"),
            pixels["yarn_id.png"], pixels["opacity.png"],
        )  # fmt: skip
        self._add(0, rows)
        self._add(1, rows)
        if self._above is not None:
            both = zip(self._above, rows, strict=True)
            self._add(1, tuple(np.concatenate([a, b[: 2 * REACH]]) for a, b in both))
        self._above = tuple(here[-2 * REACH :].copy() for here in rows)
        self._texels += pixels["yarn_id.png"].size

    def _add(self, axis: int, rows: Rows) -> None:
        # Image rows run against y.
        step = (1, -1)[axis] * self._repeat_mm[axis] / self._size[axis]
        _compare(
            axis, np.float32(2 * step), *rows, HALVES, self._system,
            self._sums[axis], self._judged[axis],
        )  # fmt: skip

    def findings(self) -> Iterator[Finding]:
        """Report the axes along which they do not agree."""
        if not self._stated:
            return  # attribute/cloth reports it
        for axis, name in enumerate("xy"):
            judged = self._judged[axis].sum()
            coarse = self._asset.texels_per_thread[axis] < TEXELS_PER_THREAD
            if coarse or judged < FEWEST * self._texels:
                yield COARSE(f"there are too few texels for each thread along {name}")
                continue
            yield from self._directions(axis, name, self._sums[axis].sum(axis=0), int(judged))

    def _directions(
        self, axis: int, name: str, sums: NDArray[np.float64], judged: int
    ) -> Iterator[Finding]:
        """Judge the slopes along one axis, of all yarns and then of each system."""
        where = f"{TEXTURE_DIR}/normal.exr"
        from_height, from_normal, both = sums
        if from_height < FLAT**2 * judged:
            return
        correlation = both / max(np.sqrt(from_height * from_normal), np.finfo(float).tiny)
        if correlation < AGREEMENT:
            yield DISAGREE(
                f"slopes along {name} correlate with the heights' by {correlation:.2f}, "
                f"expected at least {AGREEMENT}",
                where,
            )
            return
        for k, system in enumerate(NAMES):
            from_height, _, both = self._sums[axis, k]
            own = self._judged[axis, k]
            if own < FEWEST * self._texels or from_height < FLAT**2 * own:
                continue
            if not GAIN[0] <= both / from_height <= GAIN[1]:
                yield STEEP(
                    f"the {system} leans along {name} by {both / from_height:.2f} of the heights' "
                    f"slopes, expected {GAIN[0]} to {GAIN[1]}",
                    where,
                )


@compiled
def _compare(
    axis: int,
    distance: np.float32,
    heights: Words,
    normals: Words,
    ids: Bytes,
    opacities: Bytes,
    table: Floats32,
    systems: NDArray[np.int64],
    sums: NDArray[np.float64],
    judged: NDArray[np.int64],
) -> None:
    """Add the slopes along `axis`, 0 for x, of the heights and as the normals have them.

    `distance` is that of the texels before and after one, in mm along the axis. Texels count
    that have two of their own yarn on either side; hairs, half transparent, have no surface.
    """
    down, right = axis, 1 - axis
    steepest = np.float32(STEEPEST)
    for row in range(REACH * down, ids.shape[0] - REACH * down):
        for column in range(REACH * right, ids.shape[1] - REACH * right):
            number = ids[row, column, 0]
            inside = number > 0
            for k in range(-REACH, REACH + 1):
                r, c = row + k * down, column + k * right
                if ids[r, c, 0] != number or opacities[r, c, 0] != 255:
                    inside = False
                    break
            if not inside:
                continue
            before = table[heights[row - down, column - right, 0]]
            after = table[heights[row + down, column + right, 0]]
            expected = (after - before) / distance
            lean, up = table[normals[row, column, axis]], table[normals[row, column, 2]]
            if abs(lean) < steepest * up and abs(expected) < steepest:
                found = -lean / up
                system = systems[number]
                sums[system, 0] += np.float64(expected) * expected
                sums[system, 1] += np.float64(found) * found
                sums[system, 2] += np.float64(expected) * found
                judged[system] += 1
