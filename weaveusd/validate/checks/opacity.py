"""Whether gaps are the same in both textures that know them."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.validate.checks._texels import Tally
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

GAP = Code("gap-disagrees", Status.FAIL, "A texel is opaque without a yarn, or clear with one.")


@check(
    id="texture/gaps",
    why="A gap that is not clear shows the yarn of id 0, which does not exist.",
    needs=("textures",),
    codes=(GAP,),
)
def gaps(asset: OpenAsset) -> Iterator[Finding]:
    """Opacity is 0 exactly where there is no yarn."""
    tally = Tally()
    for band in asset.textures.bands("opacity.png", "yarn_id.png"):
        opacity = band.pixels["opacity.png"][..., 0]
        tally.add(band.first, (opacity == 0) != (band.pixels["yarn_id.png"][..., 0] == 0), opacity)
    yield from tally.report(GAP, "opacity.png", "opaque without a yarn or clear with one")
