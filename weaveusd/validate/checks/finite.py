"""Whether every texel is a number."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.validate.checks._texels import Tally, any_component
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import TEXTURE_FILES, OpenAsset
from weaveusd.validate.registry import Code, check

NOT_FINITE = Code("texture-not-finite", Status.FAIL, "A texel is infinite or not a number.")

EXPONENT = 0x7C00
"""Bits of a half float that are all set in infinities and in what is not a number."""


@check(
    id="texture/finite",
    why="One NaN spreads through filtering and light transport to a black or white blot.",
    needs=("textures",),
    codes=(NOT_FINITE,),
)
def texture_finite(asset: OpenAsset) -> Iterator[Finding]:
    """Every texel is a finite number."""
    for file in (name for name in TEXTURE_FILES if name.endswith(".exr")):
        tally = Tally()
        for band in asset.textures.bands(file):
            pixels = band.pixels[file]
            bits = np.ascontiguousarray(pixels).view(np.uint16)
            tally.add(band.first, any_component(bits & EXPONENT == EXPONENT), pixels)
        yield from tally.report(NOT_FINITE, file, "not finite")
