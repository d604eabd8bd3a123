"""A weave becomes textures."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import CHANNELS
from weaveusd.synth.model import Band, TextureSet

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.synth.model import Floats32

MAX_TEXELS = 1 << 15
"""Texels along one side of a texture."""


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


def synthesize(weave: Weave, *, resolution: int = 1024, seed: int = 0) -> TextureSet:
    """Return the textures of one repeat of `weave`, computed when bands are asked for.

    The same weave, resolution and seed give the same bits on every machine, for any bands.
    Raises ValueError for a resolution out of bounds.
    """
    # Imported here: numba takes half a second that nobody else should pay.
    from weaveusd.synth.occlusion import upsampled

    width, height = texture_size(weave, resolution)
    surface = _surface(weave, width, height, seed)
    sky = cache(lambda: _sky(weave, width, height, seed))

    def band(first: int, last: int) -> Band:
        if not 0 <= first <= last <= height:
            raise ValueError(f"rows {first} to {last}, expected 0 to {height}")
        out = surface(first, last)
        rows = (np.arange(first, last) + 0.5) / height
        out["ambient_occlusion"] = upsampled(sky(), rows, width)[..., None]
        return out

    return TextureSet(width, height, weave.repeat_mm, seed, band)


def _surface(
    weave: Weave, width: int, height: int, seed: int
) -> Callable[[int, int], dict[str, Floats32]]:
    """Return the function that computes rows of every channel but the occlusion."""
    from weaveusd.synth.kernel import fill_rows
    from weaveusd.synth.plan import lay_cells, lay_threads
    from weaveusd.synth.tones import lay_tones

    warp, weft = lay_threads(weave, seed)
    columns = lay_cells(weave.warp_edge_mm, width)
    rows = lay_cells(weave.weft_edge_mm, height)
    tones = lay_tones(weave.yarns)
    repeat_width, repeat_height = weave.repeat_mm

    def band(first: int, last: int) -> dict[str, Floats32]:
        out = {
            name: np.empty((last - first, width, channel.components), np.float32)
            for name, channel in CHANNELS.items()
            if name != "ambient_occlusion" and not channel.per_yarn
        }
        fill_rows(
            first, columns, rows, warp, weft, repeat_width, repeat_height, tones,
            out["normal"], out["tangent"], out["height"], out["opacity"], out["yarn_id"],
            out["base_color"], out["system"], out["fibre_angle"],
        )  # fmt: skip
        return out

    return band


def _sky(weave: Weave, width: int, height: int, seed: int) -> Floats32:
    """Return the occlusion (h, w), on a grid no finer than it needs."""
    from weaveusd.synth.occlusion import occlusion, texels_for

    repeat_width, repeat_height = weave.repeat_mm
    pitch_x, pitch_y = repeat_width / weave.ends, repeat_height / weave.picks
    w = max(8, width // texels_for(pitch_x, repeat_width / width))
    h = max(8, height // texels_for(pitch_y, repeat_height / height))
    heights = _surface(weave, w, h, seed)(0, h)["height"][..., 0]
    return occlusion(heights, (repeat_width / w, repeat_height / h), max(pitch_x, pitch_y))
