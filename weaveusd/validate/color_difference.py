"""How far two colors are from each other, by colour-science."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


def delta_e_2000(one: Any, other: Any) -> Doubles:
    """Return CIE ΔE2000 (…) of colors (…, 3) in linear Rec.709, 1 being white under D65."""
    import colour

    space = colour.RGB_COLOURSPACES["sRGB"]
    labs = []
    for color in (one, other):
        xyz = np.asarray(color, np.float64) @ np.asarray(space.matrix_RGB_to_XYZ).T
        labs.append(colour.XYZ_to_Lab(xyz, space.whitepoint))
    return np.asarray(colour.delta_E(*labs, method="CIE 2000"), np.float64)


def mean_delta_e(one: NDArray[np.float32], other: NDArray[np.float32]) -> float:
    """Return CIE ΔE2000 of the mean colors of two pictures (h, w, 3) in linear Rec.709."""
    return float(delta_e_2000(one.mean(axis=(0, 1)), other.mean(axis=(0, 1))))
