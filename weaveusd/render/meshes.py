"""UsdGeom meshes as triangles in their own space, values of theirs at every corner."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from weaveusd.render import polygons, subdivided
from weaveusd.render.model import Losses
from weaveusd.render.polygons import Triangles, per_corner
from weaveusd.render.reading import UnreadableError, as_rows, authored, integers, rows, token

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

MAX_CORNERS = 1 << 26


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A mesh of the stage in its own space, triangulated, before its vertices are split.

    `triangles` index the corners, and say of each triangle which authored face it is of. `spread`
    takes authored values (n, k) and their interpolation to the corners, (C, k); it raises
    ValueError where their number does not fit.
    """

    points: Doubles  # (P, 3)
    indices: Indices  # (C,)
    faces: int  # as authored
    triangles: Triangles
    normals: Doubles | None  # (C, 3)
    spread: Callable[[Doubles, str], Doubles]


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """The faces of a mesh that share a material, and the prim that binds it."""

    prim: Usd.Prim
    triangles: Triangles


def read_surface(prim: Usd.Prim, time: Usd.TimeCode, losses: Losses) -> Surface:
    """Return the mesh `prim`; faces listed as holes are left out.

    Raises
    ------
    UnreadableError
        When there is nothing that could be shown.
    """
    mesh = UsdGeom.Mesh(prim)
    points = rows(mesh.GetPointsAttr(), time, 3)
    counts = integers(mesh.GetFaceVertexCountsAttr(), time)
    indices = integers(mesh.GetFaceVertexIndicesAttr(), time)
    _check(points, counts, indices)
    reverse = token(mesh.GetOrientationAttr(), time, "") == UsdGeom.Tokens.leftHanded
    hidden = np.isin(np.arange(counts.size), integers(mesh.GetHoleIndicesAttr(), time))
    surface = None
    if token(mesh.GetSubdivisionSchemeAttr(), time, "catmullClark") != UsdGeom.Tokens.none:
        surface = _refined(mesh, points, counts, indices, hidden, reverse, time, losses)
    if surface is None:
        triangles = polygons.triangulate(counts, points, indices, reverse)

        def spread(values: Doubles, interpolation: str) -> Doubles:
            how = "vertex" if interpolation == "varying" else interpolation
            return per_corner(values, how, counts, indices)  # type: ignore[arg-type]

        normals = _normals(mesh, spread, time, losses)
        surface = Surface(points, indices, counts.size, triangles, normals, spread)
    kept = _keep(surface.triangles, ~hidden[surface.triangles.face])
    if not kept.face.size:
        raise UnreadableError("has no face")
    return Surface(
        surface.points, surface.indices, surface.faces, kept, surface.normals, surface.spread
    )


def parts(prim: Usd.Prim, surface: Surface, time: Usd.TimeCode, losses: Losses) -> Iterator[Part]:
    """Yield the faces of each GeomSubset that binds a material, then those of none."""
    free = np.ones(surface.faces, bool)
    for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
        mine = _subset_faces(subset, free.size, time, losses)
        if mine is None:
            continue
        if (mine & ~free).any():
            losses.approximated(subset.GetPrim(), "shares faces with an earlier subset")
        mine &= free
        free &= ~mine
        triangles = _keep(surface.triangles, mine[surface.triangles.face])
        if triangles.face.size:
            yield Part(subset.GetPrim(), triangles)
    rest = _keep(surface.triangles, free[surface.triangles.face])
    if rest.face.size:
        yield Part(prim, rest)


def corner_primvar(
    prim: Usd.Prim, name: str, width: int, surface: Surface, time: Usd.TimeCode, losses: Losses
) -> Doubles | None:
    """Return a primvar of the mesh, indexed or inherited, (C, width); None without one."""
    primvar = find_primvar(prim, name)
    if not primvar:
        return None
    try:
        values = as_rows(primvar.ComputeFlattened(time), width, f"primvar {name}")
        return surface.spread(values, str(primvar.GetInterpolation()))
    except UnreadableError as reason:
        losses.dropped(prim, str(reason))
    except ValueError as reason:
        losses.dropped(prim, f"primvar {name}: {reason}")
    return None


