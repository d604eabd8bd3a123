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
    Floats32 = NDArray[np.float32]

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

OWN = 0.2
"""A yarn of which fewer texels show its color is mixed from others, and not judged by texels."""

TONE = 0.12
"""Most relative change of a color's luminance for one ΔE of lightness, where it is dark."""

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
    deviations = [asset.yarn(yarn, "colorDeviation") or 0.0 for yarn in asset.yarns]
    texels, sums, own, misplaced = _survey(asset, colors, np.array(deviations))
    where = f"{TEXTURE_DIR}/base_color.exr"
    for k, yarn in enumerate(asset.yarns):
        if not texels[k]:
            continue
        mean = sums[k] / texels[k]
        if np.abs(mean - colors[k]).max() > TOLERANCE:
            yield MEAN(
                f"{yarn} shows {_text(mean)} on average, stated is {_text(colors[k])}", where
            )
        if own[k] > OWN * texels[k] and misplaced[k] > MISPLACED * texels[k]:
            share = misplaced[k] / texels[k]
            yield PLACE(f"{share:.1%} of {yarn} show the color of another yarn", where)


def _survey(
    asset: OpenAsset, colors: Doubles, deviations: Doubles
) -> tuple[Doubles, Doubles, Doubles, Doubles]:
    """Return for each yarn its texels looked at, the sum of their colors, and how many show it.

    Those that show its color, and those that show another's: a tone of a color, three
    `deviations` lighter or darker, is that color. Shapes are (Y,), (Y, 3), (Y,) and (Y,).
    """
    count = len(colors)
    distinct = np.unique(colors, axis=0).astype(np.float32)
    texels, sums = np.zeros(count), np.zeros((count, 3))
    shares = np.zeros((2, count))
    spread = np.clip(3 * TONE * deviations, 0, 0.7).astype(np.float32)
    for band in asset.textures.bands("base_color.exr", "yarn_id.png"):
        ids = band.pixels["yarn_id.png"][::STEP, ::STEP, 0].ravel().astype(np.intp) - 1
        shown = band.pixels["base_color.exr"][::STEP, ::STEP].reshape(-1, 3).astype(np.float32)
        known = (ids >= 0) & (ids < count)
        ids, shown = ids[known], shown[known]
        texels += np.bincount(ids, minlength=count)
        for channel in range(3):
            sums[:, channel] += np.bincount(ids, weights=shown[:, channel], minlength=count)
        if len(distinct) <= MAX_COLORS:
            own = colors.astype(np.float32)[ids]
            away = _from_tones(shown, own, spread[ids])
            wrong = np.zeros(len(ids), dtype=bool)
            for other in distinct:
                apart = np.square(own - other).sum(axis=1) > DISTINCT**2
                wrong |= apart & (np.square(shown - other).sum(axis=1) < away)
            near = away < DISTINCT**2
            shares += [np.bincount(ids, weights=w, minlength=count) for w in (near, wrong)]
    return texels, sums, *shares


def _from_tones(shown: Floats32, own: Floats32, spread: Floats32) -> Floats32:
    """Return the squared distance (n,) of colors (n, 3) from the nearest tone of `own`."""
    squared = np.maximum(np.square(own).sum(axis=1), 1e-12)
    scale = np.clip((shown * own).sum(axis=1) / squared, 1 - spread, 1 + 2 * spread)
    return np.asarray(np.square(shown - scale[:, None] * own).sum(axis=1))


def _text(color: Doubles) -> str:
    return "(" + ", ".join(f"{component:.3f}" for component in color) + ")"
