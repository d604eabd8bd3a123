"""Pictures that lights shine through: read once, bounded, losses named."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np

from weaveusd.errors import StageError
from weaveusd.render import color, textures
from weaveusd.render.lights.inputs import Inputs

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Pixels = NDArray[np.float32]

MAX_TEXELS = 1 << 26
"""Texels of a light's picture; a larger one is halved until it has no more."""

MAX_BYTES = 4 << 30
"""Memory for the pictures of all lights of a stage; what would go beyond is refused."""


@dataclass(slots=True, eq=False)
class Picture:
    """Linear radiance, row 0 at the top, and what was changed on the way.

    `texture` is Mitsuba's, made where a surface asks for it and shared from then on.
    """

    pixels: Pixels  # (H, W, 3)
    changes: tuple[str, ...]
    texture: Any = None


def read_picture(inputs: Inputs) -> Picture | None:
    """Return the picture that `inputs:texture:file` names.

    None, and a loss, where it cannot be read; None alone where the light names none. Its color
    space is the one that the attribute states, else sRGB for 8 bits and linear for all else.
    """
    asset = inputs.value("texture:file", None)
    if not asset:
        return None
    where = f"{inputs.prim.GetPath()}.inputs:texture:file"
    try:
        path = textures.resolved(asset, where)
        key = path, inputs.color_space("texture:file")
        if key not in inputs.files:
            left = MAX_BYTES - sum(
                known.pixels.nbytes for known in inputs.files.values() if isinstance(known, Picture)
            )
            inputs.files[key] = _decoded(textures.read_image(path, where, most_bytes=left), key[1])
    except StageError as error:
        inputs.losses.dropped(inputs.prim, f"{error}: the light has one color")
        return None
    picture: Picture = inputs.files[key]
    for change in picture.changes:
        inputs.losses.approximated(inputs.prim, change)
    return picture


def on_rectangle(picture: Picture) -> Any:
    """Return the texture of a rectangle that is turned to shine along the light's -Z."""
    if picture.texture is None:
        description = {
            "type": "bitmap",
            "bitmap": mi.Bitmap(picture.pixels),
            "raw": True,
            "format": "variant",
            "wrap_mode": "clamp",
            # The rectangle's v grows with +Y, the picture's rows downwards.
            "to_uv": mi.ScalarTransform3f([[1, 0, 0], [0, -1, 1], [0, 0, 1]]),
        }
        picture.texture = mi.load_dict(description, parallel=False)
    return picture.texture


def _decoded(image: textures.Image, space: str) -> Picture:
    pixels = image.pixels if space else textures.linear(image, "auto")
    pixels = pixels[..., :3] if pixels.shape[2] >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    if space:
        pixels = color.linear(np.ascontiguousarray(pixels), space)
    changes = []
    if pixels.min() < 0:
        changes.append("negative radiance in its texture is taken as 0")
        pixels = np.maximum(pixels, 0)
    while pixels.shape[0] * pixels.shape[1] > MAX_TEXELS:
        changes = [*changes[:1], f"texture is halved until it has at most {MAX_TEXELS} texels"]
        pixels = _halved(pixels)
    return Picture(np.ascontiguousarray(pixels, np.float32), tuple(changes))


def _halved(pixels: Pixels) -> Pixels:
    """Return the means of two by two texels; an odd last row or column is left out."""
    height, width = pixels.shape[0] // 2 * 2, pixels.shape[1] // 2 * 2
    quads = pixels[:height, :width].reshape(height // 2, 2, width // 2, 2, 3)
    return np.asarray(quads.mean(axis=(1, 3)), np.float32)
