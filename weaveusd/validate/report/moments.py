"""Small pictures of the moment maps of an asset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.color_space import texels_to_rec709
from weaveusd.contract import MOMENT_MAPS, SYSTEMS, moment_file
from weaveusd.errors import InputError
from weaveusd.validate.exhibits import Exhibit, of_display, of_linear
from weaveusd.validate.moment_maps import expected_maps, read_map
from weaveusd.validate.open_asset import OpenAsset

if TYPE_CHECKING:
    from numpy.typing import NDArray

GROUP = "Moment maps"

LONGEST = 192
"""Texels along the longer side of a picture, at most: texels are left out, none mixed."""

GAP = 2


def moment_pictures(asset: OpenAsset) -> list[Exhibit]:
    """Return a picture of each moment map that can be read; of assets without them none.

    That of the albedo is its color on black; the others show their four components in gray, side
    by side and from the top: black 0 and white the largest value, which the text tells, or black
    its opposite where there are values below 0.
    """
    if asset.lacks("shader") or asset.lacks("moments"):
        return []
    shown = []
    for system in SYSTEMS:
        for name in expected_maps(asset, system):
            file = moment_file(system, name)
            try:
                texels = read_map(asset, file)
            except InputError:
                continue  # texture/moments reports it
            described = MOMENT_MAPS[name]
            largest = np.nan_to_num(np.abs(texels.astype(np.float64))).max(axis=(0, 1))
            text = f"{file}, {texels.shape[1]} × {texels.shape[0]}: " + ", ".join(
                f"{component} to {value:.2g}"
                for component, value in zip(described.components, largest, strict=True)
            )
            source = _color(asset, texels) if name == "albedo" else _sheet(texels, largest)
            shown.append(Exhibit(GROUP, f"{system}: {described.meaning}", text, source))
    return shown


def _color(asset: OpenAsset, texels: NDArray[Any]) -> str:
    color = _thinned(texels, LONGEST)[..., :3].astype(np.float64)
    return of_linear(texels_to_rec709(color, asset.color_space))


def _sheet(texels: NDArray[Any], largest: NDArray[np.float64]) -> str:
    """Return the components as four pictures in one: two beside each other, two below."""
    values = np.nan_to_num(_thinned(texels, LONGEST // 2).astype(np.float64))
    height, width = values.shape[:2]
    sheet = np.ones((2 * height + GAP, 2 * width + GAP))
    for k in range(4):
        one = values[..., k] / max(float(largest[k]), 1e-6)
        row, column = k // 2 * (height + GAP), k % 2 * (width + GAP)
        sheet[row : row + height, column : column + width] = one / 2 + 0.5 if one.min() < 0 else one
    levels = np.rint(np.clip(sheet, 0, 1) * 255).astype(np.uint8)
    return of_display(levels[..., None])


def _thinned(texels: NDArray[Any], longest: int) -> NDArray[Any]:
    step = max(1, -(-max(texels.shape[:2]) // longest))
    return texels[::step, ::step]
