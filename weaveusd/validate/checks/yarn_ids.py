"""Whether the yarn id texture and the list of yarns agree."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.checks._texels import Tally
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

UNKNOWN = Code("yarn-id-unknown", Status.FAIL, "A texel has the id of a yarn that is not listed.")
UNUSED = Code("yarn-id-unused", Status.WARN, "A yarn that is listed is on no texel.")

FILE = "yarn_id.png"


@check(
    id="texture/yarn-ids",
    why="An id beyond the list reads past the end of the shader's arrays.",
    needs=("material", "textures"),
    codes=(UNKNOWN, UNUSED),
)
class YarnIds:
    """Every id in the texture is that of a listed yarn, and every yarn is seen."""

    def __init__(self, asset: OpenAsset) -> None:
        self._yarns = asset.yarns
        self._tally = Tally()
        self._seen = np.zeros(256, dtype=bool)

    def look(self, band: Band) -> None:
        """Note which ids there are, and count those beyond the list."""
        ids = band.pixels[FILE][..., 0]
        self._tally.add(band.first, ids > len(self._yarns), ids)
        self._seen |= np.bincount(ids.ravel(), minlength=256) > 0

    def findings(self) -> Iterator[Finding]:
        """Report ids of no yarn and yarns of no texel."""
        yield from self._tally.report(UNKNOWN, FILE, f"of no yarn, with {len(self._yarns)} listed")
        for number, yarn in enumerate(self._yarns, start=1):
            if not self._seen[number]:
                yield UNUSED(f"{yarn}, id {number}, is on no texel", f"{TEXTURE_DIR}/{FILE}")
