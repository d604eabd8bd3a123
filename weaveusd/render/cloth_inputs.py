"""What the shader of an exact cloth says: values, texture files and their color space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd, UsdShade

from weaveusd import contract
from weaveusd.color_space import texels_to_rec709
from weaveusd.errors import StageError
from weaveusd.render import textures

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

_VISIBLE = 1e-3
"""Albedo from which on clipping is a loss: a half float near 1, converted, is off by half that."""

_ROWS = 256


def where(shader: UsdShade.Shader, name: str) -> str:
    """Return how an input is named in messages."""
    return f"{shader.GetPath()}.inputs:{name}"


def value(shader: UsdShade.Shader, name: str, time: Usd.TimeCode) -> Any:
    """Return the value of an input, through connections to the material's interface."""
    given = shader.GetInput(name)
    if not given:
        return None
    sources = UsdShade.Utils.GetValueProducingAttributes(given)
    return sources[0].Get(time) if sources else None


def numbers(
    shader: UsdShade.Shader, name: str, time: Usd.TimeCode, expected: str = "float[]"
) -> list[float]:
    """Return the numbers of an input; StageError where it is no row of them."""
    stated = value(shader, name, time)
    try:
        return [float(v) for v in stated]
    except (TypeError, ValueError):
        found = " ".join(str(stated).split())[:80]
        raise StageError(f"{where(shader, name)}: is {found}, expected {expected}") from None


def image(
    shader: UsdShade.Shader,
    name: str,
    time: Usd.TimeCode,
    components: int,
    *,
    most_texels: int | None = None,
) -> textures.Image:
    """Return the picture that an input names, its file's row order kept.

    Raises
    ------
    StageError
        When `textures.read_image` refuses it, or it has fewer components.
    """
    at = where(shader, name)
    path = textures.resolved(value(shader, name, time), at)
    found = textures.read_image(path, at, most_texels=most_texels)
    if found.pixels.shape[2] < components:
        raise StageError(
            f"{at}: has {found.pixels.shape[2]} channels, expected at least {components}"
        )
    return found


def in_rec709(
    shader: UsdShade.Shader, name: str, color: NDArray[np.float32], most: ArrayLike = 1.0
) -> tuple[NDArray[np.float32], int]:
    """Return colors (H, W, 3), from the space that their input states, in linear Rec.709.

    What is converted is clipped to 0…`most`, a number or one for each texel (H, W, 1). The number
    of texels of which that shows comes second. StageError for a space that is none of the
    contract's.
    """
    sources = UsdShade.Utils.GetValueProducingAttributes(shader.GetInput(name))
    stated = str(sources[0].GetColorSpace()) if sources[0].HasColorSpace() else ""
    if stated in ("", "lin_rec709"):
        return color, 0
    space = next((known for known in contract.COLOR_SPACES if known == stated), None)
    if space is None:
        raise StageError(
            f"{where(shader, name)}: has color space {stated!r}, "
            f"expected {' or '.join(contract.COLOR_SPACES)}"
        )
    limits = np.broadcast_to(np.asarray(most, np.float32), (*color.shape[:2], 1))
    clipped = np.empty(color.shape, np.float32)
    outside = 0
    for first in range(0, len(color), _ROWS):
        rows = slice(first, first + _ROWS)
        linear = texels_to_rec709(color[rows], space)
        clipped[rows] = np.clip(linear, 0, limits[rows])
        lost = np.abs(linear - clipped[rows]) > _VISIBLE
        outside += int(np.count_nonzero(lost.any(axis=-1)))
    return clipped, outside
