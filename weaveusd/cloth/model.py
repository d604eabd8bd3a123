"""The Weave: threads with places, yarns and floats, in millimetres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.contract import ColorSpace
    from weaveusd.yarn.model import Yarn

    Bools = NDArray[np.bool_]
    Indices = NDArray[np.int32]
    Doubles = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Floats:
    """The floats of one system, all threads in order, and how they bend.

    A float is a maximal cyclic run of crossings in which its thread is on top. `at` maps every
    crossing (picks, ends) to the float on top of it, or -1 where the other system is. Lengths
    are along the thread; `center_mm` may lie outside the repeat by less than its length, for
    a float that wraps.
    """

    thread: Indices  # (F,) end or pick that floats
    start: Indices  # (F,) first crossing covered, along the thread
    count: Indices  # (F,) crossings covered
    length_mm: Doubles  # (F,) projected length, edge to edge of the threads that cover its ends
    center_mm: Doubles  # (F,) middle of that length
    bend_mm: Doubles  # (F,) projected length of each bent end of an end-bend spine
    u_max: Doubles  # (F,) inclination at the ends, radians; 0 for a thread that never interlaces
    at: Indices  # (picks, ends)


@dataclass(frozen=True, slots=True, eq=False)
class Weave:
    """One repeat of a cloth: x along the weft, y along the warp, both periodic.

    Column c of the drawdown is end c, row r is pick r; both grow with x and y. Arrays are
    read-only. `warnings` say, one line each, where the cloth is not what its recipe states.
    """

    warp_up: Bools  # (picks, ends), True where the end is over the pick
    yarns: tuple[Yarn, ...]
    warp_yarn: Indices  # (ends,) index into yarns
    weft_yarn: Indices  # (picks,) index into yarns
    warp_edge_mm: Doubles  # (ends + 1,) borders of the cells of the ends, from 0 to the repeat
    weft_edge_mm: Doubles  # (picks + 1,)
    warp_width_mm: Doubles  # (ends,) width of each end
    weft_width_mm: Doubles  # (picks,)
    warp_height_mm: Doubles  # (ends,) thickness of each end
    weft_height_mm: Doubles  # (picks,)
    warp_floats: Floats
    weft_floats: Floats
    crimp_balance: float
    color_space: ColorSpace = "lin_rec709"  # of every color of its yarns
    warnings: tuple[str, ...] = ()

    @property
    def ends(self) -> int:
        """Number of warp threads."""
        return int(self.warp_up.shape[1])

    @property
    def picks(self) -> int:
        """Number of weft threads."""
        return int(self.warp_up.shape[0])

    @property
    def repeat_mm(self) -> tuple[float, float]:
        """Width and height of the repeat."""
        return float(self.warp_edge_mm[-1]), float(self.weft_edge_mm[-1])
