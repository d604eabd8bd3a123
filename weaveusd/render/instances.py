"""UsdGeom.PointInstancer: where the copies of each prototype stand.

A copy is scaled, turned and moved, in this order, and its prototype keeps the transform of its
root: world = instancer · T · R · S · prototype, with vectors as columns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Tf, Usd, UsdGeom

from weaveusd.render.model import Losses
from weaveusd.render.quaternions import rotations
from weaveusd.render.reading import UnreadableError, as_rows, authored, integers, rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

MAX_COPIES = 1 << 20
"""Copies that one instancer makes, those of instancers inside it included."""


@dataclass(frozen=True, slots=True, eq=False)
class Copies:
    """The copies of one prototype: matrices (N, 4, 4) into the space of the instancer."""

    prototype: Usd.Prim
    matrices: Doubles
    colors: Doubles | None  # (N, 3) displayColor of each copy


def read_copies(prim: Usd.Prim, time: Usd.TimeCode, losses: Losses) -> list[Copies]:
    """Return the visible copies that an instancer makes, in the order of its prototypes.

    Velocities move nothing: between samples positions are interpolated.

    Raises
    ------
    UnreadableError
        When its arrays do not fit each other.
    """
    instancer = UsdGeom.PointInstancer(prim)
    which = integers(instancer.GetProtoIndicesAttr(), time)
    if not which.size:
        raise UnreadableError("instancer has no copies")
    if which.size > MAX_COPIES:
        raise UnreadableError(f"instancer has {which.size} copies, expected at most {MAX_COPIES}")
    matrices = _matrices(instancer, which.size, time)
    targets = instancer.GetPrototypesRel().GetForwardedTargets()
    shown = _mask(instancer, which.size, time)
    if which.min() < 0 or which.max() >= len(targets):
        losses.dropped(prim, f"copies of none of the {len(targets)} prototypes")
    flat = np.abs(np.linalg.det(matrices[:, :3, :3])) < 1e-30
    if (flat & shown).any():
        losses.dropped(prim, "copies that are flattened by their scale")
    shown &= ~flat
    _note_motion(instancer, time, losses)
    colors = _colors(prim, which.size, time, losses)
    found = []
    for number, target in enumerate(targets):
        mine = shown & (which == number)
        prototype = prim.GetStage().GetPrimAtPath(target)
        if not mine.any():
            continue
        if not prototype:
            losses.dropped(prim, f"prototype {target} does not exist")
            continue
        mine_colors = None if colors is None else colors[mine]
        found.append(Copies(prototype, matrices[mine], mine_colors))
    return found


def _matrices(instancer: UsdGeom.PointInstancer, count: int, time: Usd.TimeCode) -> Doubles:
    """Return the matrices (count, 4, 4) of all copies."""
    positions = rows(instancer.GetPositionsAttr(), time, 3)
    scales = rows(instancer.GetScalesAttr(), time, 3)
    turns = _orientations(instancer, time)
    for name, values, needed in (
        ("positions", positions, True),
        ("scales", scales, False),
        ("orientations", turns, False),
    ):
        if len(values) != count and (needed or len(values)):
            raise UnreadableError(f"instancer has {len(values)} {name}, expected {count}")
    matrices = np.tile(np.eye(4), (count, 1, 1))
    matrices[:, :3, 3] = positions
    if len(turns):
        matrices[:, :3, :3] = rotations(turns)
    if len(scales):
        matrices[:, :3, :3] *= scales[:, None, :]
    return matrices


def _orientations(instancer: UsdGeom.PointInstancer, time: Usd.TimeCode) -> Doubles:
    """Return quaternions (N, 4) as x, y, z, w; those of full precision where there are both."""
    exact = instancer.GetPrim().GetAttribute("orientationsf")
    attribute = exact if exact and exact.HasValue() else instancer.GetOrientationsAttr()
    value: Any = authored(attribute, time)
    if value is None or not len(value):
        return np.zeros((0, 4))
    parts = [(*q.GetImaginary(), q.GetReal()) for q in value if hasattr(q, "GetReal")]
    return as_rows(np.array(parts, np.float64), 4, attribute.GetName())


def _mask(instancer: UsdGeom.PointInstancer, count: int, time: Usd.TimeCode) -> NDArray[np.bool_]:
    """Return which copies are neither invisible nor inactive, (count,)."""
    ids = integers(instancer.GetIdsAttr(), time)
    if ids.size != count:
        ids = np.arange(count)
    hidden = integers(instancer.GetInvisibleIdsAttr(), time)
    try:
        inactive = instancer.GetPrim().GetMetadata("inactiveIds")
        listed = inactive.ApplyOperations([]) if inactive else []
    except (Tf.ErrorException, TypeError):
        listed = []
    return ~np.isin(ids, hidden) & ~np.isin(ids, np.array(listed, np.int64))


def _note_motion(instancer: UsdGeom.PointInstancer, time: Usd.TimeCode, losses: Losses) -> None:
    """Report velocities where they would have moved the copies."""
    samples = instancer.GetPositionsAttr().GetTimeSamples()
    between = bool(samples) and time.IsNumeric() and time.GetValue() not in samples
    if between and instancer.GetVelocitiesAttr().HasValue():
        losses.approximated(instancer.GetPrim(), "velocities are ignored between samples")


def _colors(prim: Usd.Prim, count: int, time: Usd.TimeCode, losses: Losses) -> Doubles | None:
    """Return the displayColor (count, 3) of each copy; other values a copy are a loss."""
    colors = None
    for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues():
        name, how = primvar.GetPrimvarName(), str(primvar.GetInterpolation())
        if how == "constant":
            continue
        try:
            if name != "displayColor":
                raise UnreadableError(f"primvar {name} that differs from copy to copy")
            colors = as_rows(primvar.ComputeFlattened(time), 3, f"primvar {name}")
            if len(colors) != count:
                found, colors = len(colors), None
                raise UnreadableError(f"primvar {name} has {found} values, expected {count}")
        except UnreadableError as reason:
            losses.dropped(prim, str(reason))
    return colors
