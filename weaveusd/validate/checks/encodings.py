"""Whether the files of one channel say the same."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.color_space import texels_to_rec709
from weaveusd.contract import CHANNELS, ColorSpace
from weaveusd.validate.checks._texels import Tally, any_component
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

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
def encodings(asset: OpenAsset) -> Iterator[Finding]:
    """The PNG and the EXR of one channel agree to their precision."""
    for channel in CHANNELS.values():
        if len(channel.files) < 2:
            continue
        png, exr = channel.files
        tally = Tally()
        for band in asset.textures.bands(png, exr):
            if channel.encoding == "color":
                differ = _colors_differ(band, png, exr, asset.color_space)
            else:
                differ = _vectors_differ(band, png, exr)
            tally.add(band.first, differ, band.pixels[png])
        yield from tally.report(DIFFERENT, png, f"another than in {exr}")


def _vectors_differ(band: Band, png: str, exr: str) -> NDArray[np.bool_]:
    difference = np.abs(band.vectors(png) - band.vectors(exr))
    return any_component(difference > VECTOR_TOLERANCE)


def _levels(color: NDArray[Any]) -> NDArray[np.float32]:
    """Return the levels of the sRGB curve (IEC 61966-2-1), 0…255, of linear Rec.709."""
    linear = np.clip(np.nan_to_num(color, nan=0.0), 0, 1)
    curved = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.asarray(curved * 255, np.float32)


_LEVELS = _levels(np.arange(1 << 16, dtype=np.uint16).view(np.float16).astype(np.float32))
"""Levels of each of the half floats."""


def _colors_differ(band: Band, png: str, exr: str, space: ColorSpace) -> NDArray[np.bool_]:
    halves = np.ascontiguousarray(band.pixels[exr])
    if space == "lin_rec709":
        levels = _LEVELS[halves.view(np.uint16)]
    else:
        levels = _levels(texels_to_rec709(halves, space))
    difference = np.abs(levels - band.pixels[png])
    return any_component(difference > COLOR_TOLERANCE)
