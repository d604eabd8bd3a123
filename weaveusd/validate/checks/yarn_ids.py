"""Whether the yarn id texture and the list of yarns agree."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.checks._texels import Tally
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

UNKNOWN = Code("yarn-id-unknown", Status.FAIL, "A texel has the id of a yarn that is not listed.")
UNUSED = Code("yarn-id-unused", Status.WARN, "A yarn that is listed is on no texel.")

FILE = "yarn_id.png"


@check(
    id="texture/yarn-ids",
    why="An id beyond the list reads past the end of the shader's arrays.",
    needs=("material", "textures"),
    codes=(UNKNOWN, UNUSED),
)
def yarn_ids(asset: OpenAsset) -> Iterator[Finding]:
    """Every id in the texture is that of a listed yarn, and every yarn is seen."""
    count = len(asset.yarns)
    tally = Tally()
    seen = np.zeros(256, dtype=bool)
    for band in asset.textures.bands(FILE):
        ids = band.pixels[FILE][..., 0]
        tally.add(band.first, ids > count, ids)
        seen |= np.bincount(ids.ravel(), minlength=256) > 0
    yield from tally.report(UNKNOWN, FILE, f"of no yarn, with {count} listed")
    for number, yarn in enumerate(asset.yarns, start=1):
        if not seen[number]:
            yield UNUSED(f"{yarn}, id {number}, is on no texel", f"{TEXTURE_DIR}/{FILE}")
