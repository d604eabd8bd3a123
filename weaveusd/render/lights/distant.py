"""DistantLight: a sun, soft where it has an angle."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from weaveusd.render.lights.emitters import sun
from weaveusd.render.lights.inputs import Inputs, bounded, emission
from weaveusd.render.lights.shaping import read_shaping
from weaveusd.render.xforms import Placing

_WIDEST = math.radians(359.9)
"""The schema asks for an angle below 360°."""


def distant(inputs: Inputs, placing: Placing) -> dict[str, Any]:
    """Return the emitter of a DistantLight.

    With θ half its angle, its radiance is L / size with normalize and L without; a surface that
    faces it receives π sin²θ of it. size is π sin²θ up to θ = π/2, π (2 - sin²θ) beyond, and 1
    for an angle of 0, where the light is parallel and L its irradiance (UsdLux LightAPI).

    Raises
    ------
    Refused
        When one of its numbers is none.
    """
    value = emission(inputs)
    half = min(math.radians(inputs.extent("angle", 0.53)), _WIDEST) / 2
    toward = placing.world(inputs.prim)[:3, 2]
    toward = toward / np.linalg.norm(toward)
    if not read_shaping(inputs, placing.world(inputs.prim)).unasked:
        inputs.losses.dropped(inputs.prim, "shaping of a light without a place")
    if half == 0:
        return {
            "type": "directional",
            "direction": (-toward).tolist(),
            "irradiance": {"type": "rgb", "value": value.tolist()},
        }
    if inputs.flag("normalize"):
        value = bounded(value / size(half))
    return sun(toward, value, half)


def size(half_angle_rad: float) -> float:
    """Return by what `normalize` divides the radiance of a light of this half angle, above 0."""
    square = math.sin(half_angle_rad) ** 2
    return math.pi * (square if half_angle_rad <= math.pi / 2 else 2 - square)
