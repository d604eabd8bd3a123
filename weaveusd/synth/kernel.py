"""The texel kernel: a row is cut into pieces that fit the cache, and each piece is computed.

A piece is worked on step by step: which threads cross there (`lay`), which one a texel sees
(`choose`), how its spine bends and its surface lies (`surface`), what color it has (`paint`). The
steps that are done for every texel are plain loops without branches, which compilers turn into
vector instructions. What rows have in common is laid out once for all of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from weaveusd.synth.choose import choose, fill_gaps
from weaveusd.synth.compiled import compiled
from weaveusd.synth.lay import lay_columns, lay_crossings, lay_ends, lay_pick
from weaveusd.synth.paint import mix, paint
from weaveusd.synth.piece import PIECE
from weaveusd.synth.surface import bend, bend_conics, groove, turn, wind, write_surface

if TYPE_CHECKING:
    from weaveusd.synth.noise import Blend
    from weaveusd.synth.plan import Cells, Threads
    from weaveusd.synth.tones import Tones


@compiled
def fill_rows(  # type: ignore[no-untyped-def] # numba compiles it for the types it is given
    first, columns: Cells, rows: Cells, warp: Threads, weft: Threads, by_row: Blend,
    by_column: Blend, width_mm, height_mm, tones: Tones,
    normal, tangent, height, opacity, yarn_id, base_color, scratch,
):  # fmt: skip
    """Fill texel rows `first`, `first` + 1, … of every channel array (rows, width × components).

    At a crossing the thread that the drawdown puts on top is seen where it is wide enough, and
    the other one beside it. In the gap beside a crossing the thread that runs there belongs to
    its float, or to the float next to it, or is seen from above as it passes under both
    neighbours. Where no thread is, opacity is that of loose hairs; without hairs it is 0, the
    normal is up and the yarn id -1. `scratch` is a `workspace`.
    """
    count, width = height.shape
    even = len(warp.twist) == 1 and len(warp.thick) == 1 and len(warp.tone) == 1
    hairy, plied = warp.hairy or weft.hairy, warp.plied or weft.plied
    conic, several = warp.conic or weft.conic, tones.color.shape[1] > 1
    for start in range(0, width, PIECE):
        stop = min(width, start + PIECE)
        texels = stop - start
        thread, end_beside = columns.thread[start:stop], columns.beside[start:stop]
        position = columns.position[start:stop]
        lay_columns(scratch, texels, thread, columns.offset[start:stop], warp, tones)
        before, before_beside = -1, -1
        for k in range(count):
            j = first + k
            r, pick_beside, off_y = rows.thread[j], rows.beside[j], rows.offset[j]
            if k == 0 or not even:
                lay_ends(scratch, texels, j, thread, warp, by_row, tones)
            if r != before:
                lay_pick(scratch, start, texels, r, weft, by_column, tones)
            if r != before or pick_beside != before_beside:
                lay_crossings(
                    scratch, texels, r, pick_beside, thread, end_beside, position, warp, weft,
                    conic,
                )  # fmt: skip
            before, before_beside = r, pick_beside
            choose(
                scratch, texels, rows.position[j], off_y, weft.yarn[r],
                weft.sunk[r] + weft.half_height[r],
                opacity[k, start:stop], yarn_id[k, start:stop],
            )  # fmt: skip
            if hairy:
                fill_gaps(
                    scratch, texels, off_y, weft.yarn[r], weft.hair[r], thread, warp.hair,
                    opacity[k, start:stop], yarn_id[k, start:stop],
                )  # fmt: skip
            bend(scratch, texels, width_mm, height_mm)
            if conic:
                bend_conics(scratch, texels)
            turn(scratch, texels)
            if plied:
                wind(scratch, texels, r, rows.position[j], position, weft, width_mm, height_mm)
                groove(scratch, texels)
            write_surface(
                scratch, texels, normal[k, 3 * start : 3 * stop],
                tangent[k, 3 * start : 3 * stop], height[k, start:stop],
            )  # fmt: skip
            paint(
                scratch, texels, tones.color[weft.yarn[r], 0], base_color[k, 3 * start : 3 * stop]
            )
            if several:
                mix(
                    scratch, start, texels, j, columns, rows, warp, weft, by_row, by_column,
                    width_mm, height_mm, tones, base_color[k, 3 * start : 3 * stop],
                )  # fmt: skip
