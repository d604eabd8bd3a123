"""Whether the textures show the drawdown that the material names."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bools = NDArray[np.bool_]

OTHER = Code("drawdown-disagrees", Status.FAIL, "The textures show another weave than is stated.")
UNEVEN = Code(
    "drawdown-unread",
    Status.SKIP,
    "The weave cannot be read off the textures: threads are not evenly spaced, or not seen.",
)

OFFSETS = ((0.5, 0.5), (0.35, 0.5), (0.65, 0.5), (0.5, 0.35), (0.5, 0.65))
"""Places in a crossing, as shares of its width and height, the middle first."""

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
def drawdown(asset: OpenAsset) -> Iterator[Finding]:
    """The yarns on top, read off the id texture, make the drawdown whose SHA-256 is stated."""
    where = f"{TEXTURE_DIR}/yarn_id.png"
    ends, picks = asset.cloth("ends"), asset.cloth("picks")
    if not ends or not picks or ends < 1 or picks < 1 or ends * picks > MAX_CROSSINGS:
        return  # attribute/cloth reports it
    if min(asset.texels_per_thread) < TEXELS_PER_THREAD:
        yield UNEVEN(f"there are too few texels for {ends} ends and {picks} picks", where)
        return
    places = [_warp_up(asset, ends, picks, offset) for offset in OFFSETS]
    same = np.mean(np.all([place == places[0] for place in places], axis=0))
    if (places[0] < 0).any():
        yield UNEVEN("a crossing shows the yarn of neither system", where)
        return
    if same < EVEN:
        yield UNEVEN("threads are not evenly spaced", where)
        return
    found = hashlib.sha256(np.packbits(places[0].astype(np.uint8)).tobytes()).hexdigest()
    if found != asset.cloth("drawdownSha256"):
        yield OTHER(
            f"the textures show the drawdown {found}, "
            f"but weave:drawdownSha256 is {asset.cloth('drawdownSha256')}",
            where,
        )


def _warp_up(
    asset: OpenAsset, ends: int, picks: int, offset: tuple[float, float]
) -> NDArray[np.int8]:
    """Return (picks, ends), row 0 the first pick: 1 warp on top, 0 weft, -1 neither.

    `offset` is the place in each crossing that is looked at.
    """
    header = asset.textures.header("yarn_id.png")
    columns = ((np.arange(ends) + offset[0]) * header.width / ends).astype(int)
    rows_up = ((np.arange(picks) + offset[1]) * header.height / picks).astype(int)
    rows = header.height - 1 - rows_up  # the image's top row has the highest y
    system = np.full(256, -1, dtype=np.int8)
    for number, yarn in enumerate(asset.yarns, start=1):
        system[number] = {"warp": 1, "weft": 0}.get(asset.yarn(yarn, "system"), -1)
    found = np.empty((picks, ends), dtype=np.int8)
    for band in asset.textures.bands("yarn_id.png"):
        ids = band.pixels["yarn_id.png"][..., 0]
        here = np.flatnonzero((rows >= band.first) & (rows < band.first + len(ids)))
        found[here] = system[ids[np.ix_(rows[here] - band.first, columns)]]
    return found
