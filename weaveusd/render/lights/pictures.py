"""Pictures that lights shine through: read as radiance, bounded, losses named."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from weaveusd.errors import StageError
from weaveusd.render import textures
from weaveusd.render.lights.inputs import Inputs

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_TEXELS = 1 << 26
"""Texels of a light's picture; a larger one is halved until it has no more."""


def read_picture(inputs: Inputs) -> NDArray[np.float32] | None:
    """Return `inputs:texture:file` as linear radiance (H, W, 3), row 0 at the top.

    None, and a loss, where there is no file or one that cannot be read; None alone where the
    light names none. Pictures of 8 bits are decoded as sRGB, floats are as they are.
    """
    asset = inputs.value("texture:file", None)
    if not asset:
        return None
    where = f"{inputs.prim.GetPath()}.inputs:texture:file"
    try:
        image = textures.read_image(textures.resolved(asset, where), where)
    except StageError as error:
        inputs.losses.dropped(inputs.prim, f"{error}: the light has one color")
        return None
    pixels = textures.linear(image, "auto")
    pixels = pixels[..., :3] if pixels.shape[2] >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    if pixels.min() < 0:
        inputs.losses.approximated(inputs.prim, "negative radiance in its texture is taken as 0")
        pixels = np.maximum(pixels, 0)
    while pixels.shape[0] * pixels.shape[1] > MAX_TEXELS:
        inputs.losses.approximated(inputs.prim, f"texture beyond {MAX_TEXELS} texels is halved")
        pixels = _halved(pixels)
    return np.ascontiguousarray(pixels, np.float32)


def _halved(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the means of two by two texels; an odd last row or column is left out."""
    height, width = pixels.shape[0] // 2 * 2, pixels.shape[1] // 2 * 2
    quads = pixels[:height, :width].reshape(height // 2, 2, width // 2, 2, 3)
    return np.asarray(quads.mean(axis=(1, 3)), np.float32)
