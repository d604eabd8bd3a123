"""The colors of a cloth's yarns, in its color space and within 0…1."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from weaveusd.color_space import DISPLAY_NAMES, from_rec709, to_rec709
from weaveusd.yarn.color import linear_from_srgb
from weaveusd.yarn.colorimetry import delta_e_2000

if TYPE_CHECKING:
    from weaveusd.contract import ColorSpace
    from weaveusd.yarn.irregularity import Irregularity
    from weaveusd.yarn.model import RGB, YarnSpec

VISIBLE_DELTA_E = 0.1
"""CIEDE2000 from which on a color that had to be changed is reported."""


def laid_colors(spec: YarnSpec, of_draft: RGB, space: ColorSpace) -> tuple[RGB, Irregularity]:
    """Return the albedo of a yarn and its irregularity, every color clipped in `space`.

    `of_draft`, display sRGB, serves a yarn that states no color. The albedo of a mélange or
    mouliné is the mean of its colors as they came out.
    """
    uneven = spec.irregularity
    melange = tuple((_within(color, space), share) for color, share in uneven.melange)
    strands = tuple(_within(color, space) for color in uneven.strands)
    parts = melange or tuple((color, 1 / len(strands)) for color in strands)
    if not parts:
        return _within(linear_from_srgb(spec.color or of_draft), space), uneven
    r, g, b = (min(1.0, math.fsum(share * color[i] for color, share in parts)) for i in range(3))
    return (r, g, b), replace(uneven, melange=melange, strands=strands)


def clipped_colors(specs: Sequence[YarnSpec], space: ColorSpace) -> Iterator[str]:
    """Yield a line for each color of `specs` that is visibly another when clipped in `space`."""
    for spec in specs:
        for color in spec.colors_outside:
            asked = from_rec709(color.linear, space)
            lost = delta_e_2000(color.linear, to_rec709(_clipped(asked), space))
            if lost >= VISIBLE_DELTA_E:
                values = ", ".join(f"{v:.3f}" for v in asked)
                yield (
                    f"{color.stated} is outside {DISPLAY_NAMES[space]} (linear {values}); "
                    f"clipped, CIEDE2000 {lost:.1f}"
                )


def _within(linear: RGB, space: ColorSpace) -> RGB:
    """Return a color of linear Rec.709 in `space`, clipped."""
    return _clipped(from_rec709(linear, space))


def _clipped(color: RGB) -> RGB:
    r, g, b = (min(1.0, max(0.0, v)) for v in color)
    return r, g, b
