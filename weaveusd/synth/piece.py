"""The numbers of a piece of a row of texels: named fields, side by side in one flat array.

Every field has `PIECE` texels. As its offset is a constant, compilers see that fields do not
overlap and compute several texels at once. Lengths are in mm, angles in radians, heights over the
cloth's highest crown.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

PIECE = 128
"""Texels worked on together: their numbers stay in the fastest cache."""

(
    # What `lay_columns` says of the end at a texel, for all rows.
    OFFSET,  # distance from the end's axis
    WARP_CROWN,  # height of the end's crown while it is under
    WARP_YARN, WARP_RED, WARP_GREEN, WARP_BLUE,
    WARP_PLIES, WARP_TURNS, WARP_PHASE, WARP_GROOVE,
    # What `lay_ends` says of it: for all rows where it is even, else for one.
    WARP_EDGE,  # half width
    WARP_HALF,  # half height
    WARP_PSI,
    WARP_TONE,  # by how much its color is scaled
    # What `lay_crossings` says of the floats there, for all rows of half a pick.
    TOP,  # 1 where the end is on top, 0 where the pick is
    WARP_MIDDLE,  # place of the middle of the end's float
    WARP_STRAIGHT, WARP_RADIUS, WARP_R_HAT,  # numbers of that float, as in `plan`
    WARP_BASE,  # height of the end's axis at that middle
    WEFT_ALONG,  # distance from the middle of the pick's float
    WEFT_STRAIGHT, WEFT_RADIUS, WEFT_R_HAT, WEFT_BASE,
    # What `lay_pick` says of the pick, for the same rows.
    WEFT_EDGE, WEFT_HALF, WEFT_PSI, WEFT_TONE,
    # What `choose` says of the yarn that is seen, in that yarn's frame.
    WEFT,  # 1 on weft, 0 on warp
    ACROSS,  # distance from the yarn's axis
    HALF_WIDTH,
    HALF_HEIGHT,  # 0 in gaps
    ALONG,  # distance from the middle of the float, but for whole repeats
    STRAIGHT, RADIUS, BASE,
    PSI,  # angle of the fibre
    # What the geometry makes of it.
    SIN_V, COS_V, SIN_U, COS_U, SPINE,
    N_X, N_Y, N_Z, T_X, T_Y, T_Z, HEIGHT,
    # How the plies wind.
    PLIES, STRAND, RATE, DEPTH,
) = range(54)  # fmt: skip
FIELDS = 54

LINE = 8
"""Numbers in a line of the cache."""


def workspace() -> NDArray[np.float64]:
    """Return room for the numbers of one piece, which every thread needs for itself."""
    # Fields begin where lines of the cache do: vectors across two lines take twice the time.
    room = np.empty(FIELDS * PIECE + LINE)
    first = -room.ctypes.data // room.itemsize % LINE
    return room[first : first + FIELDS * PIECE]
