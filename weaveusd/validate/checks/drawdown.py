"""Whether the textures show the drawdown that the material names."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.crossings import OFFSETS, Crossings
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

OTHER = Code("drawdown-disagrees", Status.FAIL, "The textures show another weave than is stated.")
UNEVEN = Code(
    "drawdown-unread",
    Status.SKIP,
    "The weave cannot be read off the textures: threads are not evenly spaced, or not seen.",
)

EVEN = 0.995
"""Share of crossings that look the same at every place when threads are evenly spaced."""

TEXELS_PER_THREAD = 4
"""In coarser textures the places in a crossing are not told apart."""

MAX_CROSSINGS = 1 << 26


@check(
    id="agreement/drawdown",
    why="What was asked for is a weave; the textures are its only witness.",
    needs=("material", "textures"),
    codes=(OTHER, UNEVEN),
)
class Drawdown:
    """The yarns on top, read off the id texture, make the drawdown whose SHA-256 is stated."""

    def __init__(self, asset: OpenAsset) -> None:
        ends, picks = asset.cloth("ends") or 0, asset.cloth("picks") or 0
        self._stated = asset.cloth("drawdownSha256")
        self._ends, self._picks = ends, picks
        self._known = ends > 0 and picks > 0 and ends * picks <= MAX_CROSSINGS
        self._coarse = min(asset.texels_per_thread) < TEXELS_PER_THREAD
        if not self._known or self._coarse:
            return
        header = asset.textures.header("yarn_id.png")
        self._places = [Crossings(ends, picks, header, offset) for offset in OFFSETS]
        self._system = np.full(256, -1, dtype=np.int8)
        for number, yarn in enumerate(asset.yarns, start=1):
            self._system[number] = {"warp": 1, "weft": 0}.get(asset.yarn(yarn, "system"), -1)

    def look(self, band: Band) -> None:
        """Read the crossings that lie in the band."""
        if self._known and not self._coarse:
            for place in self._places:
                place.read(band.first, band.pixels["yarn_id.png"][..., 0])

    def findings(self) -> Iterator[Finding]:
        """Compare what was read with the drawdown that is stated."""
        if not self._known:
            return  # attribute/cloth reports it
        where = f"{TEXTURE_DIR}/yarn_id.png"
        if self._coarse:
            what = f"{self._ends} ends and {self._picks} picks"
            yield UNEVEN(f"there are too few texels for {what}", where)
            return
        middle, *others = (self._system[place.shown] for place in self._places)
        same = np.mean(np.all([other == middle for other in others], axis=0))
        if (middle < 0).any():
            yield UNEVEN("a crossing shows the yarn of neither system", where)
        elif same < EVEN:
            yield UNEVEN("threads are not evenly spaced", where)
        else:
            found = hashlib.sha256(np.packbits(middle.astype(np.uint8)).tobytes()).hexdigest()
            if found != self._stated:
                yield OTHER(
                    f"the textures show the drawdown {found}, "
                    f"but weave:drawdownSha256 is {self._stated}",
                    where,
                )
