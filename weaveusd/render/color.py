"""Color spaces by name, and the way from each to the linear Rec.709 in which Mitsuba renders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pxr import Gf

from weaveusd.color_space import texels_to_rec709
from weaveusd.render.textures import from_srgb

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

LINEAR = "lin_rec709_scene"

_GF_NAMES = {
    "sRGB": "srgb_rec709_scene",
    "srgb_texture": "srgb_rec709_scene",
    "srgb_tx": "srgb_rec709_scene",
    "lin_rec709": LINEAR,
    "lin_srgb": LINEAR,
    "acescg": "lin_ap1_scene",
    "lin_ap1": "lin_ap1_scene",
    "aces2065_1": "lin_ap0_scene",
    "g18_rec709": "g18_rec709_scene",
    "g22_rec709": "g22_rec709_scene",
    "g22_ap1": "g22_ap1_scene",
    "lin_rec2020": "lin_rec2020_scene",
    "lin_displayp3": "lin_p3d65_scene",
    "srgb_displayp3": "srgb_p3d65_scene",
    "adobergb": "g22_adobergb_scene",
    "lin_adobergb": "lin_adobergb_scene",
}
"""Names of MaterialX and of older stages, and those of OpenUSD and the Color Interop Forum."""

_NO_SPACE = ("", "raw", "Raw", "data", "identity", "unknown", "none", LINEAR)


def known(space: str) -> bool:
    """Return whether `linear` can convert from the color space of that name."""
    name = _GF_NAMES.get(space, space)
    return name in _NO_SPACE or bool(Gf.ColorSpace.IsValid(name))


def linear(values: Floats, space: str) -> Floats:
    """Return colors (…, 3) of a color space in linear Rec.709; not clipped.

    Spaces with another white are adapted to D65, as `Gf.ColorSpace` does. `raw` and `data`
    values stay as they are.

    Raises
    ------
    ValueError
        For a space that is not `known`.
    """
    if not known(space):
        raise ValueError(f"unknown color space {space!r}")
    name = _GF_NAMES.get(space, space)
    if name in _NO_SPACE:
        return values
    if name == "srgb_rec709_scene":
        return from_srgb(values)
    if name == "lin_ap1_scene":
        return np.asarray(texels_to_rec709(values, "acescg"), np.float32)
    source = Gf.ColorSpace(name)
    decoded = _decoded(np.asarray(values, np.float64), source)
    return np.asarray(decoded @ _matrix(source), np.float32)


def _decoded(values: NDArray[np.float64], space: Gf.ColorSpace) -> NDArray[np.float64]:
    """Undo the transfer curve: a power, with a straight line near 0 where it has a bias."""
    gamma, bias = space.GetGamma(), space.GetLinearBias()
    if gamma == 1:
        return values
    size = np.abs(values)
    curve = ((size + bias) / (1 + bias)) ** gamma
    if bias > 0:
        # The line meets the curve with its slope: IEC 61966-2-1 for the curve of sRGB.
        end = bias / (gamma - 1)
        slope = ((gamma * bias) / ((gamma - 1) * (1 + bias))) ** gamma / end
        curve = np.where(size < end, size * slope, curve)
    return np.asarray(np.copysign(curve, values))


def _matrix(space: Gf.ColorSpace) -> NDArray[np.float64]:
    """Return the (3, 3) matrix that takes rows of linear colors to Rec.709."""
    xyz = np.array(space.GetRGBToXYZ(), np.float64).reshape(3, 3)
    rec709 = np.array(Gf.ColorSpace(LINEAR).GetRGBToXYZ(), np.float64).reshape(3, 3)
    return np.asarray((np.linalg.inv(rec709) @ xyz).T)
