"""The exact cloth of a stage: shader inputs and texture files as a `weaveusd_cloth` BSDF."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd, UsdShade

from weaveusd import contract
from weaveusd.errors import StageError
from weaveusd.render.bsdf import packed_bsdf_dict
from weaveusd.render.cloth_inputs import image, in_rec709, numbers, value, where
from weaveusd.render.distance_maps import read_levels
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


def translate(
    shader: UsdShade.Shader, time: Usd.TimeCode, losses: Losses, *, levels: bool = False
) -> tuple[dict[str, Any], str]:
    """Return the BSDF's dictionary and the name of the primvar with the texture coordinates.

    With `levels` the BSDF has those of `distance_levels`, unseen from afar until
    `distance_cloth.with_view` gives it a view. A cloth without moment maps has none, which is
    told as a loss.

    Raises
    ------
    StageError
        One line naming the input, when a file is missing or broken, a value leaves its range,
        or the yarn ids name a yarn that the shader does not describe. A cloth is never shown
        with a part of it made up.
    """
    path = shader.GetPath()
    inputs = {name: numbers(shader, name, time) for name in contract.SHADER_YARN_INPUTS}
    scale = value(shader, contract.SHADER_UV_SCALE, time)
    if scale is None or np.size(scale) != 2:
        raise StageError(f"{path}.inputs:{contract.SHADER_UV_SCALE}: is {scale}, expected float2")
    arrays = {name: _channel(shader, name, time) for name in PACKED_CHANNELS}
    base_color = _INPUT_OF["base_color"]
    arrays["base_color"], outside = in_rec709(shader, base_color, arrays["base_color"])
    if outside:
        losses.approximated(
            shader.GetPrim(),
            f"{outside} texels of {base_color} are outside Rec.709, in which Mitsuba renders; "
            "clipped",
        )
    gains = value(shader, contract.SHADER_ALBEDO_GAIN, time)
    try:
        optics = yarn_table(inputs)
        if gains is not None:
            arrays["base_color"] = albedos(
                arrays["base_color"], arrays["yarn_id"], gains, optics.shape[1]
            )
        packed, mended = pack(arrays, optics.shape[1], np.float16)  # files hold no more
        made = read_levels(shader, time, losses, optics.shape[1]) if levels else None
        bsdf = packed_bsdf_dict(packed, optics, (float(scale[0]), float(scale[1])), levels=made)
    except ValueError as error:
        raise StageError(f"{path}: {error}") from None
    if mended:
        losses.approximated(
            shader.GetPrim(), f"{mended} texels have a normal or tangent of no direction"
        )
    return bsdf, str(value(shader, contract.SHADER_VARNAME, time) or contract.DEFAULT_ST)


def _channel(shader: UsdShade.Shader, name: str, time: Usd.TimeCode) -> NDArray[np.float32]:
    """Return a channel with row 0 at v = 0, in memory's meaning of its values."""
    channel, input_name = contract.CHANNELS[name], _INPUT_OF[name]
    found = image(shader, input_name, time, channel.components)
    if channel.encoding == "vector" and not found.is_float:
        raise StageError(
            f"{where(shader, input_name)}: holds {found.bits}-bit integers, expected half or float"
        )
    if channel.encoding == "label" and (found.bits != 8 or found.is_float):
        raise StageError(
            f"{where(shader, input_name)}: has {found.bits} bits a texel, expected 8 for a yarn id"
        )
    pixels = found.pixels[::-1, :, : channel.components]
    if channel.encoding == "label":
        return np.rint(pixels * 255) + contract.GAP  # files store the index plus one
    return pixels
