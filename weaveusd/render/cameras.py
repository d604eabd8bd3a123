"""UsdGeom cameras, and the camera of a stage that has none."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Gf, Tf, Usd, UsdGeom

from weaveusd.errors import StageError
from weaveusd.render.model import Losses
from weaveusd.render.reading import UnreadableError, number
from weaveusd.render.xforms import Placing, rotation, singular, to_mitsuba

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


def aspect_of(prim: Usd.Prim | None, time: Usd.TimeCode) -> float:
    """Return width over height of the camera's aperture; 1 without a camera."""
    if prim is None:
        return 1.0
    across, up = _aperture(UsdGeom.Camera(prim), time)
    return across / up


def film(size: tuple[int, int]) -> dict[str, Any]:
    """Return Mitsuba's film of (width, height) pixels."""
    return {
        "type": "hdrfilm",
        "width": size[0],
        "height": size[1],
        "rfilter": {"type": "box"},
        "pixel_format": "rgb",
        "component_format": "float32",
    }


def exposure(prim: Usd.Prim, time: Usd.TimeCode, losses: Losses) -> float:
    """Return what a camera multiplies radiance by.

    USD's imaging ratio: 2^exposure · exposure:time · exposure:iso / 100 · exposure:responsivity
    / exposure:fStop². 1 with a loss where it is no positive number.
    """
    try:
        scale = float(UsdGeom.Camera(prim).ComputeLinearExposureScale(time))
    except (Tf.ErrorException, RuntimeError, OverflowError):
        scale = math.nan
    if not 0 < scale < math.inf:
        losses.dropped(prim, f"exposure that multiplies radiance by {scale:g}")
        return 1.0
    return scale


def sensor(
    prim: Usd.Prim, size: tuple[int, int], extent: float, placing: Placing, losses: Losses
) -> dict[str, Any]:
    """Return Mitsuba's sensor of a UsdGeom.Camera, film and all, of (width, height) pixels.

    The aperture grows to the picture's shape, never shrinks: usdview's and Storm's
    `expandAperture`. With ha, va its width and height and f the focal length, the field of view
    is 2 atan(ha / 2f) and the principal point lies at (ox / ha, −oy / va).

    Raises
    ------
    StageError
        When the camera cannot see: no aperture, no focal length, a transform without a volume.
    """
    camera, time = UsdGeom.Camera(prim), placing.time
    placed = placing.world(prim)
    if singular(placed):
        raise StageError(f"{prim.GetPath()}: is flattened by its transform, expected a camera's")
    world = _rigid(placed) @ rotation("Y", 180)
    across, up = _aperture(camera, time)
    shape = size[0] / size[1]
    if shape > across / up:
        across = up * shape
    else:
        up = across / shape
    near, far = _clipping(camera, time, extent, placing.scale)
    shift = tuple(
        _number(attribute, time) / length
        for attribute, length in (
            (camera.GetHorizontalApertureOffsetAttr(), across),
            (camera.GetVerticalApertureOffsetAttr(), up),
        )
    )
    description: dict[str, Any] = {"near_clip": near, "far_clip": far, "film": film(size)}
    if camera.GetClippingPlanesAttr().Get(time):
        losses.dropped(prim, "additional clipping planes")
    if camera.GetProjectionAttr().Get(time) == UsdGeom.Tokens.orthographic:
        return description | _orthographic(world, across / 10, up / 10, shift, placing.scale)
    focal = _number(camera.GetFocalLengthAttr(), time)
    if not focal > 0:
        raise StageError(f"{prim.GetPath()}: focalLength is {focal:g}, expected more than 0")
    description |= {
        "to_world": to_mitsuba(world),
        "fov": math.degrees(2 * math.atan(across / (2 * focal))),
        "fov_axis": "x",
    }
    f_stop = _number(camera.GetFStopAttr(), time)
    focus = _number(camera.GetFocusDistanceAttr(), time)
    if f_stop > 0 and focus > 0:
        lens = {
            "type": "thinlens",
            "aperture_radius": focal / 10 / (2 * f_stop) * placing.scale,
            "focus_distance": focus * placing.scale,
        }
        return description | lens | _cropped(prim, size, across / focal, shift, losses)
    return description | {
        "type": "perspective",
        "principal_point_offset_x": shift[0],
        "principal_point_offset_y": -shift[1],
    }


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
    world: Doubles, across: float, up: float, shift: tuple[float, ...], scale: float
) -> dict[str, Any]:
    """Return what makes a sensor orthographic; `across` and `up` are in stage units.

    Offsets move the window, as they do in perspective.
    """
    window = np.eye(4)
    # Mitsuba's camera looks along +z with x to the left.
    window[:2, 3] = -shift[0] * across * scale, shift[1] * up * scale
    half = across / 2 * scale
    matrix = world @ window @ np.diag((half, half, 1.0, 1.0))
    return {"type": "orthographic", "to_world": to_mitsuba(matrix)}


