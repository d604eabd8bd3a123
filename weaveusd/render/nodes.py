"""Nodes of UsdShade networks: what feeds an input, and what a node means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd, UsdShade

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


def node_value(node: UsdShade.Shader, name: str, time: Usd.TimeCode) -> Any:
    """Return the value of an input through its connections, None if a node's output feeds it."""
    given = node.GetInput(name)
    if not given:
        return None
    for attribute in UsdShade.Utils.GetValueProducingAttributes(given):
        if not UsdShade.Output.IsOutput(attribute):
            return attribute.Get(time)
    return given.Get(time)


def feeding_node(node: UsdShade.Shader, name: str) -> UsdShade.Shader | None:
    """Return the node whose output feeds an input, or None."""
    given = node.GetInput(name)
    if not given:
        return None
    for attribute in UsdShade.Utils.GetValueProducingAttributes(given):
        shader = UsdShade.Shader(attribute.GetPrim())
        if UsdShade.Output.IsOutput(attribute) and shader:
            return shader
    return None


def transform_2d(node: UsdShade.Shader, time: Usd.TimeCode) -> Doubles:
    """Return T·R·S of a UsdTransform2d; it rotates counter-clockwise, in degrees."""
    scale = node_value(node, "scale", time)
    shift = node_value(node, "translation", time)
    angle = np.radians(float(node_value(node, "rotation", time) or 0.0))
    c, s = float(np.cos(angle)), float(np.sin(angle))
    sx, sy = scale if scale is not None else (1.0, 1.0)
    tx, ty = shift if shift is not None else (0.0, 0.0)
    rotated = np.array(((c, -s, tx), (s, c, ty), (0.0, 0.0, 1.0)))
    return rotated @ np.diag((float(sx), float(sy), 1.0))


def four_channels(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the pixels as RGBA: gray is repeated, a missing alpha is 1."""
    channels = pixels.shape[2]
    alpha = pixels[..., -1:] if channels in (2, 4) else np.ones_like(pixels[..., :1])
    color = pixels[..., :3] if channels >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    return np.concatenate((color, alpha), axis=2)
