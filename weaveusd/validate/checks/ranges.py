"""Whether colors, heights and coverage are within what they can mean."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.validate.checks._texels import Tally, any_component
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

COLOR = Code("albedo-range", Status.FAIL, "An albedo is negative or above 1.")
ABOVE = Code("height-above-crown", Status.FAIL, "A height is above the crown of the highest float.")
BELOW = Code("height-below-cloth", Status.FAIL, "A height is further down than the cloth is thick.")
COVERAGE = Code("opacity-between", Status.WARN, "An opacity is between 0 and 1 without hairs.")

HALF_STEP = 2.0**-11
"""Half floats next to 1 are rounded by at most this, relatively."""

ONE, MINUS_ZERO = 0x3C00, 0x8000
"""Bits of half floats; those of positive ones count up with the number, of negative ones down."""

SIGMAS = 3.0
"""Standard deviations that no yarn's thickness strays beyond."""


@check(
    id="texture/ranges",
    why="An albedo above 1 makes light; a height is measured down from the highest crown.",
    needs=("material", "textures"),
    codes=(COLOR, ABOVE, BELOW, COVERAGE),
)
class ValueRanges:
    """Albedos are from 0 to 1, heights within the cloth; only hairs are half transparent."""

    def __init__(self, asset: OpenAsset) -> None:
        self._color, self._above, self._below, self._coverage = Tally(), Tally(), Tally(), Tally()
        self._thickness = asset.cloth("thickness")
        self._hairy = any(asset.yarn(yarn, "hairiness") for yarn in asset.yarns)
        deviations = (asset.yarn(yarn, "thicknessDeviation") or 0.0 for yarn in asset.yarns)
        uneven = max(deviations, default=0.0)
        # A slub stands higher than the mean yarn, whose thickness is stated; heights count from it.
        self._lowest = -(self._thickness or 0.0) * (1 + SIGMAS * uneven) * (1 + HALF_STEP)

    def look(self, band: Band) -> None:
        """Count the texels outside."""
        albedo = band.pixels["base_color.exr"]
        if band.words("base_color.exr").max() > ONE:
            self._color.add(band.first, any_component((albedo < 0) | (albedo > 1)), albedo)
        self._look_at_heights(band)
        opacity = band.pixels["opacity.png"][..., 0]
        if not self._hairy:
            self._coverage.add(band.first, (opacity > 0) & (opacity < 255), opacity)

    def _look_at_heights(self, band: Band) -> None:
        """Comparing half floats takes long: the range of their bits tells whether one must."""
        height = band.pixels["height.exr"][..., 0]
        bits = band.words("height.exr")
        if bits.view(np.int16).max() > 0:
            self._above.add(band.first, height > 0, height)
        deepest = bits.max()
        inside = deepest <= MINUS_ZERO or deepest.view(np.float16) >= self._lowest
        if isinstance(self._thickness, float) and not inside:
            self._below.add(band.first, height < self._lowest, height)

    def findings(self) -> Iterator[Finding]:
        """Report what lies outside."""
        yield from self._color.report(COLOR, "base_color.exr", "outside 0 to 1")
        yield from self._above.report(ABOVE, "height.exr", "above the highest crown")
        below = f"below the cloth, {self._thickness} mm thick"
        yield from self._below.report(BELOW, "height.exr", below)
        yield from self._coverage.report(COVERAGE, "opacity.png", "neither 0 nor 255")
