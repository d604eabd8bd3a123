"""Time of a texel, beside the per-pixel method that textures of woven cloth were made with.

    python benchmarks/synthesis.py [--quick]

Channels: normal, tangent, base color, height and opacity, and the yarn id that comes with them.
`even` yarns are the same everywhere; `uneven` ones vary in twist, thickness, bend and color and
have hairs; `plied` ones have two plies besides. Of one thread its processor time counts, which
other programs disturb less, of all threads the time on the clock; always the least of some runs.
The exit status is 1 when results disagree, never for the time.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from weaveusd.cloth.model import Weave
from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.draft.model import Draft
from weaveusd.draft.transform import repeat
from weaveusd.synth.kernel import fill_rows
from weaveusd.synth.piece import workspace
from weaveusd.synth.plan import lay_along, lay_cells, lay_threads
from weaveusd.synth.rows import share_out, thread_count
from weaveusd.synth.textures import texture_size
from weaveusd.synth.tones import lay_tones
from weaveusd.yarn.irregularity import REGULAR, Irregularity
from weaveusd.yarn.recipe import read_preset

BAND_TEXELS = 1 << 16
UNEVEN = Irregularity(
    thickness=0.1, thickness_correlation_mm=2, bend=0.1, color=2, color_correlation_mm=3,
    hairiness=0.3,
)  # fmt: skip
KINDS: dict[str, dict[str, Any]] = {
    "even": {"irregularity": REGULAR, "twist_deviation": 0.0, "plies": 1},
    "uneven": {"irregularity": UNEVEN, "twist_deviation": 0.1, "plies": 1},
    "plied": {"irregularity": UNEVEN, "twist_deviation": 0.1, "plies": 2},
}
COMPONENTS = {
    "normal": 3, "tangent": 3, "height": 1, "opacity": 1, "yarn_id": 1, "base_color": 3,
}  # fmt: skip


def drafts() -> dict[str, Draft]:
    """Return drafts of 2 × 2, 64 × 4 and 1200 × 1200 threads."""
    return {
        draft_name: draft
        for draft in (
            make_draft("plain"),
            make_draft("herringbone:2/2:32"),
            repeat(make_draft("satin:8:3"), 150, 150),
        )
        for draft_name in [f"{draft.ends} × {draft.picks}"]
    }


def cloth_of(draft: Draft, kind: str) -> Weave:
    """Return `draft` woven in linen yarns of that kind."""
    cloth = weave(draft, read_preset("linen"))
    return replace(cloth, yarns=tuple(replace(y, **KINDS[kind]) for y in cloth.yarns))


def filler(cloth: Weave, resolution: int, jobs: int) -> tuple[Callable[[], Any], int]:
    """Return what computes all texels band by band into the same arrays, and their number."""
    width, height = texture_size(cloth, resolution)
    warp, weft = lay_threads(cloth, 0)
    columns = lay_cells(cloth.warp_edge_mm, width)
    rows = lay_cells(cloth.weft_edge_mm, height)
    along = lay_along(warp, height), lay_along(weft, width)
    tones = lay_tones(cloth.yarns)
    band = max(1, BAND_TEXELS // width)
    spaces = {}

    def fill(first: int, last: int) -> None:
        if first not in spaces:
            arrays = [np.zeros((band, width * n), np.float32) for n in COMPONENTS.values()]
            spaces[first] = arrays, workspace()
        arrays, scratch = spaces[first]
        for start in range(first, last, band):
            part = [a[: min(band, last - start)] for a in arrays]
            fill_rows(
                start, columns, rows, warp, weft, *along, *cloth.repeat_mm, tones, *part, scratch
            )

    return lambda: share_out(fill, height, jobs), width * height


def least(
    work: Callable[[], Any], runs: int, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Return the least of the seconds of some runs, after one that does not count."""
    work()
    times = []
    for _ in range(runs):
        start = clock()
        work()
        times.append(clock() - start)
    return min(times)


