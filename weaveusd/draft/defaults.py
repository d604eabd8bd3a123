"""The colors of threads for which nobody named any: indigo warp, ecru weft."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from weaveusd.draft.model import Doubles

DEFAULT_COLORS = ("26364f", "ece6d8")
"""Warp and weft as display sRGB."""


def palette_of(*colors: str) -> Doubles:
    """Return colors of six hexadecimal digits as a palette (P, 3) in 0…1."""
    return np.array([list(bytes.fromhex(color)) for color in colors]) / 255


def default_palette() -> Doubles:
    """Return the two usual colors (2, 3): entry 0 for the warp, 1 for the weft."""
    return palette_of(*DEFAULT_COLORS)
