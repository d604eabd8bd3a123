"""Small pictures of every channel of an asset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.color_space import texels_to_rec709
from weaveusd.contract import CHANNELS, Channel
from weaveusd.errors import InputError
from weaveusd.validate.exhibits import Exhibit, of_display, of_linear
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.textures import decode_vectors

if TYPE_CHECKING:
    from numpy.typing import NDArray

LONGEST = 192
"""Texels along the longer side of a picture: texels are left out, none mixed."""


def channel_pictures(asset: OpenAsset) -> list[Exhibit]:
    """Return a picture of each channel whose texture can be read, linear files before others."""
    shown = []
    for channel in CHANNELS.values():
        file = channel.files[-1]
        try:
            texels = _thinned(asset, file)
        except InputError:
            continue  # texture/files reports it
        header = asset.textures.header(file)
        text = f"{file}, {header.width} × {header.height} of {header.channels} {header.dtype}"
        source = _picture(asset, channel, texels)
        shown.append(Exhibit("Channels", f"{channel.name}: {channel.meaning}", text, source))
    return shown


def _thinned(asset: OpenAsset, file: str) -> NDArray[Any]:
    """Return texels at even steps along rows and columns, in the type of the file."""
    header = asset.textures.header(file)
    step = max(1, -(-max(header.width, header.height) // LONGEST))
    rows = []
    for band in asset.textures.bands(file):
        pixels = band.pixels[file]
        rows.append(pixels[-band.first % step :: step, ::step].copy())
    return np.concatenate(rows)


def _picture(asset: OpenAsset, channel: Channel, texels: NDArray[Any]) -> str:
    if channel.encoding == "color":
        return of_linear(texels_to_rec709(texels.astype(np.float64), asset.color_space))
    if channel.encoding == "vector":
        return of_display(_levels(decode_vectors(texels) / 2 + 0.5))
    values = texels.astype(np.float64)
    if channel.encoding == "label":
        return of_display(_levels(_hues(texels[..., 0])))
    if channel.name == "fibre_angle":
        share = np.concatenate([values / 2 + 0.5, np.full_like(values[..., :1], 0.5)], axis=-1)
        return of_display(_levels(share))
    if channel.name == "rotation" and texels.dtype == np.uint8 and texels.shape[-1] == 3:
        return of_display(texels)
    finite = values[np.isfinite(values)]
    low, high = (finite.min(), finite.max()) if finite.size else (0.0, 1.0)
    if texels.dtype == np.uint8:
        low, high = 0.0, 255.0
    return of_display(_levels((values[..., :1] - low) / max(high - low, 1e-9)))


def _hues(labels: NDArray[Any]) -> NDArray[np.float64]:
    """Return (H, W, 3): a color of its own for each label, black for 0."""
    turn = labels[..., None] * 0.381966 + np.array([0.0, 1 / 3, 2 / 3])
    return np.where(labels[..., None] > 0, 0.5 + 0.4 * np.cos(2 * np.pi * turn), 0.0)


def _levels(share: NDArray[Any]) -> NDArray[np.uint8]:
    levels: NDArray[np.uint8] = np.rint(np.clip(np.nan_to_num(share), 0, 1) * 255).astype(np.uint8)
    return levels
