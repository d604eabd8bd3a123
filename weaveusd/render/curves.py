"""UsdGeom.BasisCurves as tubes: polylines, or cubic B-splines of four controls a segment.

Every cubic basis of USD spans the same polynomials, so that a segment of one is a segment of
another with other controls: nothing is approximated. Radii are a fourth coordinate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdGeom

from weaveusd.render.geometry import Strands
from weaveusd.render.model import Losses
from weaveusd.render.reading import UnreadableError, as_rows, integers, rows, token

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

MAX_SEGMENTS = 1 << 22

# Columns belong to the controls, rows to 1, t, t² and t³.
_POLYNOMIAL = {
    "bspline": np.array(((1.0, 4, 1, 0), (-3, 0, 3, 0), (3, -6, 3, 0), (-1, 3, -3, 1))) / 6,
    "bezier": np.array(((1.0, 0, 0, 0), (-3, 3, 0, 0), (3, -6, 3, 0), (-1, 3, -3, 1))),
    "catmullRom": np.array(((0.0, 2, 0, 0), (-1, 0, 1, 0), (2, -5, 4, -1), (-1, 3, -3, 1))) / 2,
}
_BSPLINE_FROM = {
    basis: np.linalg.solve(_POLYNOMIAL["bspline"], matrix) for basis, matrix in _POLYNOMIAL.items()
}
_BSPLINE_FROM_ENDS = np.array(((2.0, -1), (1, 0), (0, 1), (-1, 2)))
"""Controls of a value that runs straight from the start of a segment to its end."""


@dataclass(frozen=True, slots=True, eq=False)
class Curves:
    """Curves cut into segments.

    `taps` are the points of each segment, numbered within its curve; -1 and the curve's length
    are the phantoms that pinned curves have beyond their ends.
    """

    basis: str  # "linear" or one of the cubic ones
    periodic: bool
    starts: Indices  # (N,) first point of each curve
    lengths: Indices  # (N,) points of each curve
    segments: Indices  # (N,) segments of each curve
    curve: Indices  # (S,) curve of each segment
    place: Indices  # (S,) number of each segment in its curve
    taps: Indices  # (S, 2) or (S, 4)

    def at_taps(self, values: Doubles) -> Doubles:
        """Return values (P, k) of the points at the taps of each segment, (S, taps, k)."""
        start, length = (a[self.curve][:, None] for a in (self.starts, self.lengths))
        inside = start + np.clip(self.taps, 0, length - 1)
        inward = start + np.clip(np.where(self.taps < 0, 1, length - 2), 0, length - 1)
        beyond = (self.taps < 0) | (self.taps >= length)
        mirrored = 2 * values[inside] - values[inward]
        return np.where(beyond[..., None], mirrored, values[inside])

    def at_ends(self, values: Doubles) -> Doubles:
        """Return values (n, k), one for each joint, at both ends of each segment, (S, 2, k)."""
        joints = self.joints()
        first = (np.cumsum(joints) - joints)[self.curve] + self.place
        last = np.where(self.place + 1 < joints[self.curve], first + 1, first - self.place)
        return np.stack((values[first], values[last]), axis=1)

    def joints(self) -> Indices:
        """Return the number of varying values of each curve, (N,)."""
        return self.segments if self.periodic else self.segments + (self.segments > 0)


def strands(prim: Usd.Prim, time: Usd.TimeCode, losses: Losses) -> tuple[Strands, Curves]:
    """Return the curves as tubes, and how they are cut into segments.

    Raises
    ------
    UnreadableError
        When they hold nothing that could be shown.
    """
    schema = UsdGeom.BasisCurves(prim)
    points = rows(schema.GetPointsAttr(), time, 3)
    curves = _cut(schema, len(points), time, losses)
    widths, how = _widths(schema, time, losses)
    if UsdGeom.PrimvarsAPI(prim).HasPrimvar("normals") or schema.GetNormalsAttr().HasValue():
        losses.approximated(prim, "ribbons along normals are shown as tubes")
    if curves.basis == "linear":
        places = curves.at_taps(points)
        radii = _spread(widths, how, curves, 2) / 2
        controls = np.concatenate((places, radii), axis=2)
        return _linear(controls, curves), curves
    to_bspline = _BSPLINE_FROM[curves.basis]
    places = to_bspline @ curves.at_taps(points)
    if how == "vertex":
        radii = to_bspline @ _spread(widths, how, curves, 4) / 2
    else:
        radii = _BSPLINE_FROM_ENDS @ _spread(widths, how, curves, 2) / 2
    controls = np.concatenate((places, radii), axis=2).reshape(-1, 4)
    return Strands(True, controls, 4 * np.arange(len(places))), curves


def _linear(controls: Doubles, curves: Curves) -> Strands:
    """Return polylines whose segments share the controls between them, (S, 2, 4) given."""
    joined = np.zeros(len(controls), bool)
    joined[:-1] = curves.curve[1:] == curves.curve[:-1]
    kept = np.stack((np.ones(len(controls), bool), ~joined), axis=1)
    number = np.cumsum(kept.ravel()) - 1
    return Strands(False, controls.reshape(-1, 4)[kept.ravel()], number[0::2])


def _cut(schema: UsdGeom.BasisCurves, points: int, time: Usd.TimeCode, losses: Losses) -> Curves:
    """Return the segments of the curves; curves too short to have any are a loss."""
    prim = schema.GetPrim()
    lengths = integers(schema.GetCurveVertexCountsAttr(), time)
    if not lengths.size or lengths.min() < 0 or int(lengths.sum()) != points:
        raise UnreadableError(f"has {points} points, which is not what its curves ask for")
    cubic = token(schema.GetTypeAttr(), time, "cubic") != UsdGeom.Tokens.linear
    basis = token(schema.GetBasisAttr(), time, "bezier") if cubic else "linear"
    if cubic and basis not in _POLYNOMIAL:
        raise UnreadableError(f"basis {basis} is not supported")
    wrap = token(schema.GetWrapAttr(), time, "nonperiodic")
    periodic, pinned = wrap == UsdGeom.Tokens.periodic, wrap == UsdGeom.Tokens.pinned
    step = 3 if basis == "bezier" else 1
    phantom = int(pinned and basis in ("bspline", "catmullRom"))
    taps = 4 if cubic else 2
    whole = lengths if periodic else lengths + 2 * phantom - taps + step
    segments = whole // step
    segments = np.where(lengths >= (3 if periodic else taps - 2 * phantom), segments, 0)
    if (segments <= 0).any() or ((lengths - (0 if periodic else 1)) % step).any():
        losses.dropped(prim, "points of curves that make no whole segment")
    segments = np.maximum(segments, 0)
    total = int(segments.sum())
    if not 0 < total <= MAX_SEGMENTS:
        raise UnreadableError(f"has {total} segments, expected 1 to {MAX_SEGMENTS}")
    curve = np.repeat(np.arange(lengths.size), segments)
    place = np.arange(total) - np.repeat(np.cumsum(segments) - segments, segments)
    number = step * place[:, None] + np.arange(taps) - phantom
    if periodic:
        number %= lengths[curve][:, None]
    starts = np.cumsum(lengths) - lengths
    return Curves(basis, periodic, starts, lengths, segments, curve, place, number)


def _widths(schema: UsdGeom.BasisCurves, time: Usd.TimeCode, losses: Losses) -> tuple[Doubles, str]:
    """Return widths (n, 1), never negative, and their interpolation, `primvars:widths` first."""
    prim = schema.GetPrim()
    primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("widths")
    if primvar and primvar.HasValue():
        values = as_rows(primvar.ComputeFlattened(time), 1, "widths")
        how = str(primvar.GetInterpolation())
    else:
        values = rows(schema.GetWidthsAttr(), time, 1)
        how = str(schema.GetWidthsInterpolation())
    if not len(values):
        losses.approximated(prim, "has no widths: 1 is used")
        return np.ones((1, 1)), "constant"
    # One value is one for all, whatever the interpolation, as in usdview.
    return np.maximum(values, 0), "constant" if len(values) == 1 else how


def _spread(widths: Doubles, how: str, curves: Curves, taps: int) -> Doubles:
    """Return widths (S, taps, 1): vertex ones at the taps, others from end to end."""
    needed = {
        "constant": 1,
        "uniform": curves.lengths.size,
        "vertex": int(curves.lengths.sum()),
        "varying": int(curves.joints().sum()),
    }.get(how)
    if needed is None:
        raise UnreadableError(f"widths are {how}, which curves do not have")
    if len(widths) < needed:
        raise UnreadableError(f"has {len(widths)} {how} widths, expected {needed}")
    if how == "constant":
        return np.broadcast_to(widths[0], (len(curves.curve), taps, 1))
    if how == "uniform":
        return np.repeat(widths[curves.curve][:, None], taps, axis=1)
    return curves.at_taps(widths) if how == "vertex" else curves.at_ends(widths)


def curve_colors(
    prim: Usd.Prim, curves: Curves, time: Usd.TimeCode, losses: Losses
) -> Doubles | None:
    """Return one displayColor for each segment, (S, 3); None without one.

    Colors that vary along a curve become their mean over the curve, which is a loss.
    """
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    if not primvar or not primvar.HasValue():
        return None
    try:
        values = as_rows(primvar.ComputeFlattened(time), 3, "primvar displayColor")
    except UnreadableError as reason:
        losses.dropped(prim, str(reason))
        return None
    how = "constant" if len(values) == 1 else str(primvar.GetInterpolation())
    counts = {"vertex": curves.lengths, "varying": curves.joints()}.get(how)
    needed = {"constant": 1, "uniform": curves.lengths.size}.get(how)
    if counts is not None:
        needed = int(counts.sum())
    if needed is None or len(values) < needed:
        losses.dropped(prim, f"primvar displayColor: has {len(values)} {how} values")
        return None
    if how == "constant":
        return np.repeat(values[:1], len(curves.curve), axis=0)
    if counts is not None:
        losses.approximated(prim, "displayColor along a curve is shown as its mean")
        ends = np.cumsum(counts)
        sums = np.concatenate((np.zeros((1, 3)), np.cumsum(values[:needed], axis=0)))
        values = (sums[ends] - sums[ends - counts]) / np.maximum(counts, 1)[:, None]
    return np.asarray(values[curves.curve])
