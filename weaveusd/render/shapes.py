"""UsdGeom's analytic shapes as Mitsuba's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd, UsdGeom

from weaveusd.render.model import Losses
from weaveusd.render.xforms import rotation, scaling, to_mitsuba, uniform_scale

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


def translate(
    prim: Usd.Prim, world: Doubles, time: Usd.TimeCode, losses: Losses
) -> dict[str, Any] | None:
    """Return the shape's dictionary without material, or None where it is dropped."""
    if prim.IsA(UsdGeom.Sphere):
        return _sphere(prim, world, time, losses)
    if prim.IsA(UsdGeom.Cube):
        half = UsdGeom.Cube(prim).GetSizeAttr().Get(time) / 2
        return {"type": "cube", "to_world": to_mitsuba(world @ scaling(half, half, half))}
    if prim.IsA(UsdGeom.Plane):
        return _plane(prim, world, time)
    losses.dropped(prim, f"{prim.GetTypeName()} is not supported")
    return None


def _sphere(
    prim: Usd.Prim, world: Doubles, time: Usd.TimeCode, losses: Losses
) -> dict[str, Any] | None:
    radius = UsdGeom.Sphere(prim).GetRadiusAttr().Get(time)
    if not radius > 0:
        losses.dropped(prim, f"sphere has radius {radius:g}")
        return None
    if uniform_scale(world) is None:
        losses.dropped(prim, "sphere stretched to an ellipsoid")
        return None
    return {"type": "sphere", "to_world": to_mitsuba(world @ scaling(radius, radius, radius))}


def _plane(prim: Usd.Prim, world: Doubles, time: Usd.TimeCode) -> dict[str, Any]:
    """Return a rectangle. USD: width runs along x, or z for axis X; length along y, or z for Y."""
    plane = UsdGeom.Plane(prim)
    half_width, half_length = (
        plane.GetWidthAttr().Get(time) / 2,
        plane.GetLengthAttr().Get(time) / 2,
    )
    axis = plane.GetAxisAttr().Get(time)
    if axis == UsdGeom.Tokens.x:
        turn = rotation("Y", 90)
    elif axis == UsdGeom.Tokens.y:
        turn = rotation("X", -90)
    else:
        turn = np.eye(4)
    matrix = world @ turn @ scaling(half_width, half_length, 1)
    return {"type": "rectangle", "to_world": to_mitsuba(matrix)}