def per_pixel(cloth: Weave, columns: int, rows: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Return normals, whether they are sound, and the seconds of the per-pixel method.

    Written anew from its description, in plain Python as it was: for each pixel find the thread,
    walk along the drawdown to both ends of its float, evaluate normal and tangent of a circular
    spine (Irawan and Marschner 2012), and take the thread's color. Nothing is kept from one
    pixel to the next, but what is the same for a whole cloth is computed once. It knows neither
    height nor opacity, which our time includes. Sound are warp floats that do not reach the
    border of the repeat, at which the walk stops; the method's weft is wrong in itself.
    """
    normals, sound = np.zeros((rows, columns, 3)), np.zeros((rows, columns), bool)
    tangents, colors = np.zeros((rows, columns, 3)), np.zeros((rows, columns, 3))
    up, upright = cloth.warp_up.tolist(), cloth.warp_up.T.tolist()
    picks, ends = len(up), len(up[0])
    width, height = cloth.repeat_mm
    pitch = width / ends, height / picks
    warp, weft = cloth.warp_floats, cloth.weft_floats
    u_max = float(warp.u_max[0]), float(weft.u_max[0])
    half = (
        (0.5 * float(cloth.warp_width_mm[0]), 0.5 * float(cloth.warp_height_mm[0])),
        (0.5 * float(cloth.weft_width_mm[0]), 0.5 * float(cloth.weft_height_mm[0])),
    )
    gap = (
        pitch[1] - float(cloth.weft_width_mm[0]),
        pitch[0] - float(cloth.warp_width_mm[0]),
    )
    color = cloth.yarns[cloth.warp_yarn[0]].color, cloth.yarns[cloth.weft_yarn[0]].color
    started = time.perf_counter()
    for j in range(rows):
        for i in range(columns):
            x, y = (i + 0.5) / columns * width, (j + 0.5) / rows * height
            c, r = int(x / pitch[0]), int(y / pitch[1])
            system = 0 if up[r][c] else 1
            if system == 0:
                first, last = _ends_of_float(upright[c], r)
                across, along = x - (c + 0.5) * pitch[0], y - 0.5 * (first + last + 1) * pitch[1]
                length, stop = (last - first + 1) * pitch[1] + gap[0], picks - 1
            else:
                first, last = _ends_of_float(up[r], c)
                across, along = (r + 0.5) * pitch[1] - y, x - 0.5 * (first + last + 1) * pitch[0]
                length, stop = (last - first + 1) * pitch[0] + gap[1], ends - 1
            a, b = half[system]
            if abs(across) >= a:
                continue
            v = math.asin(across / a)
            radius = 0.5 * length / math.sin(u_max[system]) - b
            sin_u = along / (radius + b * math.cos(v))
            u = math.asin(max(-1.0, min(1.0, sin_u)))
            normals[j, i] = _unit(
                b / a * math.sin(v), math.sin(u) * math.cos(v), math.cos(u) * math.cos(v)
            )
            tangents[j, i] = _unit(0.0, math.cos(u), -math.sin(u))
            colors[j, i] = color[system]
            sound[j, i] = system == 0 and first > 0 and last < stop
    return normals, sound, time.perf_counter() - started


def _ends_of_float(line: list[bool], place: int) -> tuple[int, int]:
    """Return the first and the last crossing of the float at a place of a line of a drawdown."""
    first = last = place
    while first > 0 and line[first - 1] == line[place]:
        first -= 1
    while last < len(line) - 1 and line[last + 1] == line[place]:
        last += 1
    return first, last


def _unit(x: float, y: float, z: float) -> tuple[float, float, float]:
    norm = math.sqrt(x * x + y * y + z * z)
    return x / norm, y / norm, z / norm


def ours(cloth: Weave, columns: int, rows: int) -> np.ndarray:
    """Return our normals on the same pixels."""
    warp, weft = lay_threads(cloth, 0)
    arrays = [np.zeros((rows, columns * n), np.float32) for n in COMPONENTS.values()]
    fill_rows(
        0, lay_cells(cloth.warp_edge_mm, columns), lay_cells(cloth.weft_edge_mm, rows), warp, weft,
        lay_along(warp, rows), lay_along(weft, columns), *cloth.repeat_mm,
        lay_tones(cloth.yarns), *arrays, workspace(),
    )  # fmt: skip
    return arrays[0].reshape(rows, columns, 3)


def compare() -> bool:
    """Print how far the two methods' normals differ; return if they agree."""
    # A twill: all its floats are alike, but for those that reach the border.
    cloth = cloth_of(repeat(make_draft("twill:2/2"), 4, 4), "even")
    columns = rows = 160
    normals, sound, _ = per_pixel(cloth, columns, rows)
    found = ours(cloth, columns, rows)
    worst = float(np.abs(found[sound] - normals[sound]).max()) if sound.any() else math.inf
    print(
        f"per-pixel method: normals of {sound.mean():.0%} of the texels compared, largest "
        f"difference {worst:.1e}"
    )
    return worst < 1e-6


def segmentation() -> float:
    """Print and return the seconds from a draft of 1146 × 8208 threads to its floats."""
    chance = np.random.default_rng(1)
    draft = Draft(
        threading=np.eye(24, dtype=bool)[chance.integers(0, 24, 1146)],
        liftplan=chance.random((8208, 24)) < 0.5,
        warp_color=np.zeros(1146, np.int32),
        weft_color=np.ones(8208, np.int32),
        palette=np.array([[0.8, 0.8, 0.8], [0.1, 0.1, 0.1]]),
    )
    recipe = read_preset("linen")
    seconds = least(lambda: weave(draft, recipe), 2)
    print(f"floats and layout of 1146 × 8208 threads: {seconds:.2f} s")
    return seconds


def main() -> int:
    """Print the tables; return 1 when results disagree."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="1024 texels only, fewer runs")
    quick = parser.parse_args().quick
    resolutions, runs = ((1024,), 3) if quick else ((1024, 2048, 4096), 5)
    jobs = thread_count(None)
    agree = compare()
    segmentation()
    print(f"\nns a texel and thread: on 1 thread / on {jobs} threads (times {jobs})")
    kinds = "".join(f"{kind:>16}" for kind in KINDS)
    print(f"{'threads':>14} {'texels':>7}{kinds}   per pixel   times even")
    for name, draft in drafts().items():
        plain = cloth_of(draft, "even")
        peer = min(per_pixel(plain, 128, 128)[2] for _ in range(runs)) / 128**2 * 1e9
        for resolution in resolutions:
            line, even = f"{name:>14} {resolution:>6}²", math.inf
            for kind in KINDS:
                cloth = cloth_of(draft, kind)
                work, texels = filler(cloth, resolution, 1)
                one = least(work, runs, time.process_time) / texels * 1e9
                work, _ = filler(cloth, resolution, jobs)
                every = least(work, runs) / texels * 1e9 * jobs
                even = min(even, one)
                line += f"{one:>9.1f} /{every:>5.1f}"
            print(f"{line}{peer:>12.0f}{peer / even:>13.0f}", flush=True)
    if not agree:
        print("the normals disagree", file=sys.stderr)
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
