"""UsdGeom's solids: balls as they are, the others as triangles that keep their outlines.

A ring has 128 sides: a silhouette is at most 0.03 % of its radius too small, and normals are
exact at every vertex.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdGeom

from weaveusd.render.geometry import Balls, Facets
from weaveusd.render.model import Losses
from weaveusd.render.reading import UnreadableError, number, rows, token
from weaveusd.render.xforms import uniform_scale

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

SIDES = 128
ARCS = 32
"""Steps along a quarter of a circle in the outline of a capsule or ball."""

MAX_POINTS = 1 << 22

_FRAMES = {
    "X": np.array(((0.0, 0, 1), (1, 0, 0), (0, 1, 0))),
    "Y": np.array(((0.0, 1, 0), (0, 0, 1), (1, 0, 0))),
    "Z": np.eye(3),
}
"""Columns are where x, y and z of a solid about z go for each axis: cyclic, so none mirrors."""

_SQUARE = np.array(((-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)))
_SQUARE_UV = _SQUARE[:, :2] + 0.5
_HALVES = np.array(((0, 1, 2), (0, 2, 3)))


def solid(prim: Usd.Prim, time: Usd.TimeCode) -> Balls | Facets:
    """Return a Sphere, Cube, Plane, Cylinder, Cone or Capsule in its own space.

    Raises
    ------
    UnreadableError
        When it is another shape, or has no extent.
    """
    if prim.IsA(UsdGeom.Sphere):
        radius = _extent(UsdGeom.Sphere(prim).GetRadiusAttr(), time)
        return Balls(np.zeros((1, 3)), np.array([radius]))
    if prim.IsA(UsdGeom.Cube):
        return _cube(_extent(UsdGeom.Cube(prim).GetSizeAttr(), time))
    if prim.IsA(UsdGeom.Plane):
        plane = UsdGeom.Plane(prim)
        width = _extent(plane.GetWidthAttr(), time)
        length = _extent(plane.GetLengthAttr(), time)
        return _plane(width, length, token(plane.GetAxisAttr(), time, "Z"))
    outline = _outline(prim, time)
    if outline is None:
        raise UnreadableError(f"{prim.GetTypeName()} is not supported")
    frame = _FRAMES.get(token(prim.GetAttribute("axis"), time, "Z"))
    if frame is None:
        raise UnreadableError("axis is none of X, Y and Z")
    return _revolved(outline, frame)


def ball_as_facets(radius: float = 1.0) -> Facets:
    """Return a sphere about the origin as triangles, for what must be a mesh."""
    return _revolved(_arc(radius, 0.0, -math.pi / 2, math.pi / 2), np.eye(3))


def surface_area(shape: Balls | Facets, matrix: Doubles) -> float:
    """Return the area of a shape under a (4, 4) matrix."""
    scale = uniform_scale(matrix)
    if isinstance(shape, Balls) and scale is not None:
        return float(4 * math.pi * np.sum((shape.radii * scale) ** 2))
    if isinstance(shape, Balls):
        return sum(surface_area(ball_as_facets(float(r)), matrix) for r in shape.radii)
    points = shape.points @ matrix[:3, :3].T
    a, b, c = np.moveaxis(points[shape.triangles], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def points_as_balls(prim: Usd.Prim, time: Usd.TimeCode, losses: Losses) -> Balls:
    """Return UsdGeom.Points as spheres whose diameters are the widths.

    Raises
    ------
    UnreadableError
        When there are no points, or widths that do not fit them.
    """
    cloud = UsdGeom.Points(prim)
    centers = rows(cloud.GetPointsAttr(), time, 3)
    if not len(centers):
        raise UnreadableError("has no points")
    if len(centers) > MAX_POINTS:
        raise UnreadableError(f"has {len(centers)} points, expected at most {MAX_POINTS}")
    widths = rows(cloud.GetWidthsAttr(), time, 1)[:, 0]
    if widths.size == 1:
        widths = np.repeat(widths, len(centers))
    if not widths.size:
        losses.approximated(prim, "has no widths: 1 is used")
        widths = np.ones(len(centers))
    if widths.size != len(centers):
        raise UnreadableError(f"has {widths.size} widths, expected {len(centers)}")
    wide = widths > 0
    if not wide.all():
        losses.dropped(prim, "points without a width")
    if not wide.any():
        raise UnreadableError("has no point of any width")
    return Balls(centers[wide], widths[wide] / 2)


def _cube(size: float) -> Facets:
    """Return a cube about the origin, each face with its own texture coordinates 0…1."""
    points, normals = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            normal = np.zeros(3)
            normal[axis] = side
            across = np.roll(normal, 1) * side
            up = np.cross(normal, across)
            face = _SQUARE[:, :1] * across + _SQUARE[:, 1:2] * up + normal / 2
            points.append(face * size)
            normals.append(np.tile(normal, (4, 1)))
    triangles = _HALVES[None] + 4 * np.arange(6)[:, None, None]
    return Facets(
        np.concatenate(points), triangles.reshape(-1, 3), np.concatenate(normals),
        np.tile(_SQUARE_UV, (6, 1)),
    )  # fmt: skip


def _plane(width: float, length: float, axis: str) -> Facets:
    """Return a rectangle: its width along x, or z for axis X; its length along y, or z for Y."""
    axes = {
        "X": ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
        "Y": ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0)),
        "Z": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
    }
    if axis not in axes:
        raise UnreadableError(f"axis {axis} is none of X, Y and Z")
    across, up = np.array(axes[axis])
    points = _SQUARE[:, :1] * across * width + _SQUARE[:, 1:2] * up * length
    return Facets(points, _HALVES, None, _SQUARE_UV)


def _outline(prim: Usd.Prim, time: Usd.TimeCode) -> Doubles | None:
    """Return the outline of a solid of revolution: rows of radius, height and normal (r, z).

    It runs from the bottom up; where it is sharp, a point stands twice with both normals. Cones
    and cylinders are closed.
    """
    kind = prim.GetTypeName()
    if kind not in ("Cone", "Cylinder", "Cylinder_1", "Capsule", "Capsule_1"):
        return None
    height = _extent(prim.GetAttribute("height"), time)
    if kind.endswith("_1"):
        bottom = number(prim.GetAttribute("radiusBottom"), time, 0.0)
        top = number(prim.GetAttribute("radiusTop"), time, 0.0)
    else:
        bottom = number(prim.GetAttribute("radius"), time, 0.0)
        top = 0.0 if kind == "Cone" else bottom
    if min(bottom, top) < 0 or max(bottom, top) == 0:
        raise UnreadableError("has no extent")
    low, high = -height / 2, height / 2
    slope = np.array((height, bottom - top)) / math.hypot(height, bottom - top)
    wall = np.array(((bottom, low, *slope), (top, high, *slope)))
    if kind.startswith("Capsule"):
        return np.concatenate(
            (_arc(bottom, low, -math.pi / 2, 0.0), wall, _arc(top, high, 0.0, math.pi / 2))
        )
    floor = ((0.0, low, 0.0, -1.0), (bottom, low, 0.0, -1.0))
    lid = ((top, high, 0.0, 1.0), (0.0, high, 0.0, 1.0)) if top > 0 else ()
    return np.array((*floor, *wall, *lid))


def _arc(radius: float, height: float, start: float, end: float) -> Doubles:
    """Return the outline of a part of a circle about (0, height), angles from the equator."""
    steps = max(1, round(2 * ARCS * (end - start) / math.pi))
    angle = np.linspace(start, end, steps + 1)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack((radius * np.maximum(c, 0), height + radius * s, c, s), axis=1)


def _revolved(outline: Doubles, frame: Doubles) -> Facets:
    """Return the surface that an outline sweeps about z, turned into `frame`.

    u runs around, v along the outline.
    """
    turn = 2 * math.pi * np.arange(SIDES + 1) / SIDES
    c, s = np.cos(turn), np.sin(turn)
    c[-1], s[-1] = c[0], s[0]
    radius, height, across, up = (column[:, None] for column in outline.T)
    points = np.stack(np.broadcast_arrays(radius * c, radius * s, height), axis=-1)
    normals = np.stack(np.broadcast_arrays(across * c, across * s, up), axis=-1)
    along = np.linspace(0, 1, len(outline))[:, None]
    uv = np.stack(np.broadcast_arrays(turn / turn[-1], along), axis=-1)
    k, j = np.meshgrid(np.arange(len(outline) - 1), np.arange(SIDES), indexing="ij")
    a = k * (SIDES + 1) + j
    b, d = a + 1, a + SIDES + 1
    triangles = np.stack((a, b, d + 1, a, d + 1, d), axis=-1).reshape(-1, 3)
    placed = points.reshape(-1, 3)
    p, q, r = (placed[triangles[:, n]] for n in range(3))
    real = np.linalg.norm(np.cross(q - p, r - p), axis=1) > 0
    return Facets(
        placed @ frame.T, triangles[real], normals.reshape(-1, 3) @ frame.T, uv.reshape(-1, 2)
    )


def _extent(attribute: Usd.Attribute, time: Usd.TimeCode) -> float:
    value = number(attribute, time, 0.0)
    if not value > 0:
        raise UnreadableError(f"{attribute.GetName()} is {value:g}, expected more than 0")
    return value
