"""The color spaces that a cloth may be in, and the way from one to the other.

Makers and judges share these constants; `contract.COLOR_SPACES` names the spaces.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.contract import ColorSpace

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

RGB = tuple[float, float, float]
Matrix = tuple[RGB, RGB, RGB]

REC709_TO_ACESCG: Matrix = (
    (0.6130974024011873, 0.33952314618410573, 0.0473794514147067),
    (0.07019372246958172, 0.9163538790573439, 0.01345239847307408),
    (0.02061559288222692, 0.10956977293813543, 0.8698146341796373),
)
"""Linear Rec.709 (ITU-R BT.709-6, D65) to ACEScg (S-2014-004, AP1), Bradford from white to white.

From colour-science 0.4.7, ``matrix_RGB_to_RGB("ITU-R BT.709", "ACEScg", "Bradford")``.
"""

ACESCG_TO_REC709: Matrix = (
    (1.7050509926579844, -0.6217921206570053, -0.08325887200097878),
    (-0.13025641750704356, 1.1408047365754017, -0.01054831906835798),
    (-0.02400335680461804, -0.1289689760649706, 1.152972332869589),
)
"""The inverse of `REC709_TO_ACESCG`."""

LUMINANCE: dict[ColorSpace, RGB] = {
    "lin_rec709": (0.2126, 0.7152, 0.0722),
    "acescg": (0.2722287167809146, 0.6740817658111483, 0.05368951740793703),
}
"""Relative luminance of each primary: ITU-R BT.709-6, and the second row of AP1 to XYZ."""

DISPLAY_NAMES: dict[ColorSpace, str] = {"lin_rec709": "Rec.709", "acescg": "ACEScg"}


def from_rec709(color: RGB, space: ColorSpace) -> RGB:
    """Return a color of linear Rec.709 in `space`; not clipped."""
    return color if space == "lin_rec709" else _mixed(REC709_TO_ACESCG, *color)


def to_rec709(color: RGB, space: ColorSpace) -> RGB:
    """Return a color of `space` in linear Rec.709; not clipped."""
    return color if space == "lin_rec709" else _mixed(ACESCG_TO_REC709, *color)


def texels_to_rec709(texels: NDArray[Any], space: ColorSpace) -> Doubles:
    """Return `texels` (…, 3) of `space` in linear Rec.709; not clipped.

    Sums run in one order, so that every machine gives the same bits.
    """
    values = np.asarray(texels, np.float64)
    if space == "lin_rec709":
        return values
    return np.stack(_mixed(ACESCG_TO_REC709, *np.moveaxis(values, -1, 0)), axis=-1)


def _mixed(matrix: Matrix, red: Any, green: Any, blue: Any) -> Any:
    """Return the three rows of `matrix` times a color, numbers or arrays."""
    return tuple(r * red + g * green + b * blue for r, g, b in matrix)
