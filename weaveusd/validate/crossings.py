"""What a label texture shows at each crossing of an evenly spaced cloth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.validate.textures import Header

if TYPE_CHECKING:
    from numpy.typing import NDArray

OFFSETS = ((0.5, 0.5), (0.35, 0.5), (0.65, 0.5), (0.5, 0.35), (0.5, 0.65))
"""Places in a crossing, as shares of its width and height, the middle first."""


class Crossings:
    """The labels at one place in each crossing: `offset`, shares of its width and height.

    `shown` is (picks, ends), row 0 the first pick, and whole once every band has been read.
    """

    def __init__(self, ends: int, picks: int, header: Header, offset: tuple[float, float]) -> None:
        self._columns = ((np.arange(ends) + offset[0]) * header.width / ends).astype(int)
        rows_up = ((np.arange(picks) + offset[1]) * header.height / picks).astype(int)
        self._rows = header.height - 1 - rows_up  # the image's top row has the highest y
        self.shown = np.zeros((picks, ends), dtype=np.int16)

    def read(self, first: int, labels: NDArray[Any]) -> None:
        """Take the crossings from `labels`, (rows, width), the first of which is row `first`."""
        here = np.flatnonzero((self._rows >= first) & (self._rows < first + len(labels)))
        self.shown[here] = labels[np.ix_(self._rows[here] - first, self._columns)]
