"""Whether gaps are the same in both textures that know them."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.validate.checks._texels import Tally
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

GAP = Code("gap-disagrees", Status.FAIL, "A texel is opaque without a yarn, or clear with one.")


@check(
    id="texture/gaps",
    why="A gap that is not clear shows the yarn of id 0, which does not exist.",
    needs=("textures",),
    codes=(GAP,),
)
class Gaps:
    """Opacity is 0 exactly where there is no yarn."""

    def __init__(self, asset: OpenAsset) -> None:
        self._tally = Tally()

    def look(self, band: Band) -> None:
        """Count the texels where the textures disagree."""
        opacity, ids = band.pixels["opacity.png"][..., 0], band.pixels["yarn_id.png"][..., 0]
        self._tally.add(band.first, (opacity == 0) != (ids == 0), opacity)

    def findings(self) -> Iterator[Finding]:
        """Report them."""
        yield from self._tally.report(GAP, "opacity.png", "opaque without a yarn or clear with one")
