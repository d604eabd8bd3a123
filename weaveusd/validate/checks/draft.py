"""Whether the textures show the draft that lies beside them."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import DRAFT_FILE, TEXTURE_DIR
from weaveusd.errors import InputError
from weaveusd.validate.checks.drawdown import EVEN, TEXELS_PER_THREAD
from weaveusd.validate.crossings import OFFSETS, Crossings
from weaveusd.validate.drafts import MAX_CROSSINGS, ReadDraft, read_draft
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bools = NDArray[np.bool_]

BROKEN = Code("draft-broken", Status.FAIL, "The draft of the asset is missing or states no weave.")
SIZE = Code("draft-size", Status.FAIL, "The cloth is not a whole number of repeats of its draft.")
HASH = Code("draft-disagrees", Status.FAIL, "The stated drawdown is not that of the draft.")
SHOWN = Code("weave-disagrees", Status.FAIL, "A crossing of the system map is not as in the draft.")
UNREAD = Code(
    "weave-unread",
    Status.SKIP,
    "The weave cannot be read off the system map: threads are not evenly spaced, or too fine.",
)

WEFT, WARP = 2, 1
FILE = "system.png"


@check(
    id="agreement/draft",
    why="The draft is what was signed: every crossing of the cloth has to be its own.",
    needs=("material", "textures"),
    codes=(BROKEN, SIZE, HASH, SHOWN, UNREAD),
)
class Draft:
    """The weave in the system map is, thread by thread, that of the draft in the asset."""

    def __init__(self, asset: OpenAsset) -> None:
        ends, picks = asset.cloth("ends") or 0, asset.cloth("picks") or 0
        self._stated = asset.cloth("drawdownSha256")
        self._known = ends > 0 and picks > 0 and ends * picks <= MAX_CROSSINGS
        self._coarse = min(asset.texels_per_thread) < TEXELS_PER_THREAD
        self._fault = ""
        self._draft: ReadDraft | None = None
        self._expected: Bools | None = None
        try:
            self._draft = read_draft(asset.folder / DRAFT_FILE)
        except InputError as error:
            self._fault = str(error)
        if self._draft is not None and self._known:
            self._expected = self._draft.repeated(ends, picks)
            self._size = f"{ends} ends and {picks} picks"
        if self._expected is not None and not self._coarse:
            header = asset.textures.header(FILE)
            self._places = [Crossings(ends, picks, header, offset) for offset in OFFSETS]

    def look(self, band: Band) -> None:
        """Read the crossings that lie in the band."""
        if self._expected is not None and not self._coarse:
            for place in self._places:
                place.read(band.first, band.pixels[FILE][..., 0])

    def findings(self) -> Iterator[Finding]:
        """Compare the draft with what is stated, then with what is shown."""
        if self._draft is None:
            yield BROKEN(self._fault, DRAFT_FILE)
        elif self._known and self._expected is None:
            picks, ends = self._draft.warp_up.shape
            yield SIZE(
                f"the cloth has {self._size}, expected whole repeats of {ends} and {picks}",
                DRAFT_FILE,
            )
        elif self._expected is not None:
            found = hashlib.sha256(np.packbits(self._expected).tobytes()).hexdigest()
            if found != self._stated:
                yield HASH(f"has the drawdown {found}, stated is {self._stated}", DRAFT_FILE)
            yield from self._shown(self._draft, self._expected)

    def _shown(self, draft: ReadDraft, expected: Bools) -> Iterator[Finding]:
        where = f"{TEXTURE_DIR}/{FILE}"
        if self._coarse:
            yield UNREAD(f"there are too few texels for {self._size}", where)
            return
        middle, *others = (place.shown for place in self._places)
        same = float(np.mean(np.all([other == middle for other in others], axis=0)))
        if not draft.even or same < EVEN:
            yield UNREAD("threads are not evenly spaced", where)
            return
        wrong = middle != np.where(expected, WARP, WEFT)
        if wrong.any():
            pick, end = (int(k) for k in np.argwhere(wrong)[0])
            name = {WARP: "the warp", WEFT: "the weft"}
            yield SHOWN(
                f"{int(wrong.sum())} of {wrong.size} crossings differ; the first, end {end + 1} "
                f"and pick {pick + 1}, shows {name.get(int(middle[pick, end]), 'a gap')}, "
                f"drawn is {name[WARP if expected[pick, end] else WEFT]}",
                where,
            )
