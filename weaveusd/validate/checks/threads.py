"""Whether every thread is one yarn from end to end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.checks.drawdown import MAX_CROSSINGS, TEXELS_PER_THREAD
from weaveusd.validate.crossings import OFFSETS, Crossings
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Labels = NDArray[np.int16]

MIXED = Code("thread-mixed", Status.FAIL, "A thread shows one yarn here and another there.")
UNREAD = Code("thread-unread", Status.SKIP, "The textures are too coarse to tell threads apart.")

FILE = "yarn_id.png"


@check(
    id="agreement/threads",
    why="A thread runs through the whole cloth: its color and its gloss cannot change on the way.",
    needs=("material", "textures"),
    codes=(MIXED, UNREAD),
)
class Threads:
    """Every end and every pick shows the same yarn wherever it is on top."""

    def __init__(self, asset: OpenAsset) -> None:
        ends, picks = asset.cloth("ends") or 0, asset.cloth("picks") or 0
        self._coarse = min(asset.texels_per_thread) < TEXELS_PER_THREAD
        self._place: Crossings | None = None
        if ends > 0 and picks > 0 and ends * picks <= MAX_CROSSINGS and not self._coarse:
            self._place = Crossings(ends, picks, asset.textures.header(FILE), OFFSETS[0])
        self._yarns = ("a gap", *asset.yarns)
        systems = [asset.yarn(yarn, "system") for yarn in asset.yarns]
        self._of = {name: np.zeros(256, np.bool_) for name in ("warp", "weft")}
        for number, system in enumerate(systems, start=1):
            if system in self._of:
                self._of[system][number] = True

    def look(self, band: Band) -> None:
        """Read the crossings that lie in the band."""
        if self._place is not None:
            self._place.read(band.first, band.pixels[FILE][..., 0])

    def findings(self) -> Iterator[Finding]:
        """Report the threads of several yarns."""
        if self._coarse:
            yield UNREAD("there are too few texels for each thread", f"{TEXTURE_DIR}/{FILE}")
        if self._place is None:
            return
        shown = self._place.shown
        yield from self._mixed(shown.T, "warp", "end")
        yield from self._mixed(shown, "weft", "pick")

    def _mixed(self, threads: Labels, system: str, word: str) -> Iterator[Finding]:
        """Report the threads, rows of `threads`, on which more than one yarn of `system` lies."""
        own = self._of[system][threads]
        most = np.where(own, threads, 0).max(axis=1, initial=0)
        least = np.where(own, threads, 256).min(axis=1, initial=256)
        for k in np.flatnonzero(least < most):
            names = [self._yarns[number] for number in (least[k], most[k])]
            yield MIXED(f"{word} {k + 1} shows {' and '.join(names)}", f"{TEXTURE_DIR}/{FILE}")
