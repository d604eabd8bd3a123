"""Whether colors, heights and coverage are within what they can mean."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.validate.checks._texels import Tally, any_component
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

COLOR = Code("albedo-range", Status.FAIL, "An albedo is negative or above 1.")
ABOVE = Code("height-above-crown", Status.FAIL, "A height is above the crown of the highest float.")
BELOW = Code("height-below-cloth", Status.FAIL, "A height is further down than the cloth is thick.")
COVERAGE = Code("opacity-between", Status.WARN, "An opacity is between 0 and 1 without hairs.")

HALF_STEP = 2.0**-11
"""Half floats next to 1 are rounded by at most this, relatively."""


SIGMAS = 3.0
"""Standard deviations that no yarn's thickness strays beyond."""


@check(
    id="texture/ranges",
    why="An albedo above 1 makes light; a height is measured down from the highest crown.",
    needs=("material", "textures"),
    codes=(COLOR, ABOVE, BELOW, COVERAGE),
)
def value_ranges(asset: OpenAsset) -> Iterator[Finding]:
    """Albedos are from 0 to 1, heights within the cloth; only hairs are half transparent."""
    color, above, below, coverage = Tally(), Tally(), Tally(), Tally()
    thickness = asset.cloth("thickness")
    hairy = any(asset.yarn(yarn, "hairiness") for yarn in asset.yarns)
    uneven = max((asset.yarn(yarn, "thicknessDeviation") or 0.0 for yarn in asset.yarns), default=0)
    # A slub stands higher than the mean yarn, whose thickness is stated; heights count from it.
    lowest = -(thickness or 0.0) * (1 + SIGMAS * uneven) * (1 + HALF_STEP)
    for band in asset.textures.bands("base_color.exr", "height.exr", "opacity.png"):
        albedo = band.pixels["base_color.exr"]
        color.add(band.first, any_component((albedo < 0) | (albedo > 1)), albedo)
        height = band.pixels["height.exr"][..., 0]
        above.add(band.first, height > 0, height)
        if isinstance(thickness, float):
            below.add(band.first, height < lowest, height)
        opacity = band.pixels["opacity.png"][..., 0]
        if not hairy:
            coverage.add(band.first, (opacity > 0) & (opacity < 255), opacity)
    yield from color.report(COLOR, "base_color.exr", "outside 0 to 1")
    yield from above.report(ABOVE, "height.exr", "above the highest crown")
    yield from below.report(BELOW, "height.exr", f"below the cloth, {thickness} mm thick")
    yield from coverage.report(COVERAGE, "opacity.png", "neither 0 nor 255")
