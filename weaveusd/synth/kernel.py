"""The texel kernel: a row is cut into pieces that fit the cache, and each piece is computed.

A piece is worked on step by step: which thread a texel sees (`choose`), how its spine bends
(`bend`), how its surface lies (`turn`, `groove`), what color it has (`paint`). The steps that
compute much are plain loops over a piece, which compilers turn into vector instructions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weaveusd.synth.choose import choose
from weaveusd.synth.compiled import compiled
from weaveusd.synth.paint import paint
from weaveusd.synth.surface import (
    FIELDS,
    PIECE,
    bend,
    bend_conics,
    groove,
    turn,
    wind,
    write_surface,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.synth.noise import Blend
    from weaveusd.synth.plan import Cells, Threads
    from weaveusd.synth.tones import Tones


def workspace() -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.int32]]:
    """Return room for the numbers of one piece, which every thread needs for itself."""
    return np.empty(FIELDS * PIECE), np.empty(PIECE, np.int32), np.empty(PIECE, np.int32)


@compiled
def fill_rows(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    first, columns: Cells, rows: Cells, warp: Threads, weft: Threads, by_row: Blend,
    by_column: Blend, width_mm, height_mm, tones: Tones,
    normal, tangent, height, opacity, yarn_id, base_color, scratch, thread_of, float_of,
):  # fmt: skip
    """Fill texel rows `first`, `first` + 1, … of every channel array (rows, width, components).

    At a crossing the thread that the drawdown puts on top is seen where it is wide enough, and
    the other one beside it. In the gap beside a crossing the thread that runs there belongs to
    its float, or to the float next to it, or is seen from above as it passes under both
    neighbours. Where no thread is, opacity is that of loose hairs; without hairs it is 0, the
    normal is up and the yarn id -1. `workspace` gives the last three arguments.
    """
    for k in range(normal.shape[0]):
        j = first + k
        y = rows.position[j]
        for start in range(0, normal.shape[1], PIECE):
            texels = min(PIECE, normal.shape[1] - start)
            conics, plied = choose(
                start, texels, j, columns, rows, warp, weft, by_row, by_column,
                scratch, thread_of, float_of, opacity[k], yarn_id[k],
            )  # fmt: skip
            bend(scratch, texels, width_mm, height_mm)
            if conics:
                bend_conics(scratch, texels, warp, False, float_of)
                bend_conics(scratch, texels, weft, True, float_of)
            turn(scratch, texels)
            if plied:
                wind(
                    scratch, texels, start, columns, y, warp, weft, thread_of,
                    width_mm, height_mm,
                )  # fmt: skip
                groove(scratch, texels)
            write_surface(scratch, texels, start, normal[k], tangent[k], height[k])
            paint(
                scratch, texels, start, j, columns, y, warp, weft, by_row, by_column,
                width_mm, height_mm, thread_of, tones, base_color[k],
            )  # fmt: skip
