"""Shapes and their copies as the entries of a Mitsuba scene.

Copies are written out and shapes of one look become one mesh: Mitsuba compiles code for each
instance, so that a thousand take half a minute before the first pixel, and a mesh a moment
whatever its size. Only where triangles would pass `MAX_PRIMITIVES` do copies become instances.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np

from weaveusd.render.geometry import Balls, Facets, Placed, Shape, Strands
from weaveusd.render.lights.emitters import of_ball
from weaveusd.render.model import Losses
from weaveusd.render.quaternions import quaternions
from weaveusd.render.shapes import ball_as_facets
from weaveusd.render.xforms import mirrors, to_mitsuba

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

MAX_PRIMITIVES = 1 << 24
"""Triangles, tubes and balls of copies that are written out."""

MAX_INSTANCES = 128
"""Instances of heavy shapes; compiling them takes two seconds for 100, six for 200."""

_FEW_BALLS = 32
"""Balls that are shapes of their own; more of them are one shape of ellipsoids."""

_SHINING_BALLS = 512
"""Balls that shine, beyond the few that are shapes of their own."""

Dress = Callable[[Placed], tuple[Any, dict[str, Any] | None]]
"""Gives the loaded BSDF of a placed shape, and its emitter or None."""


@dataclass(frozen=True, slots=True, eq=False)
class _Group:
    """Shapes that share a look and the same set of values at their vertices."""

    placed: list[Placed]
    bsdf: Any
    emitter: dict[str, Any] | None


def assemble(found: Sequence[Placed], scale: float, dress: Dress, losses: Losses) -> list[Any]:
    """Return the entries of all shapes, in the order of the stage, `scale` picture units a unit."""
    flat, heavy = _divide(found, losses)
    entries: list[Any] = []
    for group in _groups(flat, dress):
        kind = type(group.placed[0].shape)
        entries += _BUILDERS[kind](group, scale, losses)
    for placed in heavy:
        bsdf, _ = dress(placed)
        entries += _instances(placed, bsdf, scale)
    return entries


def _divide(found: Sequence[Placed], losses: Losses) -> tuple[list[Placed], list[Placed]]:
    """Return what is written out and what is instanced; copies that neither holds are a loss.

    The first copy of a shape is in memory as it is: only those after it are counted.
    """
    flat = {id(placed): placed for placed in found}
    heavy: list[Placed] = []
    more, instances = sum(placed.repeated() for placed in found), 0
    for placed in sorted(found, key=Placed.repeated, reverse=True):
        if more <= MAX_PRIMITIVES:
            break
        copies, weight = len(placed.matrices), placed.shape.weight()
        others = more - placed.repeated()
        sharable = isinstance(placed.shape, Facets) and placed.look.emission is None
        if sharable and instances + copies <= MAX_INSTANCES:
            more, instances = others, instances + copies
            heavy.append(flat.pop(id(placed)))
            continue
        room = 1 + max(MAX_PRIMITIVES - others, 0) // weight
        flat[id(placed)] = replace(placed, matrices=placed.matrices[:room])
        more = others + (room - 1) * weight
        losses.dropped(placed.prim, f"{copies - room} of {copies} copies of {weight} primitives")
    return list(flat.values()), heavy


def _groups(found: Sequence[Placed], dress: Dress) -> Iterator[_Group]:
    """Yield the shapes that one entry can hold, in the order of their first ones."""
    groups: dict[tuple[Any, ...], _Group] = {}
    for placed in found:
        shape = placed.shape
        key: tuple[Any, ...] = (type(shape), id(placed.look), placed.both_sides)
        if isinstance(shape, Facets):
            key += (shape.normals is None, shape.uv is None, *sorted(shape.attributes))
        elif isinstance(shape, Strands):
            key += (shape.cubic,)
        if key not in groups:
            groups[key] = _Group([], *dress(placed))
        groups[key].placed.append(placed)
    yield from groups.values()


def _mesh_entries(group: _Group, scale: float, losses: Losses) -> list[Any]:
    return [mesh(_merged(group.placed, scale), group.placed[0].prim, group.bsdf, group.emitter)]


def mesh(facets: Facets, name: str, bsdf: Any, emitter: dict[str, Any] | None) -> Any:
    """Return Mitsuba's mesh; `facets` are in the space of the picture."""
    properties = mi.Properties()
    properties["mesh_bsdf"] = bsdf
    if emitter is not None:
        properties["mesh_emitter"] = mi.load_dict(emitter, parallel=False)
    shape = mi.Mesh(
        name,
        len(facets.points),
        len(facets.triangles),
        props=properties,
        has_vertex_normals=facets.normals is not None,
        has_vertex_texcoords=facets.uv is not None,
    )
    for attribute, values in facets.attributes.items():
        shape.add_attribute(attribute, values.shape[1], _flat(values))
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = _flat(facets.points)
    parameters["faces"] = np.ascontiguousarray(facets.triangles, np.uint32).ravel()
    if facets.normals is not None:
        parameters["vertex_normals"] = _flat(facets.normals)
    if facets.uv is not None:
        parameters["vertex_texcoords"] = _flat(facets.uv)
    parameters.update()
    return shape


