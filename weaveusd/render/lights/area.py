"""Lights with a surface: rect, disk, sphere and cylinder.

Radiance is L of `emission`, divided with `normalize` by the area in the units of the stage. What
Mitsuba's own shapes cannot take becomes a mesh: stretched spheres, and tubes. Its cylinder is met
up to a third of its radius off where it is thin and far, so that a ray that has just entered may
enter once more, and then counts without the weight that shadow rays leave it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np

from weaveusd.render.lights import solids
from weaveusd.render.lights.emitters import glow, of_ball, spot
from weaveusd.render.lights.inputs import Inputs, Refused, bounded, emission
from weaveusd.render.lights.pictures import on_rectangle, read_picture
from weaveusd.render.lights.shaping import read_shaping
from weaveusd.render.xforms import (
    Placing,
    rotation,
    scaling,
    singular,
    to_mitsuba,
    uniform_scale,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Entry = dict[str, Any]

CLEAR: dict[str, Any] = {"type": "null"}
"""A light's own surface: it shines, and stands in the way of nothing."""

_LINE = 1e-3
"""Radius over length of a line light, which has none of its own."""


def rect(inputs: Inputs, placing: Placing) -> Entry:
    """Return a rectangle that shines along -Z; its texture's top left lies on (+X, +Y)."""
    half_width = inputs.extent("width", 1.0) / 2
    half_height = inputs.extent("height", 1.0) / 2
    picture = read_picture(inputs)
    texture = None if picture is None else on_rectangle(picture)
    return _flat("rectangle", inputs, placing, (half_width, half_height), 4.0, texture)


def disk(inputs: Inputs, placing: Placing) -> Entry:
    """Return a disk that shines along -Z; scaled unevenly it is an ellipse."""
    radius = inputs.extent("radius", 0.5)
    return _flat("disk", inputs, placing, (radius, radius), math.pi)


def sphere(inputs: Inputs, placing: Placing) -> Entry | Any:
    """Return a sphere, an ellipsoid where it is stretched, or a point where it asks for one.

    A point has the intensity π r² L along every direction, which a sphere has from afar.
    """
    radius, world = inputs.extent("radius", 0.5), placing.unscaled(inputs.prim)
    as_point = bool(inputs.prim.GetAttribute("treatAsPoint").Get(inputs.time))
    if radius == 0 and not as_point:
        inputs.losses.approximated(inputs.prim, "sphere light of radius 0 is shown as a point")
    if radius == 0 or as_point:
        return _point(inputs, placing, radius)
    matrix = world @ scaling(radius, radius, radius)
    area = solids.ellipsoid_area(matrix[:3, :3])
    scale = uniform_scale(world)
    if scale is None:
        place = placing.world(inputs.prim) @ scaling(radius, radius, radius)
        return _mesh(inputs, placing, solids.ellipsoid, place, area)
    place = np.eye(4)
    place[:3, 3] = placing.world(inputs.prim)[:3, 3]
    across = radius * scale * placing.scale
    return _shape("sphere", inputs, placing, place @ scaling(across, across, across), area)


def cylinder(inputs: Inputs, placing: Placing) -> Any:
    """Return an open tube along X that shines outward; one of radius 0 is given a thin one."""
    radius, length = inputs.extent("radius", 0.5), inputs.extent("length", 1.0)
    if radius == 0:
        inputs.losses.approximated(
            inputs.prim, f"cylinder light of radius 0 is shown {_LINE:g} of its length thick"
        )
        radius = length * _LINE
    turn = rotation("Y", 90) @ scaling(radius, radius, length)  # a tube of ours runs along z
    turn[0, 3] = -length / 2
    area = solids.tube_area((placing.unscaled(inputs.prim) @ turn)[:3, :3])
    return _mesh(inputs, placing, solids.tube, placing.world(inputs.prim) @ turn, area)


def emitter(
    inputs: Inputs, placing: Placing, area: float, texture: Any = None, share: float = 1.0
) -> Entry:
    """Return what makes a shape of this area, in units of the stage, shine as the light says.

    `share` is the area over that of the shape which stands for it: its power stays.

    Raises
    ------
    Refused
        When the light has no extent, or one of its numbers is none.
    """
    brightness = bounded(radiance(inputs, area) * share)
    shaping = read_shaping(inputs, placing.world(inputs.prim))
    if texture is None and shaping.neutral:
        return {"type": "area", "radiance": _rgb(brightness)}
    return glow(texture or _rgb(np.ones(3)), brightness, shaping)


def radiance(inputs: Inputs, area: float) -> Doubles:
    """Return the radiance of a surface light of this area, in units of the stage, or refuse it."""
    if not 0 < area < math.inf:
        raise Refused("light has no extent")
    value = emission(inputs)
    return bounded(value / area) if inputs.flag("normalize") else value


def _flat(
    kind: str, inputs: Inputs, placing: Placing, half: tuple[float, float], share: float,
    texture: Any = None,
) -> Entry:  # fmt: skip
    """Return a flat shape whose area is `share` times the product of its half axes."""
    turn = rotation("Y", 180) @ scaling(*half, 1)
    axes = (placing.unscaled(inputs.prim) @ turn)[:3, :3]
    area = share * float(np.linalg.norm(np.cross(axes[:, 0], axes[:, 1])))
    matrix = placing.world(inputs.prim) @ turn
    return _shape(kind, inputs, placing, matrix, area, texture)


def _shape(
    kind: str, inputs: Inputs, placing: Placing, matrix: Doubles, area: float,
    texture: Any = None,
) -> Entry:  # fmt: skip
    """Return a clear shape that shines."""
    if singular(matrix):
        raise Refused("light has no extent")
    shining = emitter(inputs, placing, area, texture)
    if kind == "sphere":
        shining = of_ball(shining, matrix)
    return {"type": kind, "to_world": to_mitsuba(matrix), "bsdf": CLEAR, "emitter": shining}


def _mesh(
    inputs: Inputs, placing: Placing, make: Callable[[Doubles], solids.Solid], matrix: Doubles,
    area: float,
) -> Any:  # fmt: skip
    """Return a clear mesh that shines outward; the least thickness it is given costs no power."""
    made = make(solids.at_least_fine(matrix))
    shown = made.area() / placing.scale**2
    if not 0 < shown < math.inf:
        raise Refused("light has no extent")
    shining = emitter(inputs, placing, area, share=area / shown)
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict(CLEAR, parallel=False)
    properties["mesh_emitter"] = mi.load_dict(shining, parallel=False)
    return solids.to_mesh(str(inputs.prim.GetPath()), made, properties)


def _point(inputs: Inputs, placing: Placing, radius: float) -> Entry:
    world = placing.unscaled(inputs.prim)
    scale = uniform_scale(world) or abs(float(np.linalg.det(world[:3, :3]))) ** (1 / 3)
    size = radius * scale
    value = emission(inputs)
    # With normalize, π r² of L / (4 π r²).
    intensity = value * (0.25 if inputs.flag("normalize") else math.pi * size * size)
    if not intensity.any() and value.any():
        raise Refused("light has no extent")
    intensity = bounded(intensity * placing.scale**2)
    position = placing.world(inputs.prim)[:3, 3]
    shaping = read_shaping(inputs, placing.world(inputs.prim))
    if shaping.neutral:
        return {"type": "point", "position": position.tolist(), "intensity": _rgb(intensity)}
    return spot(position, intensity, shaping)


def _rgb(values: Doubles) -> Entry:
    return {"type": "rgb", "value": [float(v) for v in values]}
