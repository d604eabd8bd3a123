"""A weave becomes textures."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import CHANNELS
from weaveusd.synth.model import Band, TextureSet
from weaveusd.synth.rows import share_out, thread_count

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.synth.model import Floats32

MAX_TEXELS = 1 << 15
"""Texels along one side of a texture."""

SKY_BAND_TEXELS = 2**18
"""Texels whose channels are in memory while heights are gathered for the occlusion."""


def texture_size(weave: Weave, resolution: int) -> tuple[int, int]:
    """Return width and height in texels: `resolution` on the longer side, texels near square.

    Raises ValueError unless 8 ≤ `resolution` ≤ `MAX_TEXELS`.
    """
    if not 8 <= resolution <= MAX_TEXELS:
        raise ValueError(f"resolution {resolution}, expected 8 to {MAX_TEXELS}")
    width, height = weave.repeat_mm
    longest = max(width, height)
    return (
        max(8, round(resolution * width / longest)),
        max(8, round(resolution * height / longest)),
    )


def synthesize(
    weave: Weave, *, resolution: int = 1024, seed: int = 0, jobs: int | None = None
) -> TextureSet:
    """Return the textures of one repeat of `weave`, computed when bands are asked for.

    `jobs` threads compute, by default one for each core. The same weave, resolution and seed
    give the same bits on every machine, for any bands and any number of jobs. Raises ValueError
    for a resolution out of bounds or fewer than one job.
    """
    # Imported here: numba takes half a second that nobody else should pay.
    from weaveusd.synth.occlusion import upsampled

    threads = thread_count(jobs)
    width, height = texture_size(weave, resolution)
    surface = _surface(weave, width, height, seed, threads)
    sky = cache(lambda: _sky(weave, width, height, seed, threads))

    def band(first: int, last: int) -> Band:
        if not 0 <= first <= last <= height:
            raise ValueError(f"rows {first} to {last}, expected 0 to {height}")
        out = surface(first, last)
        rows = (np.arange(first, last) + 0.5) / height
        out["ambient_occlusion"] = upsampled(sky(), rows, width)[..., None]
        return out

    return TextureSet(width, height, weave.repeat_mm, seed, band)


def _surface(
    weave: Weave, width: int, height: int, seed: int, threads: int
) -> Callable[[int, int], dict[str, Floats32]]:
    """Return the function that computes rows of every channel but the occlusion."""
    from weaveusd.synth.derived import fill_derived
    from weaveusd.synth.kernel import fill_rows
    from weaveusd.synth.piece import workspace
    from weaveusd.synth.plan import lay_along, lay_cells, lay_threads
    from weaveusd.synth.tones import lay_tones

    warp, weft = lay_threads(weave, seed)
    columns = lay_cells(weave.warp_edge_mm, width)
    rows = lay_cells(weave.weft_edge_mm, height)
    by_row, by_column = lay_along(warp, height), lay_along(weft, width)
    tones = lay_tones(weave.yarns, weave.color_space)
    systems = np.array([yarn.system == "weft" for yarn in weave.yarns], np.int32)
    repeat_width, repeat_height = weave.repeat_mm

    def band(first: int, last: int) -> dict[str, Floats32]:
        out = _empty(last - first, width)

        def fill(start: int, stop: int) -> None:
            part = {n: a[start:stop].reshape(stop - start, -1) for n, a in out.items()}
            fill_rows(
                first + start, columns, rows, warp, weft, by_row, by_column,
                repeat_width, repeat_height, tones,
                part["normal"], part["tangent"], part["height"], part["opacity"],
                part["yarn_id"], part["base_color"], workspace(),
            )  # fmt: skip
            fill_derived(
                part["tangent"], part["yarn_id"], systems, part["system"], part["fibre_angle"]
            )

        share_out(fill, last - first, threads)
        return out

    return band


def _empty(rows: int, width: int) -> dict[str, Floats32]:
    """Return room (rows, width, components) for every channel but the occlusion.

    It is one allocation: of many, the system takes the memory back after each band and clears it
    anew for the next, which takes longer than the texels.
    """
    components = {
        name: channel.components
        for name, channel in CHANNELS.items()
        if name != "ambient_occlusion" and not channel.per_yarn
    }
    room = np.empty(rows * width * sum(components.values()), np.float32)
    out, first = {}, 0
    for name, count in components.items():
        last = first + rows * width * count
        out[name] = room[first:last].reshape(rows, width, count)
        first = last
    return out


def _sky(weave: Weave, width: int, height: int, seed: int, threads: int) -> Floats32:
    """Return the occlusion (h, w), on a grid no finer than it needs."""
    from weaveusd.synth.occlusion import occlusion, texels_for

    repeat_width, repeat_height = weave.repeat_mm
    pitch_x, pitch_y = repeat_width / weave.ends, repeat_height / weave.picks
    w = max(8, width // texels_for(pitch_x, repeat_width / width))
    h = max(8, height // texels_for(pitch_y, repeat_height / height))
    surface = _surface(weave, w, h, seed, threads)
    heights = np.empty((h, w), np.float32)
    rows = max(1, SKY_BAND_TEXELS // w)
    for first in range(0, h, rows):
        last = min(h, first + rows)
        heights[first:last] = surface(first, last)["height"][..., 0]
    texel_mm = (repeat_width / w, repeat_height / h)
    return occlusion(heights, texel_mm, max(pitch_x, pitch_y), threads)
