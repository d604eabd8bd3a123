"""UsdGeom cameras, and the camera of a stage that has none."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd, UsdGeom

from weaveusd.errors import StageError
from weaveusd.render.model import Losses
from weaveusd.render.xforms import Placing, rotation, to_mitsuba

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

_FRAMING_FOV = 35.0
_NEAREST, _FARTHEST = 1e-5, 1e4
"""Clipping in picture extents where the stage authors none: USD's fallback of 1 stage unit
would cut off whatever is small."""


def find_camera(stage: Usd.Stage, path: str | None) -> Usd.Prim | None:
    """Return the camera at `path`, else the stage's first one, else None.

    Raises
    ------
    StageError
        When `path` names no camera.
    """
    if path is not None:
        prim = stage.GetPrimAtPath(path) if path.startswith("/") else None
        if not prim or not prim.IsA(UsdGeom.Camera):
            root = stage.GetRootLayer().identifier
            raise StageError(f"{root}: {path} is no camera")
        return prim
    return next((p for p in stage.Traverse() if p.IsA(UsdGeom.Camera)), None)


def aspect_of(prim: Usd.Prim | None) -> float:
    """Return width over height of the camera's aperture; 1 without a camera."""
    if prim is None:
        return 1.0
    across, up = _aperture(UsdGeom.Camera(prim), Usd.TimeCode.EarliestTime())
    return across / up


def sensor(
    prim: Usd.Prim, size: tuple[int, int], extent: float, placing: Placing, losses: Losses
) -> dict[str, Any]:
    """Return Mitsuba's sensor of a UsdGeom.Camera for a picture of (width, height) pixels.

    The aperture grows to the picture's shape, never shrinks: usdview's and Storm's
    `expandAperture`. With ha, va its width and height and f the focal length, the field of view
    is 2 atan(ha / 2f) and the principal point lies at (ox / ha, −oy / va).
    """
    camera, time = UsdGeom.Camera(prim), placing.time
    world = _rigid(placing.world(prim)) @ rotation("Y", 180)
    across, up = _aperture(camera, time)
    shape = size[0] / size[1]
    if shape > across / up:
        across = up * shape
    else:
        up = across / shape
    near, far = _clipping(camera, time, extent, placing.scale)
    description: dict[str, Any] = {
        "to_world": to_mitsuba(world),
        "near_clip": near,
        "far_clip": far,
    }
    if camera.GetClippingPlanesAttr().Get(time):
        losses.dropped(prim, "additional clipping planes")
    if (camera.GetExposureAttr().Get(time) or 0.0) != 0.0:
        losses.dropped(prim, "exposure: the picture holds radiance as it is")
    if camera.GetProjectionAttr().Get(time) == UsdGeom.Tokens.orthographic:
        return _orthographic(camera, description, across / 10, world, placing, losses)

    focal = camera.GetFocalLengthAttr().Get(time)
    if not focal > 0:
        raise StageError(f"{prim.GetPath()}: focalLength is {focal:g}, expected more than 0")
    description |= {
        "type": "perspective",
        "fov": math.degrees(2 * math.atan(across / (2 * focal))),
        "fov_axis": "x",
        "principal_point_offset_x": camera.GetHorizontalApertureOffsetAttr().Get(time) / across,
        "principal_point_offset_y": -camera.GetVerticalApertureOffsetAttr().Get(time) / up,
    }
    f_stop = camera.GetFStopAttr().Get(time) or 0.0
    focus = camera.GetFocusDistanceAttr().Get(time) or 0.0
    if f_stop > 0 and focus > 0:
        _open_lens(prim, description, focal / 10 / (2 * f_stop), focus, placing, losses)
    return description


def framing_sensor(
    bounds: tuple[Doubles, Doubles] | None, up_axis: str, size: tuple[int, int], scale: float
) -> dict[str, Any]:
    """Return a sensor that sees all of `bounds` (stage units) from the front, a little above."""
    low, high = bounds if bounds is not None else (np.full(3, -1.0), np.full(3, 1.0))
    center = (low + high) / 2 * scale
    radius = max(float(np.linalg.norm(high - low)) / 2 * scale, 1e-6)
    z_up = up_axis == UsdGeom.Tokens.z
    toward = np.array((0.35, -1.0, 0.45) if z_up else (0.35, 0.45, 1.0))
    toward /= np.linalg.norm(toward)
    narrow = math.radians(_FRAMING_FOV) / 2
    distance = radius / math.sin(narrow)
    back, up = toward, np.array((0.0, 0.0, 1.0) if z_up else (0.0, 1.0, 0.0))
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    world = np.eye(4)
    world[:3, :3] = np.stack((right, np.cross(back, right), back), axis=1)
    world[:3, 3] = center + back * distance
    return {
        "type": "perspective",
        "fov": _FRAMING_FOV,
        "fov_axis": "smaller",
        "to_world": to_mitsuba(world @ rotation("Y", 180)),
        "near_clip": distance * _NEAREST,
        "far_clip": distance * _FARTHEST,
    }


def _orthographic(
    camera: Any, description: dict[str, Any], width: float, world: Doubles, placing: Placing,
    losses: Losses,
) -> dict[str, Any]:  # fmt: skip
    """Complete an orthographic sensor: apertures are tenths of a stage unit."""
    offsets = (
        camera.GetHorizontalApertureOffsetAttr().Get(placing.time),
        camera.GetVerticalApertureOffsetAttr().Get(placing.time),
    )
    if any(offsets):
        losses.dropped(camera.GetPrim(), "aperture offset of an orthographic camera")
    half = width / 2 * placing.scale
    description["type"] = "orthographic"
    description["to_world"] = to_mitsuba(world @ np.diag((half, half, 1.0, 1.0)))
    return description


def _open_lens(
    prim: Usd.Prim, description: dict[str, Any], radius: float, focus: float, placing: Placing,
    losses: Losses,
) -> None:  # fmt: skip
    """Turn a pinhole into a thin lens; `radius` and `focus` in stage units."""
    offsets = ("principal_point_offset_x", "principal_point_offset_y")
    if any(description[name] for name in offsets):
        losses.dropped(prim, "depth of field of a camera with an aperture offset")
        return
    for name in offsets:
        del description[name]
    description |= {
        "type": "thinlens",
        "aperture_radius": radius * placing.scale,
        "focus_distance": focus * placing.scale,
    }


def _aperture(camera: Any, time: Usd.TimeCode) -> tuple[float, float]:
    across = camera.GetHorizontalApertureAttr().Get(time)
    up = camera.GetVerticalApertureAttr().Get(time)
    if not (across > 0 and up > 0):
        path = camera.GetPrim().GetPath()
        raise StageError(f"{path}: aperture is {across:g} x {up:g}, expected more than 0")
    return float(across), float(up)


def _clipping(camera: Any, time: Usd.TimeCode, extent: float, scale: float) -> tuple[float, float]:
    """Return near and far, as authored or wide enough for a picture of `extent`."""
    attribute = camera.GetClippingRangeAttr()
    if attribute.HasAuthoredValue():
        near, far = attribute.Get(time)
        if 0 < near < far:
            return near * scale, far * scale
    return extent * _NEAREST, extent * _FARTHEST


def _rigid(world: Doubles) -> Doubles:
    """Return the matrix without its scale and shear: a camera is not stretched."""
    left, _, right = np.linalg.svd(world[:3, :3])
    rigid = np.eye(4)
    rigid[:3, :3] = left @ right
    rigid[:3, 3] = world[:3, 3]
    return rigid
