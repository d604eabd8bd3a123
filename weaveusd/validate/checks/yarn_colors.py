"""Whether every yarn shows its own color."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

MEAN = Code("color-disagrees", Status.FAIL, "A yarn shows another color than its attribute states.")
PLACE = Code("color-misplaced", Status.FAIL, "Texels of a yarn show the color of another yarn.")

TOLERANCE = 0.02
"""Largest difference between the mean albedo of a yarn's texels and the attribute."""

DISTINCT = 0.1
"""Distance from which on two colors are told apart, beyond a yarn's own unevenness."""

MAX_COLORS = 16
"""With more colors, texels are not compared with those of other yarns."""

MISPLACED = 0.005
"""Share of a yarn's texels that may show another color."""

STEP = 2
"""Every second texel of every second row is looked at."""


@check(
    id="agreement/colors",
    why="A color texture that is shifted, or of another colorway, hides behind right geometry.",
    needs=("material", "textures"),
    codes=(MEAN, PLACE),
)
def yarn_colors(asset: OpenAsset) -> Iterator[Finding]:
    """Every yarn shows the color that its attribute states, and no other yarn's."""
    stated = [asset.yarn(yarn, "color") for yarn in asset.yarns]
    if not stated or any(color is None or len(color) != 3 for color in stated):
        return  # attribute/yarns reports it
    colors = np.array([tuple(color) for color in stated], dtype=np.float64)
    texels, sums, misplaced = _survey(asset, colors)
    where = f"{TEXTURE_DIR}/base_color.exr"
    for k, yarn in enumerate(asset.yarns):
        if not texels[k]:
            continue
        mean = sums[k] / texels[k]
        if np.abs(mean - colors[k]).max() > TOLERANCE:
            yield MEAN(
                f"{yarn} shows {_text(mean)} on average, stated is {_text(colors[k])}", where
            )
        if misplaced[k] > MISPLACED * texels[k]:
            share = misplaced[k] / texels[k]
            yield PLACE(f"{share:.1%} of {yarn} show the color of another yarn", where)


def _survey(asset: OpenAsset, colors: Doubles) -> tuple[Doubles, Doubles, Doubles]:
    """Return for each yarn its texels looked at, the sum of their colors, how many are misplaced.

    Shapes are (Y,), (Y, 3) and (Y,).
    """
    count = len(colors)
    distinct = np.unique(colors, axis=0)
    texels, sums, misplaced = np.zeros(count), np.zeros((count, 3)), np.zeros(count)
    for band in asset.textures.bands("base_color.exr", "yarn_id.png"):
        ids = band.pixels["yarn_id.png"][::STEP, ::STEP, 0].ravel().astype(np.intp) - 1
        shown = band.pixels["base_color.exr"][::STEP, ::STEP].reshape(-1, 3).astype(np.float32)
        known = (ids >= 0) & (ids < count)
        ids, shown = ids[known], shown[known]
        texels += np.bincount(ids, minlength=count)
        for channel in range(3):
            sums[:, channel] += np.bincount(ids, weights=shown[:, channel], minlength=count)
        if len(distinct) <= MAX_COLORS:
            own = colors.astype(np.float32)
            away = np.square(shown - own[ids]).sum(axis=1)
            wrong = np.zeros(len(ids), dtype=bool)
            for other in distinct.astype(np.float32):
                apart = np.square(own - other).sum(axis=1) > DISTINCT**2
                wrong |= apart[ids] & (np.square(shown - other).sum(axis=1) < away)
            misplaced += np.bincount(ids, weights=wrong, minlength=count)
    return texels, sums, misplaced


def _text(color: Doubles) -> str:
    return "(" + ", ".join(f"{component:.3f}" for component in color) + ")"