def _merged(found: Sequence[Placed], scale: float) -> Facets:
    """Return all copies of the shapes as one, in the space of the picture."""
    every = [_copies(placed.shape, placed.matrices) for placed in found]
    offsets = np.cumsum([0] + [len(facets.points) for facets in every])
    triangles = [facets.triangles + offset for facets, offset in zip(every, offsets, strict=False)]
    return Facets(
        np.concatenate([facets.points for facets in every]) * scale,
        np.concatenate(triangles),
        _joined([facets.normals for facets in every]),
        _joined([facets.uv for facets in every]),
        {
            name: np.concatenate([facets.attributes[name] for facets in every])
            for name in every[0].attributes
        },
    )


def _copies(facets: Shape, matrices: Doubles) -> Facets:
    """Return the copies of a shape under matrices (N, 4, 4) as one shape."""
    assert isinstance(facets, Facets)
    linear, count = matrices[:, :3, :3], len(matrices)
    points = facets.points @ np.swapaxes(linear, 1, 2) + matrices[:, None, :3, 3]
    mirrored = (np.linalg.det(linear) < 0)[:, None, None]
    triangles = np.where(mirrored, facets.triangles[:, ::-1], facets.triangles)
    offsets = len(facets.points) * np.arange(count)[:, None, None]
    normals = None
    if facets.normals is not None:
        turned = (facets.normals @ np.linalg.inv(linear)).reshape(-1, 3)
        normals = turned / np.linalg.norm(turned, axis=1, keepdims=True)
    return Facets(
        points.reshape(-1, 3),
        (triangles + offsets).reshape(-1, 3),
        normals,
        None if facets.uv is None else np.tile(facets.uv, (count, 1)),
        {name: np.tile(values, (count, 1)) for name, values in facets.attributes.items()},
    )


def _instances(placed: Placed, bsdf: Any, scale: float) -> list[Any]:
    """Return one group of the shape and an instance of it for each copy."""
    assert isinstance(placed.shape, Facets)
    group = mi.load_dict(
        {"type": "shapegroup", "shape": mesh(placed.shape, placed.prim, bsdf, None)},
        parallel=False,
    )
    zoom = np.diag((scale, scale, scale, 1.0))
    copies = [
        {"type": "instance", "to_world": to_mitsuba(zoom @ matrix), "group": group}
        for matrix in placed.matrices
    ]
    return [group, *copies]


def _joined(values: list[Doubles | None]) -> Doubles | None:
    given = [v for v in values if v is not None]
    return np.concatenate(given) if given else None


def _tube_entries(group: _Group, scale: float, losses: Losses) -> list[Any]:
    """Return all tubes as one shape; radii grow by the mean scale of their matrix."""
    controls, cubic = [], True
    for placed in group.placed:
        shape = placed.shape
        assert isinstance(shape, Strands)
        cubic = shape.cubic
        if not _keep_angles(placed.matrices):
            losses.approximated(placed.prim, "widths grow by the mean scale of its transform")
        each = shape.controls[shape.segments[:, None] + np.arange(4 if cubic else 2)]
        for matrix in placed.matrices:
            thick = abs(float(np.linalg.det(matrix[:3, :3]))) ** (1 / 3)
            centers = each[..., :3] @ matrix[:3, :3].T + matrix[:3, 3]
            controls.append(np.concatenate((centers, each[..., 3:] * thick), axis=2) * scale)
    every = np.concatenate(controls)
    entry = _load_curves(cubic, len(every), group.bsdf)
    parameters = mi.traverse(entry)
    parameters["control_points"] = _flat(every)
    parameters.update()
    return [entry]


