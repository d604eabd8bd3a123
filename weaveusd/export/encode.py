"""The numbers that a texture file stores for the values of a channel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.color_space import texels_to_rec709
from weaveusd.contract import VECTOR_PNG_LEVELS, Channel, ColorSpace
from weaveusd.synth.compiled import compiled
from weaveusd.yarn.color import decode_srgb

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.synth.model import Floats32

    Bytes = NDArray[np.uint8]
    Words = NDArray[np.uint16]


def encode(
    channel: Channel, suffix: str, values: Floats32, color_space: ColorSpace = "lin_rec709"
) -> NDArray[Any]:
    """Return `values` of `channel` as the numbers that its file of `suffix` stores.

    Colors are in `color_space`.

    Raises
    ------
    ValueError
        A label leaves 8 bits.
    """
    if suffix == ".exr":
        return np.asarray(values, dtype=np.float16)
    if channel.encoding == "color":
        if color_space != "lin_rec709":
            # Of the halves in the EXR: dark components are small differences of large ones.
            halves = np.asarray(values, np.float16)
            values = texels_to_rec709(halves, color_space).astype(np.float32)
        linear = np.ascontiguousarray(values, np.float32)
        codes = np.empty(linear.shape, np.uint8)
        _fill_codes(linear.ravel(), linear.view(np.uint32).ravel(), _BELOW, _STEPS, codes.ravel())
        return codes
    if channel.encoding == "vector":
        components = np.ascontiguousarray(values, np.float32)
        levels = np.empty(components.shape, np.uint16)
        _fill_levels(components.ravel(), levels.ravel())
        return levels
    if channel.encoding == "label":
        labels = np.rint(values) + 1
        if labels.min() < 0 or labels.max() > 255:
            raise ValueError(f"{channel.name}: {labels.min():g}…{labels.max():g} leaves 8 bits")
        return np.asarray(labels, dtype=np.uint8)
    share = (np.asarray(values, dtype=np.float64) - channel.low) / (1 - channel.low)
    share = np.clip(share, 0, 1)
    return np.asarray(np.rint(share * 255), dtype=np.uint8)


# Comparing with the borders between codes rounds exactly, on every machine alike; the power
# functions of vector units differ in their last bit.
_STEPS = np.array([decode_srgb((k + 0.5) / 255) for k in range(255)] + [np.nan], np.float32)
"""The least linear value of the code after each of 8 bits; none after the last."""

_SHARED_BITS = 15
"""Low bits of a float that are left out of its cell: a cell holds one border at most."""

_BELOW = np.searchsorted(
    _STEPS, (np.arange(1 << 17, dtype=np.uint32) << _SHARED_BITS).view(np.float32), side="right"
).astype(np.uint8)
"""The code of the first float of each cell, of those that are not negative."""


@compiled
def _fill_codes(
    linear: Floats32, bits: NDArray[np.uint32], below: Bytes, steps: Floats32, codes: Bytes
) -> None:
    """Fill in the codes under the sRGB curve of `linear`, whose bits are `bits`."""
    for k in range(len(linear)):
        code = below[bits[k] >> _SHARED_BITS]
        codes[k] = code + (linear[k] >= steps[code])


@compiled
def _fill_levels(components: Floats32, levels: Words) -> None:
    """Fill in the levels of 16 bits of the components of vectors, clipped to -1…1."""
    half = VECTOR_PNG_LEVELS // 2
    for k in range(len(components)):
        level = np.rint(np.float64(components[k]) * half) + half
        levels[k] = np.uint16(min(max(level, 0.0), float(VECTOR_PNG_LEVELS)))