def surface_area(surface: Surface, matrix: Doubles) -> float:
    """Return the area of all triangles under a (4, 4) matrix."""
    points = surface.points @ matrix[:3, :3].T
    a, b, c = np.moveaxis(points[surface.indices[surface.triangles.corners]], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def _refined(
    mesh: UsdGeom.Mesh, points: Doubles, counts: Indices, indices: Indices,
    hidden: NDArray[np.bool_], reverse: bool, time: Usd.TimeCode, losses: Losses,
) -> Surface | None:  # fmt: skip
    """Return a subdivision surface on its limit; None, with a loss, where it stays a cage."""
    prim = mesh.GetPrim()
    try:
        cage = subdivided.read_cage(mesh, len(points), counts, indices, time, losses)
    except UnreadableError as reason:
        losses.approximated(prim, f"is shown as its control cage: {reason}")
        return None
    limit, triangles = cage.carry_vertices(points), cage.triangles()
    hidden |= cage.hidden
    return Surface(
        limit, cage.corners(), counts.size,
        Triangles(triangles[:, ::-1] if reverse else triangles, cage.face_of_triangles()),
        cage.normals(limit, reverse), cage.spread,
    )  # fmt: skip


def _subset_faces(
    subset: UsdGeom.Subset, faces: int, time: Usd.TimeCode, losses: Losses
) -> NDArray[np.bool_] | None:
    """Return the faces that a subset lists, (faces,); None where it lists none of them."""
    prim = subset.GetPrim()
    if token(subset.GetElementTypeAttr(), time, "face") != UsdGeom.Tokens.face:
        losses.dropped(prim, "material subset is not made of faces")
        return None
    try:
        listed = integers(subset.GetIndicesAttr(), time)
    except UnreadableError as reason:
        losses.dropped(prim, str(reason))
        return None
    inside = listed[(listed >= 0) & (listed < faces)]
    if inside.size != listed.size:
        losses.dropped(prim, "some indices name no face of the mesh")
    mine = np.zeros(faces, bool)
    mine[inside] = True
    return mine


def _check(points: Doubles, counts: Indices, indices: Indices) -> None:
    """Raise UnreadableError unless the counts, the indices and the points fit together."""
    if not len(points) or not counts.size:
        raise UnreadableError("has no points or no faces")
    if counts.min() < 0 or int(counts.sum()) != indices.size:
        asked = "a negative number" if counts.min() < 0 else str(int(counts.sum()))
        raise UnreadableError(f"has {indices.size} face vertices, but its counts ask for {asked}")
    if indices.size > MAX_CORNERS:
        raise UnreadableError(f"has {indices.size} face vertices, expected at most {MAX_CORNERS}")
    if indices.size and (indices.min() < 0 or indices.max() >= len(points)):
        raise UnreadableError(f"names a point outside its {len(points)} points")


def _normals(
    mesh: UsdGeom.Mesh, spread: Callable[[Doubles, str], Doubles], time: Usd.TimeCode,
    losses: Losses,
) -> Doubles | None:  # fmt: skip
    """Return the authored unit normals at the corners, `primvars:normals` first."""
    prim = mesh.GetPrim()
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar(UsdGeom.Tokens.normals)
    try:
        if primvar and primvar.HasValue():
            value, how = primvar.ComputeFlattened(time), primvar.GetInterpolation()
        else:
            value, how = authored(mesh.GetNormalsAttr(), time), mesh.GetNormalsInterpolation()
        values = as_rows(value, 3, "normals")
        corner = spread(values, str(how)) if len(values) else None
    except UnreadableError as reason:
        losses.dropped(prim, str(reason))
        return None
    except ValueError as reason:
        losses.dropped(prim, f"normals: {reason}")
        return None
    if corner is None:
        return None
    length = np.linalg.norm(corner, axis=1, keepdims=True)
    if length.min() <= 0:
        losses.dropped(prim, "normals hold a vector of no direction")
        return None
    return np.asarray(corner / length)


def find_primvar(prim: Usd.Prim, name: str) -> UsdGeom.Primvar | None:
    """Return a primvar of the prim, or one that it inherits; None without a value."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    return primvar if primvar and primvar.HasValue() else None


def _keep(triangles: Triangles, kept: NDArray[np.bool_]) -> Triangles:
    return Triangles(triangles.corners[kept], triangles.face[kept])