def _load_curves(cubic: bool, segments: int, bsdf: Any) -> Any:
    """Return a shape of so many segments to be filled: Mitsuba takes curves from files only."""
    kind, taps = ("bsplinecurve", 4) if cubic else ("linearcurve", 2)
    with tempfile.TemporaryDirectory(prefix="weaveusd-") as folder:
        file = Path(folder) / "curves.txt"
        file.write_text(("0 0 0 1\n" * taps + "\n") * segments, encoding="ascii")
        return mi.load_dict({"type": kind, "filename": str(file), "bsdf": bsdf}, parallel=False)


def _ball_entries(group: _Group, scale: float, losses: Losses) -> list[Any]:
    """Return few round balls as spheres, and others as one shape of ellipsoids.

    Ellipsoids cannot shine: those that do are triangles, as far as memory allows.
    """
    centers, axes = [], []
    for placed in group.placed:
        shape = placed.shape
        assert isinstance(shape, Balls)
        linear, shift = placed.matrices[:, :3, :3], placed.matrices[:, None, :3, 3]
        centers.append((shape.centers @ np.swapaxes(linear, 1, 2) + shift).reshape(-1, 3))
        stretched = linear[:, None] * shape.radii[:, None, None]
        axes.append(stretched.reshape(-1, 3, 3))
    center, axis = scale * np.concatenate(centers), scale * np.concatenate(axes)
    first = group.placed[0]
    if len(center) <= _FEW_BALLS and _keep_angles(axis):
        return [_sphere(_affine(a, c), group) for a, c in zip(axis, center, strict=True)]
    if group.emitter is not None and len(center) <= _SHINING_BALLS:
        placing = np.array([_affine(a, c) for a, c in zip(axis, center, strict=True)])
        unit = replace(first, shape=ball_as_facets(), matrices=placing)
        return [mesh(_merged([unit], 1.0), first.prim, group.bsdf, group.emitter)]
    if group.emitter is not None:
        losses.dropped(first.prim, f"light of more than {_SHINING_BALLS} balls")
    turn, size, _ = np.linalg.svd(axis)
    turn[:, :, 2] *= np.linalg.det(turn)[:, None]
    tensors = {"centers": center, "scales": size, "quaternions": quaternions(turn)}
    entry = {name: mi.TensorXf(values.astype(np.float32)) for name, values in tensors.items()}
    return [entry | {"type": "ellipsoids", "extent": 1.0, "bsdf": group.bsdf}]


def _sphere(matrix: Doubles, group: _Group) -> Any:
    if mirrors(matrix):
        matrix = matrix @ np.diag((-1.0, -1.0, -1.0, 1.0))
    entry = {"type": "sphere", "to_world": to_mitsuba(matrix), "bsdf": group.bsdf}
    return entry if group.emitter is None else entry | {"emitter": of_ball(group.emitter, matrix)}


def _keep_angles(matrices: Doubles) -> bool:
    """Return whether all matrices (N, 3, 3) or (N, 4, 4) scale evenly."""
    linear = matrices[:, :3, :3]
    squares = np.swapaxes(linear, 1, 2) @ linear
    mean = np.trace(squares, axis1=1, axis2=2)[:, None, None] / 3
    return bool((np.abs(squares - mean * np.eye(3)) <= 1e-5 * mean).all())


def _affine(linear: Doubles, shift: Doubles) -> Doubles:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = linear, shift
    return matrix


def _flat(values: Doubles) -> NDArray[np.float32]:
    return np.ascontiguousarray(values, np.float32).ravel()


_BUILDERS: dict[type, Callable[[_Group, float, Losses], list[Any]]] = {
    Facets: _mesh_entries,
    Strands: _tube_entries,
    Balls: _ball_entries,
}