def _cropped(
    prim: Usd.Prim, size: tuple[int, int], slope: float, shift: tuple[float, ...], losses: Losses
) -> dict[str, Any]:
    """Return field of view and film of a thin lens, which knows no principal point.

    The film is larger by twice the offset, its middle on the axis, and the picture is cut from
    its side. Whole pixels can be cut, so that the offset is met within a quarter of one.
    `slope` is the picture's width over the focal length.
    """
    if not any(shift):
        return {}
    whole = [2 * abs(s) * length for s, length in zip(shift, size, strict=True)]
    more = [round(w) for w in whole]
    if max(more) > 16 * max(size):
        raise StageError(f"{prim.GetPath()}: aperture offset is {max(whole):.4g} pixels off axis")
    if any(abs(m - w) > 0.02 for m, w in zip(more, whole, strict=True)):
        losses.approximated(prim, "aperture offset of a lens is rounded to half a pixel")
    full = [length + extra for length, extra in zip(size, more, strict=True)]
    crop = {
        "crop_width": size[0],
        "crop_height": size[1],
        "crop_offset_x": more[0] if shift[0] > 0 else 0,
        "crop_offset_y": 0 if shift[1] > 0 else more[1],
    }
    fov = math.degrees(2 * math.atan(slope / 2 * full[0] / size[0]))
    return {"fov": fov, "film": film((full[0], full[1])) | crop}


def _number(attribute: Usd.Attribute, time: Usd.TimeCode) -> float:
    try:
        return number(attribute, time, 0.0)
    except UnreadableError as reason:
        raise StageError(f"{attribute.GetPrim().GetPath()}: {reason}") from None


def _aperture(camera: Any, time: Usd.TimeCode) -> tuple[float, float]:
    across = _number(camera.GetHorizontalApertureAttr(), time)
    up = _number(camera.GetVerticalApertureAttr(), time)
    if not (across > 0 and up > 0):
        path = camera.GetPrim().GetPath()
        raise StageError(f"{path}: aperture is {across:g} x {up:g}, expected more than 0")
    return across, up


def _clipping(camera: Any, time: Usd.TimeCode, extent: float, scale: float) -> tuple[float, float]:
    """Return near and far, as authored or wide enough for a picture of `extent`."""
    attribute = camera.GetClippingRangeAttr()
    if attribute.HasAuthoredValue():
        authored = attribute.Get(time)
        near, far = authored if isinstance(authored, Gf.Vec2f) else (0.0, 0.0)
        if 0 < near < far < math.inf:
            return near * scale, far * scale
    return extent * _NEAREST, extent * _FARTHEST


def _rigid(world: Doubles) -> Doubles:
    """Return the matrix without its scale and shear: a camera is not stretched."""
    left, _, right = np.linalg.svd(world[:3, :3])
    rigid = np.eye(4)
    rigid[:3, :3] = left @ right
    rigid[:3, 3] = world[:3, 3]
    return rigid
