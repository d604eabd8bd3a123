"""UsdGeom's analytic shapes as Mitsuba's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd, UsdGeom

from weaveusd.render.model import Losses
from weaveusd.render.xforms import rotation, scaling, singular, to_mitsuba, uniform_scale

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


def translate(
    prim: Usd.Prim, world: Doubles, time: Usd.TimeCode, losses: Losses
) -> dict[str, Any] | None:
    """Return the shape's dictionary without material, or None where it is dropped."""
    if prim.IsA(UsdGeom.Sphere):
        kind, size = "sphere", scaling(*(UsdGeom.Sphere(prim).GetRadiusAttr().Get(time),) * 3)
        if uniform_scale(world) is None:
            losses.dropped(prim, "sphere stretched to an ellipsoid")
            return None
    elif prim.IsA(UsdGeom.Cube):
        kind, size = "cube", scaling(*(UsdGeom.Cube(prim).GetSizeAttr().Get(time) / 2,) * 3)
    elif prim.IsA(UsdGeom.Plane):
        kind, size = "rectangle", _plane(prim, time)
    else:
        losses.dropped(prim, f"{prim.GetTypeName()} is not supported")
        return None
    if singular(size):
        losses.dropped(prim, f"{kind} has no extent")
        return None
    return {"type": kind, "to_world": to_mitsuba(world @ size)}


def _plane(prim: Usd.Prim, time: Usd.TimeCode) -> Doubles:
    """Return what makes Mitsuba's rectangle a plane of USD.

    Its width runs along x, or z for axis X; its length along y, or z for axis Y.
    """
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
    return turn @ scaling(half_width, half_length, 1)
