"""UsdGeom meshes as Mitsuba meshes, in the space of the picture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from weaveusd.render import polygons
from weaveusd.render.model import Losses
from weaveusd.render.polygons import Triangles, per_corner
from weaveusd.render.xforms import mirrors

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

MAX_CORNERS = 1 << 28


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A mesh of the stage in the space of the picture, triangulated, before it is split."""

    points: Doubles  # (P, 3)
    counts: Indices  # (F,)
    indices: Indices  # (corners,)
    triangles: Triangles
    normals: Doubles | None  # (corners, 3)
    mirrored: bool


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """The faces of a mesh that share a material, and the prim that binds it."""

    prim: Usd.Prim
    triangles: Triangles


def read_surface(
    prim: Usd.Prim, world: Doubles, time: Usd.TimeCode, losses: Losses
) -> Surface | None:
    """Return the mesh `prim` placed by `world`, or None where there is nothing to show.

    Faces listed as holes are left out. A subdivision surface becomes its control cage with
    smooth normals, and a loss says so.
    """
    mesh = UsdGeom.Mesh(prim)
    points = _array(mesh.GetPointsAttr().Get(time), 3)
    counts = _array(mesh.GetFaceVertexCountsAttr().Get(time), 1, np.int64)
    indices = _array(mesh.GetFaceVertexIndicesAttr().Get(time), 1, np.int64)
    fault = _fault(points, counts, indices)
    if fault:
        losses.dropped(prim, f"mesh {fault}")
        return None
    placed = points @ world[:3, :3].T + world[:3, 3]
    scheme = mesh.GetSubdivisionSchemeAttr().Get(time)
    left_handed = mesh.GetOrientationAttr().Get(time) == UsdGeom.Tokens.leftHanded
    reverse = left_handed != mirrors(world)
    triangles = polygons.triangulate(counts, placed, indices, reverse)
    holes = _array(mesh.GetHoleIndicesAttr().Get(time), 1, np.int64)
    triangles = _keep(triangles, ~np.isin(triangles.face, holes))
    if not triangles.face.size:
        losses.dropped(prim, "mesh has no face")
        return None
    if scheme != UsdGeom.Tokens.none:
        losses.approximated(prim, f"{scheme} subdivision is shown as its control cage")
        smooth = polygons.smooth_normals(placed, triangles, indices)
        normals: Doubles | None = smooth[indices]
    else:
        normals = _normals(mesh, counts, indices, world, time, losses)
    return Surface(placed, counts, indices, triangles, normals, mirrors(world))


