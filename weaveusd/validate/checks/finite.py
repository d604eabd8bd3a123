"""Whether every texel is a number."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.validate.checks._texels import Tally, any_component
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import TEXTURE_FILES, OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

NOT_FINITE = Code("texture-not-finite", Status.FAIL, "A texel is infinite or not a number.")

EXPONENT = 0x7C00
"""Bits of a half float that are all set in infinities and in what is not a number."""


@check(
    id="texture/finite",
    why="One NaN spreads through filtering and light transport to a black or white blot.",
    needs=("textures",),
    codes=(NOT_FINITE,),
)
class TextureFinite:
    """Every texel is a finite number."""

    def __init__(self, asset: OpenAsset) -> None:
        self._tallies = {file: Tally() for file in TEXTURE_FILES if file.endswith(".exr")}

    def look(self, band: Band) -> None:
        """Count the texels that are not finite."""
        for file, tally in self._tallies.items():
            exponents = band.words(file) & EXPONENT
            if exponents.max() == EXPONENT:
                faulty = any_component(exponents == EXPONENT)
                tally.add(band.first, faulty, band.pixels[file])

    def findings(self) -> Iterator[Finding]:
        """Report every file that holds such texels."""
        for file, tally in self._tallies.items():
            yield from tally.report(NOT_FINITE, file, "not finite")
