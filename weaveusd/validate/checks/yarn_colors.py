"""Whether every yarn shows its own color."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

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

    Doubles = NDArray[np.float64]

MEAN = Code("color-disagrees", Status.FAIL, "A yarn shows another color than its attribute states.")
PLACE = Code("color-misplaced", Status.FAIL, "Texels of a yarn show the color of another yarn.")

TOLERANCE = 0.02
"""Largest difference between the mean albedo of a yarn's many texels and the attribute."""

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

STEP, WIDE = 2, 512
"""Every second texel of every second row is looked at, where the textures are so wide."""


@check(
    id="agreement/colors",
    why="A color texture that is shifted, or of another colorway, hides behind right geometry.",
    needs=("material", "textures"),
    codes=(MEAN, PLACE),
)
class YarnColors:
    """Every yarn shows the color that its attribute states, and no other yarn's."""

    def __init__(self, asset: OpenAsset) -> None:
        self._yarns = asset.yarns
        stated = [asset.yarn(yarn, "color") for yarn in asset.yarns]
        self._known = bool(stated) and all(color is not None for color in stated)
        if not self._known:
            return
        self._colors = np.array([tuple(color) for color in stated], dtype=np.float64)
        distinct = np.unique(self._colors, axis=0).astype(np.float32)
        self._own = self._colors.astype(np.float32)
        self._others = distinct if len(distinct) <= MAX_COLORS else distinct[:0]
        # A tone of a color, three deviations lighter or darker, is that color.
        deviations = [asset.yarn(yarn, "colorDeviation") or 0.0 for yarn in asset.yarns]
        self._spread = np.clip(3 * TONE * np.array(deviations), 0, 0.7).astype(np.float32)
        self._counts = np.zeros((3, len(stated)), np.int64)  # looked at, own color, another's
        self._sums = np.zeros((len(stated), 3))

    def look(self, band: Band) -> None:
        """Add up the colors of each yarn, and count the texels that show it or another."""
        if self._known:
            ids = band.pixels["yarn_id.png"]
            step = STEP if ids.shape[1] >= WIDE else 1
            _add_colors(
                ids[::step, ::step, 0],
                band.words("base_color.exr")[::step, ::step],
                HALVES,
                self._own,
                self._others,
                self._spread,
                self._sums,
                self._counts,
            )

    def findings(self) -> Iterator[Finding]:
        """Report yarns of another color, and colors that lie on another yarn."""
        if not self._known:
            return  # attribute/yarns reports it
        where = f"{TEXTURE_DIR}/base_color.exr"
        for k, yarn in enumerate(self._yarns):
            texels, own, misplaced = self._counts[:, k]
            if not texels:
                continue
            mean = self._sums[k] / texels
            # The mean of few uneven texels strays: three standard errors are allowed.
            astray = self._spread[k] * self._colors[k].max() / np.sqrt(texels)
            if np.abs(mean - self._colors[k]).max() > TOLERANCE + astray:
                stated = _text(self._colors[k])
                yield MEAN(f"{yarn} shows {_text(mean)} on average, stated is {stated}", where)
            if own > OWN * texels and misplaced > MISPLACED * texels:
                share = misplaced / texels
                yield PLACE(f"{share:.1%} of {yarn} show the color of another yarn", where)


@compiled
def _add_colors(
    ids: NDArray[np.uint8],
    words: Words,
    table: Floats32,
    colors: Floats32,
    others: Floats32,
    spread: Floats32,
    sums: Doubles,
    counts: NDArray[np.int64],
) -> None:
    """Add the colors shown by each yarn to `sums`, (Y, 3), and its texels to `counts`, (3, Y).

    Those looked at, those that show the yarn's color in some tone, and those that are nearer to
    one of the `others` that differ from it. Without `others`, only the first are counted.
    """
    one, distinct = np.float32(1), np.float32(DISTINCT**2)
    for row in range(ids.shape[0]):
        for column in range(ids.shape[1]):
            yarn = int(ids[row, column]) - 1
            if yarn < 0 or yarn >= len(colors):
                continue
            red = table[words[row, column, 0]]
            green = table[words[row, column, 1]]
            blue = table[words[row, column, 2]]
            sums[yarn, 0] += red
            sums[yarn, 1] += green
            sums[yarn, 2] += blue
            counts[0, yarn] += 1
            if not len(others):
                continue
            r, g, b = colors[yarn, 0], colors[yarn, 1], colors[yarn, 2]
            tone = (red * r + green * g + blue * b) / max(r * r + g * g + b * b, np.float32(1e-12))
            tone = min(max(tone, one - spread[yarn]), one + 2 * spread[yarn])
            away = (red - tone * r) ** 2 + (green - tone * g) ** 2 + (blue - tone * b) ** 2
            wrong = False
            for k in range(len(others)):
                x, y, z = others[k, 0], others[k, 1], others[k, 2]
                apart = (r - x) ** 2 + (g - y) ** 2 + (b - z) ** 2 > distinct
                wrong |= apart and (red - x) ** 2 + (green - y) ** 2 + (blue - z) ** 2 < away
            counts[1, yarn] += away < distinct
            counts[2, yarn] += wrong


def _text(color: Doubles) -> str:
    return "(" + ", ".join(f"{component:.3f}" for component in color) + ")"
