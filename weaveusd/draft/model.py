"""The Draft: what a weaver tells a loom, resolved and immutable."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bools = NDArray[np.bool_]
    Indices = NDArray[np.int32]
    Doubles = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class DraftWarning:
    """A decision taken on the reader's behalf: where (line 0 when nowhere) and what."""

    line: int
    message: str

    def __str__(self) -> str:
        return f"line {self.line}: {self.message}" if self.line else self.message


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A weaving draft with tie-up and sinking shed resolved into a liftplan.

    Row 0 of the liftplan is the first pick, column 0 of everything is the first shaft; thread
    and palette indices count from 0. Arrays are read-only. Lengths are in mm and are None where
    the draft does not state them. Two drafts are equal when they weave the same cloth from the
    same threads under the same title and notes; warnings do not count.
    """

    threading: Bools  # (ends, shafts)
    liftplan: Bools  # (picks, shafts), True where the shaft is up
    warp_color: Indices  # (ends,) index into the palette
    weft_color: Indices  # (picks,) index into the palette
    palette: Doubles  # (P, 3) display sRGB, 0…1
    warp_pitch_mm: Doubles | None = None  # (ends,) centre to centre
    weft_pitch_mm: Doubles | None = None  # (picks,)
    warp_thickness_mm: Doubles | None = None  # (ends,)
    weft_thickness_mm: Doubles | None = None  # (picks,)
    title: str = ""
    notes: str = ""
    warnings: tuple[DraftWarning, ...] = field(default=())

    @property
    def ends(self) -> int:
        """Number of warp threads."""
        return int(self.threading.shape[0])

    @property
    def picks(self) -> int:
        """Number of weft threads."""
        return int(self.liftplan.shape[0])

    @property
    def shafts(self) -> int:
        """Number of shafts of the loom."""
        return int(self.threading.shape[1])

    def drawdown(self) -> Bools:
        """Return the drawdown (picks, ends): True where the end is over the pick.

        An end is up on a pick when any shaft that it is threaded on is lifted; an end on no
        shaft stays down. Row 0 is the first pick.
        """
        up = self.liftplan.astype(np.float32) @ self.threading.astype(np.float32).T > 0.5
        up.setflags(write=False)
        return up
