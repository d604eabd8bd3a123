"""Whether the files of one channel say the same."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.color_space import texels_to_rec709
from weaveusd.contract import CHANNELS
from weaveusd.validate.checks._texels import Tally, any_component
from weaveusd.validate.compiled import compiled
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import HALVES, VECTOR_LEVELS, Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.validate.checks._texels import Mask
    from weaveusd.validate.textures import Floats32, Words

    Stored = NDArray[np.uint8] | NDArray[np.uint16]

DIFFERENT = Code(
    "encodings-disagree",
    Status.FAIL,
    "The PNG and the EXR of a channel differ by more than rounding.",
)

VECTOR_TOLERANCE = 2.0**-12 + 2.0**-15
"""Half a step of a half float below 1, and one level of the PNG."""

COLOR_TOLERANCE = 0.5 + 0.1
"""Levels of 8 bits: half for rounding the PNG, and what a half float moves under the curve."""


@check(
    id="texture/encodings",
    why="Renderers that read one file and those that read the other must show one cloth.",
    needs=("textures",),
    codes=(DIFFERENT,),
)
class Encodings:
    """The PNG and the EXR of one channel agree to their precision."""

    def __init__(self, asset: OpenAsset) -> None:
        self._space = asset.color_space
        self._tallies = {
            channel.name: Tally() for channel in CHANNELS.values() if len(channel.files) > 1
        }

    def look(self, band: Band) -> None:
        """Count the texels that the files of a channel show differently."""
        for name, tally in self._tallies.items():
            png, exr = CHANNELS[name].files
            stored = band.pixels[png]
            differ = np.empty(stored.shape[:2], np.bool_)
            if CHANNELS[name].encoding != "color":
                _compare(stored, VECTOR_LEVELS, band.words(exr), HALVES, VECTOR_TOLERANCE, differ)
            elif self._space == "lin_rec709":
                _compare(stored, _CODES, band.words(exr), _LEVELS, COLOR_TOLERANCE, differ)
            else:
                levels = _levels(texels_to_rec709(band.pixels[exr], self._space))
                differ = any_component(np.abs(levels - stored) > COLOR_TOLERANCE)
            tally.add(band.first, differ, stored)

    def findings(self) -> Iterator[Finding]:
        """Report every channel whose files differ."""
        for name, tally in self._tallies.items():
            png, exr = CHANNELS[name].files
            yield from tally.report(DIFFERENT, png, f"another than in {exr}")


def _levels(color: NDArray[Any]) -> Floats32:
    """Return the levels of the sRGB curve (IEC 61966-2-1), 0…255, of linear Rec.709."""
    linear = np.clip(np.nan_to_num(color, nan=0.0), 0, 1)
    curved = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.asarray(curved * 255, np.float32)


_LEVELS = _levels(HALVES)
"""Levels of each of the half floats."""

_CODES = np.arange(256, dtype=np.float32)
"""Levels of each of the codes of 8 bits."""


@compiled
def _compare(
    png: Stored,
    of_png: Floats32,
    exr: Words,
    of_exr: Floats32,
    tolerance: float,
    differ: Mask,
) -> None:
    """Fill in where any component, looked up in the tables, differs by more than `tolerance`."""
    for row in range(png.shape[0]):
        for column in range(png.shape[1]):
            apart = False
            for k in range(png.shape[2]):
                difference = of_png[png[row, column, k]] - of_exr[exr[row, column, k]]
                apart |= abs(difference) > tolerance
            differ[row, column] = apart
