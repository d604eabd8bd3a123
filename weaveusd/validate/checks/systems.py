"""Whether the map of systems is that of the yarns."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.validate.checks._texels import Tally
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

SYSTEM = Code("system-disagrees", Status.FAIL, "A texel is of another system than its yarn.")

FILE = "system.png"
LABELS = {"warp": 1, "weft": 2}


@check(
    id="texture/systems",
    why="Warp and weft exchanged in one map alone turn the weave over for whoever reads it.",
    needs=("material", "textures"),
    codes=(SYSTEM,),
)
class Systems:
    """Every texel is of the system of its yarn, and of none in gaps."""

    def __init__(self, asset: OpenAsset) -> None:
        self._tally = Tally()
        # Ids of no yarn are for texture/yarn-ids to report.
        self._expected = np.full(256, 255, np.uint8)
        self._expected[0] = 0
        for number, yarn in enumerate(asset.yarns, start=1):
            self._expected[number] = LABELS.get(asset.yarn(yarn, "system"), 255)

    def look(self, band: Band) -> None:
        """Count the texels of another system."""
        found = band.pixels[FILE][..., 0]
        expected = np.take(self._expected, band.pixels["yarn_id.png"][..., 0])
        wrong = found != expected
        if wrong.any():
            self._tally.add(band.first, wrong & (expected != 255), found)

    def findings(self) -> Iterator[Finding]:
        """Report them."""
        yield from self._tally.report(SYSTEM, FILE, "of another system than the yarn in its place")