def surface_area(surface: Surface) -> float:
    """Return the area of all triangles, in the space of the picture."""
    a, b, c = np.moveaxis(surface.points[surface.indices[surface.triangles.corners]], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def parts(prim: Usd.Prim, surface: Surface, time: Usd.TimeCode, losses: Losses) -> Iterator[Part]:
    """Yield the faces of each GeomSubset that binds a material, then those of none."""
    free = np.ones(surface.counts.size, bool)
    for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
        if subset.GetElementTypeAttr().Get(time) != UsdGeom.Tokens.face:
            losses.dropped(subset.GetPrim(), "material subset is not made of faces")
            continue
        listed = _array(subset.GetIndicesAttr().Get(time), 1, np.int64)
        inside = listed[(listed >= 0) & (listed < free.size)]
        if inside.size != listed.size:
            losses.dropped(subset.GetPrim(), "some indices name no face of the mesh")
        mine = np.zeros(free.size, bool)
        mine[inside] = True
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
    """Return a primvar of the mesh, indexed or inherited, one row a corner; None without one."""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
    if not primvar or not primvar.HasValue():
        return None
    values = _array(primvar.ComputeFlattened(time), width)
    if not np.isfinite(values).all():
        losses.dropped(prim, f"primvar {name} holds a value that is no finite number")
        return None
    return _spread(
        prim, f"primvar {name}", values, primvar.GetInterpolation(), surface.counts,
        surface.indices, losses,
    )  # fmt: skip


def to_mesh(
    surface: Surface,
    part: Part,
    uv: Doubles | None,
    color: Doubles | None,
    properties: Any,
) -> Any:
    """Return Mitsuba's mesh of one part; `properties` carry its BSDF and emitter."""
    values = {
        name: value
        for name, value in (("uv", uv), ("normal", surface.normals), ("color", color))
        if value is not None
    }
    mesh = polygons.split(part.triangles, surface.indices, values)
    shape = mi.Mesh(
        str(part.prim.GetPath()),
        len(mesh.source),
        len(mesh.triangles),
        props=properties,
        has_vertex_normals=surface.normals is not None,
        has_vertex_texcoords=uv is not None,
    )
    if color is not None:
        shape.add_attribute("vertex_color", 3, color[mesh.source].ravel().astype(np.float32))
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = _flat(surface.points[surface.indices[mesh.source]])
    parameters["faces"] = np.ascontiguousarray(mesh.triangles, np.uint32).ravel()
    if surface.normals is not None:
        parameters["vertex_normals"] = _flat(surface.normals[mesh.source])
    if uv is not None:
        parameters["vertex_texcoords"] = _flat(uv[mesh.source])
    parameters.update()
    return shape


def _flat(values: Doubles) -> NDArray[np.float32]:
    return np.ascontiguousarray(values, np.float32).ravel()


def _keep(triangles: Triangles, kept: NDArray[np.bool_]) -> Triangles:
    return Triangles(triangles.corners[kept], triangles.face[kept])


def _array(value: Any, width: int, dtype: Any = np.float64) -> NDArray[Any]:
    """Return a USD array as NumPy, (n,) for width 1 and else (n, width); empty for None."""
    array = np.asarray(() if value is None else value, dtype)
    if width == 1:
        return array.reshape(-1)
    return array.reshape(-1, width) if array.size % width == 0 else np.zeros((0, width), dtype)


def _fault(points: Doubles, counts: Indices, indices: Indices) -> str | None:
    """Return what is wrong with a mesh's topology, or None."""
    if not len(points) or not counts.size:
        return "has no points or no faces"
    if counts.min() < 0 or int(counts.sum()) != indices.size:
        return f"has {indices.size} face vertices, but its counts ask for {int(counts.sum())}"
    if indices.size > MAX_CORNERS:
        return f"has {indices.size} face vertices, expected at most {MAX_CORNERS}"
    if indices.size and (indices.min() < 0 or indices.max() >= len(points)):
        return f"names a point outside its {len(points)} points"
    if not np.isfinite(points).all():
        return "has a point that is no finite number"
    return None


def _normals(
    mesh: Any, counts: Indices, indices: Indices, world: Doubles, time: Usd.TimeCode,
    losses: Losses,
) -> Doubles | None:  # fmt: skip
    """Return the authored normals in the space of the picture, `primvars:normals` first."""
    prim = mesh.GetPrim()
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar(UsdGeom.Tokens.normals)
    if primvar and primvar.HasValue():
        values, how = primvar.ComputeFlattened(time), primvar.GetInterpolation()
    else:
        values, how = mesh.GetNormalsAttr().Get(time), mesh.GetNormalsInterpolation()
    if not values:
        return None
    corner = _spread(prim, "normals", _array(values, 3), how, counts, indices, losses)
    if corner is None:
        return None
    turned = corner @ np.linalg.inv(world[:3, :3])
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    if not np.isfinite(turned).all() or length.min() <= 0:
        losses.dropped(prim, "normals hold a vector of no direction")
        return None
    return np.asarray(turned / length)


def _spread(
    prim: Usd.Prim, what: str, values: Doubles, how: str, counts: Indices, indices: Indices,
    losses: Losses,
) -> Doubles | None:  # fmt: skip
    interpolation = "vertex" if how == UsdGeom.Tokens.varying else how
    try:
        return per_corner(values, interpolation, counts, indices)  # type: ignore[arg-type]
    except (ValueError, KeyError) as error:
        losses.dropped(prim, f"{what}: {error}")
        return None
