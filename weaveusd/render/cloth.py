"""The exact cloth of a stage: shader inputs and texture files as a `weaveusd_cloth` BSDF."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd, UsdShade

from weaveusd import contract
from weaveusd.color_space import texels_to_rec709
from weaveusd.errors import StageError
from weaveusd.render import textures
from weaveusd.render.bsdf import packed_bsdf_dict
from weaveusd.render.distance_threads import distant_levels
from weaveusd.render.gain import albedos
from weaveusd.render.model import Losses
from weaveusd.render.optics import yarn_table
from weaveusd.render.packing import PACKED_CHANNELS, pack

if TYPE_CHECKING:
    from numpy.typing import NDArray

_INPUT_OF = {
    channel.name: input_name
    for input_name, file in contract.SHADER_FILES.items()
    for channel in contract.CHANNELS.values()
    if file in channel.files
}

_VISIBLE = 1e-3
"""Albedo from which on clipping is a loss: a half float near 1, converted, is off by half that."""

_ROWS = 256


def translate(
    shader: UsdShade.Shader, time: Usd.TimeCode, losses: Losses, *, levels: bool = False
) -> tuple[dict[str, Any], str]:
    """Return the BSDF's dictionary and the name of the primvar with the texture coordinates.

    With `levels` the BSDF has those of `distance_levels`, unseen from afar until
    `distance_cloth.with_view` gives it a view; a cloth that has none stays as it is.

    Raises
    ------
    StageError
        One line naming the input, when a file is missing or broken, a value leaves its range,
        or the yarn ids name a yarn that the shader does not describe. A cloth is never shown
        with a part of it made up.
    """
    path = shader.GetPath()
    inputs = {name: _floats(shader, name, time) for name in contract.SHADER_YARN_INPUTS}
    scale = _value(shader, contract.SHADER_UV_SCALE, time)
    if scale is None or np.size(scale) != 2:
        raise StageError(f"{path}.inputs:{contract.SHADER_UV_SCALE}: is {scale}, expected float2")
    arrays = {name: _channel(shader, name, time) for name in PACKED_CHANNELS}
    arrays["base_color"] = _rec709(shader, arrays["base_color"], losses)
    gains = _value(shader, contract.SHADER_ALBEDO_GAIN, time)
    try:
        optics = yarn_table(inputs)
        if gains is not None:
            arrays["base_color"] = albedos(
                arrays["base_color"], arrays["yarn_id"], gains, optics.shape[1]
            )
        packed, mended = pack(arrays, optics.shape[1], np.float16)  # files hold no more
        made = distant_levels(shader.GetPrim().GetParent(), arrays, optics) if levels else None
        bsdf = packed_bsdf_dict(packed, optics, (float(scale[0]), float(scale[1])), levels=made)
    except ValueError as error:
        raise StageError(f"{path}: {error}") from None
    if mended:
        losses.approximated(
            shader.GetPrim(), f"{mended} texels have a normal or tangent of no direction"
        )
    return bsdf, str(_value(shader, contract.SHADER_VARNAME, time) or contract.DEFAULT_ST)


def _channel(shader: UsdShade.Shader, name: str, time: Usd.TimeCode) -> NDArray[np.float32]:
    """Return a channel with row 0 at v = 0, in memory's meaning of its values."""
    channel, input_name = contract.CHANNELS[name], _INPUT_OF[name]
    where = f"{shader.GetPath()}.inputs:{input_name}"
    image = textures.read_image(textures.resolved(_value(shader, input_name, time), where), where)
    components = channel.components
    if image.pixels.shape[2] < components:
        raise StageError(
            f"{where}: has {image.pixels.shape[2]} channels, expected at least {components}"
        )
    if channel.encoding == "vector" and not image.is_float:
        raise StageError(f"{where}: holds {image.bits}-bit integers, expected half or float")
    if channel.encoding == "label" and (image.bits != 8 or image.is_float):
        raise StageError(f"{where}: has {image.bits} bits a texel, expected 8 for a yarn id")
    pixels = image.pixels[::-1, :, :components]
    if channel.encoding == "label":
        return np.rint(pixels * 255) + contract.GAP  # files store the index plus one
    return pixels


def _rec709(
    shader: UsdShade.Shader, color: NDArray[np.float32], losses: Losses
) -> NDArray[np.float32]:
    """Return the base color, from the color space that its input states, in linear Rec.709."""
    name = _INPUT_OF["base_color"]
    sources = UsdShade.Utils.GetValueProducingAttributes(shader.GetInput(name))
    stated = str(sources[0].GetColorSpace()) if sources[0].HasColorSpace() else ""
    if stated in ("", "lin_rec709"):
        return color
    space = next((known for known in contract.COLOR_SPACES if known == stated), None)
    if space is None:
        raise StageError(
            f"{shader.GetPath()}.inputs:{name}: has color space {stated!r}, "
            f"expected {' or '.join(contract.COLOR_SPACES)}"
        )
    clipped = np.empty(color.shape, np.float32)
    outside = 0
    for first in range(0, len(color), _ROWS):
        rows = slice(first, first + _ROWS)
        linear = texels_to_rec709(color[rows], space)
        clipped[rows] = np.clip(linear, 0, 1)
        lost = np.abs(linear - clipped[rows]) > _VISIBLE
        outside += int(np.count_nonzero(lost.any(axis=-1)))
    if outside:
        losses.approximated(
            shader.GetPrim(),
            f"{outside} texels of {name} are outside Rec.709, in which Mitsuba renders; clipped",
        )
    return clipped


def _floats(shader: UsdShade.Shader, name: str, time: Usd.TimeCode) -> list[float]:
    value = _value(shader, name, time)
    try:
        return [float(v) for v in value]
    except (TypeError, ValueError):
        raise StageError(
            f"{shader.GetPath()}.inputs:{name}: is {value}, expected float[]"
        ) from None


def _value(shader: UsdShade.Shader, name: str, time: Usd.TimeCode) -> Any:
    """Return the value of an input, through connections to the material's interface."""
    given = shader.GetInput(name)
    if not given:
        return None
    sources = UsdShade.Utils.GetValueProducingAttributes(given)
    return sources[0].Get(time) if sources else None
