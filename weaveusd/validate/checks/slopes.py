"""Whether normals are those of the surface that the heights describe."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.checks._texels import SOLID, solid_ids
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats32 = NDArray[np.float32]

DISAGREE = Code(
    "normal-not-of-height", Status.FAIL, "Normals do not lean down the slopes of the heights."
)
COARSE = Code(
    "slopes-unread", Status.SKIP, "The textures are too coarse to tell the slopes of a yarn."
)

STEEPEST = 2.0
"""Slopes beyond this are left out: there one texel of height says little."""

FLAT = 1e-3
"""A surface whose root mean square slope is less has no direction to compare."""

AGREEMENT = 0.5
"""Least correlation: 1 for true normals, -1 for a flipped axis, 0 for exchanged ones."""

TEXELS_PER_THREAD = 12
"""Coarser textures step over the borders between threads of one yarn."""

FEWEST = 0.02
"""Least share of texels, two or more away from the border of their yarn, that is judged."""


@check(
    id="texture/slopes",
    why="A flipped or turned normal map lights every yarn from the wrong side, and looks almost "
    "right.",
    needs=("material", "textures"),
    codes=(DISAGREE, COARSE),
)
def slopes(asset: OpenAsset) -> Iterator[Finding]:
    """Normals lean down the slopes of the height texture, along both axes."""
    header = asset.textures.header("height.exr")
    repeat = asset.cloth("repeatWidth"), asset.cloth("repeatHeight")
    if not all(isinstance(size, float) and size > 0 for size in repeat):
        return  # attribute/cloth reports it
    texel_mm = repeat[0] / header.width, repeat[1] / header.height
    sums = np.zeros((2, 3))
    texels, judged = 0, np.zeros(2)
    for band in asset.textures.bands("height.exr", "normal.exr", *SOLID):
        for axis, (expected, found) in enumerate(_pairs(band, texel_mm)):
            sums[axis] += expected @ expected, found @ found, expected @ found
            judged[axis] += len(expected)
        texels += band.pixels["yarn_id.png"].size
    for axis, name in enumerate("xy"):
        from_height, from_normal, both = sums[axis]
        if asset.texels_per_thread[axis] < TEXELS_PER_THREAD or judged[axis] < FEWEST * texels:
            yield COARSE(f"there are too few texels for each thread along {name}")
            continue
        if from_height < FLAT**2 * judged[axis]:
            continue
        correlation = both / max(np.sqrt(from_height * from_normal), np.finfo(float).tiny)
        if correlation < AGREEMENT:
            yield DISAGREE(
                f"slopes along {name} correlate with the heights' by {correlation:.2f}, "
                f"expected at least {AGREEMENT}",
                f"{TEXTURE_DIR}/normal.exr",
            )


def _pairs(band: Band, texel_mm: tuple[float, float]) -> Iterator[tuple[Floats32, Floats32]]:
    """Yield the slopes along x, then y, of the heights and as the normals have them.

    Only texels that have two of their own yarn on either side count.
    """
    height = band.pixels["height.exr"][..., 0].astype(np.float32)
    ids = solid_ids(band)
    normal = band.vectors("normal.exr")
    for axis, step in ((1, texel_mm[0]), (0, -texel_mm[1])):  # image rows run against y
        before2, before, here, after, after2 = _neighbors(axis)
        expected = (height[after] - height[before]) / np.float32(2 * step)
        lean, up = normal[here][..., 1 - axis], normal[here][..., 2]
        inside = (np.abs(lean) < STEEPEST * up) & (np.abs(expected) < STEEPEST) & (ids[here] > 0)
        for place in (before2, before, after, after2):
            inside &= ids[place] == ids[here]
        found = -lean[inside] / up[inside]
        yield expected[inside], found


def _neighbors(axis: int) -> list[tuple[slice, ...]]:
    """Return the indices of the texels -2, -1, 0, 1 and 2 from each inner texel of `axis`."""
    cuts = [slice(start, stop) for start, stop in enumerate((-4, -3, -2, -1, None))]
    return [(cut,) if axis == 0 else (slice(None), cut) for cut in cuts]
