"""Strands: the few frames that stand for all the yarn of one system under a footprint.

Yarn that lies evenly from S₀ to S₁ along and from X₀ to X₁ across is a patch. Only that part of it
counts which both viewer and light see, and that part ends at curves of a closed form::

    n·ω ∝ ρ X ω_x + cos v (ω_y sin u + ω_z cos u),   X = sin v,   sin u = S (1 + k) / (1 + k cos v)

At a given u it changes its sign at one X, at a given X it is positive for u within one interval. A
patch is cut at these twice: across, where none of it is seen, then along, at each place across.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.shading.footprint import NOTHING, POINT, Box, arcs, halves, twist

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from weaveusd.shading.fibre import Doubles
    from weaveusd.synth.moments import Section

STEEPEST = 0.9998
"""No sine of an inclination exceeds that of 90° − 0.02 rad."""


@dataclass(frozen=True, slots=True)
class Nodes:
    """How finely a footprint is cut.

    `across` places in each half of a yarn, `arcs` for each slope. `beyond` adds the faces that are
    turned away from viewer and light alike, which a texture shows as it shows any other.
    """

    across: int
    arcs: int
    beyond: bool = True


FULL, LEAN = Nodes(2, 2), Nodes(1, 2, beyond=False)


class Strand(NamedTuple):
    """An arc to be shaded for P pairs of directions, in the yarn's frame."""

    x: Doubles  # (P,) place across
    across: tuple[Doubles, Doubles]  # (P,) ends of what it stands for across
    along: tuple[Doubles, Doubles]  # (P,) ends of the arc in S
    weight: Doubles  # (P,) share of the footprint
    sin_psi: float


class _Place(NamedTuple):
    """A strand without its twist."""

    x: Doubles
    across: tuple[Doubles, Doubles]
    along: tuple[Doubles, Doubles]
    weight: Doubles


class _View(NamedTuple):
    """A direction and a face of the yarn: n·ω ∝ ρ X aside + cos v level cos(u − φ)."""

    aside: Doubles  # (P,)
    level: Doubles  # (P,)
    phi: Doubles  # (P,) the inclination that faces it best


class _Patch(NamedTuple):
    """What is even along and across, the inclinations at both ends of it, and the yarn's shape."""

    arc: Box
    half: Box
    slopes: tuple[float, float]
    section: Section


def strands(
    wi: Doubles, wo: Doubles, side: Doubles, moments: Doubles, section: Section, nodes: Nodes
) -> Iterator[Strand]:
    """Yield the strands of a footprint with `moments`, for directions in the yarn's frame.

    `side` (P,) is −1 where light comes from the other side of the cloth than it is seen from. A
    strand that is not seen has weight 0; one that nobody sees is left out.
    """
    outside = np.where(wi[:, 2] < 0, -1.0, 1.0)
    views = _view(wi, outside), _view(wo, outside * side)
    mean, deviation = twist(moments)
    across = halves(moments)
    for i, arc in enumerate(arcs(moments, nodes.arcs)):
        if arc.share <= NOTHING:
            continue
        for half in across:
            j = int(half.low + half.high < 0)
            patch = _patch(arc, half, section)
            places = list(_facing(views, patch, nodes.across))
            if nodes.beyond:
                places.append(_beyond(views, patch))
            for k, place in enumerate(places):
                # Two points of mean and variance, each at every other strand.
                psi = mean + (deviation if (i + j + k) % 2 else -deviation)
                if place.weight.any():
                    yield Strand(*place, min(max(psi, -1), 1))


def frame(s: ArrayLike, x: Doubles, sin_psi: float, section: Section) -> tuple[Doubles, Doubles]:
    """Return normal and fibre (P, 3) at a place, in the yarn's frame (physics.md C)."""
    sin_u, cos_u = _bend(s, x, section)
    cos_v, slant = np.sqrt(np.maximum(1 - x**2, 0)), section.flatness * x
    scale = 1 / np.sqrt(slant**2 + cos_v**2)
    aside, up = slant * scale, cos_v * scale
    cos_psi = np.sqrt(1 - sin_psi**2)
    normal = np.stack([aside, up * sin_u, up * cos_u], -1)
    fibre = [
        -sin_psi * up,
        cos_psi * cos_u + sin_psi * aside * sin_u,
        sin_psi * aside * cos_u - cos_psi * sin_u,
    ]
    return normal, np.stack(fibre, -1)


def _patch(arc: Box, half: Box, section: Section) -> _Patch:
    middle, reach = 0.5 * (arc.low + arc.high), max(0.5 * (arc.high - arc.low), 0.5 * POINT)
    arc = Box(middle - reach, middle + reach, arc.share)
    x = np.asarray(0.5 * (half.low + half.high))
    low, high = (float(np.arcsin(_bend(s, x, section)[0])) for s in (arc.low, arc.high))
    return _Patch(arc, half, (low, high), section)


def _facing(views: tuple[_View, ...], patch: _Patch, count: int) -> Iterator[_Place]:
    """Yield `count` places across what somewhere along the arc faces all `views`."""
    bounds = [_across(v, np.clip(v.phi, *patch.slopes), 1.0, patch) for v in views]
    low, high = _inside(patch.half, bounds)
    for k in range(count):
        ends = low + k / count * (high - low), low + (k + 1) / count * (high - low)
        x = 0.5 * (ends[0] + ends[1])
        seen = [_along(view, x, patch.section) for view in views]
        yield _place(patch, x, ends, _inside(patch.arc, seen))


def _beyond(views: tuple[_View, ...], patch: _Patch) -> _Place:
    """Return one place across what somewhere along the arc faces none of `views`.

    That is the arc's begin, its end, or what lies between the parts that face one view each. Where
    there is more than one, the strand is as long as all and lies in their middle.
    """
    low, high = patch.slopes
    worst = [np.where(np.abs(low - v.phi) > np.abs(high - v.phi), low, high) for v in views]
    bounds = [_across(v, u, -1.0, patch) for v, u in zip(views, worst, strict=True)]
    across = _inside(patch.half, bounds)
    x = 0.5 * (across[0] + across[1])
    begins, ends = zip(*(_along(view, x, patch.section) for view in views), strict=True)
    first, last = np.full_like(x, patch.arc.low), np.full_like(x, patch.arc.high)
    dark = (first, np.min(begins, 0)), (np.min(ends, 0), np.max(begins, 0)), (np.max(ends, 0), last)
    parts = [_inside(patch.arc, [part]) for part in dark]
    length = sum((end - begin for begin, end in parts), np.zeros_like(x))
    moment = sum((0.5 * (end * end - begin * begin) for begin, end in parts), np.zeros_like(x))
    middle = np.where(length > 0, moment / np.maximum(length, 1e-12), first)
    return _place(patch, x, across, (middle - 0.5 * length, middle + 0.5 * length))


def _place(
    patch: _Patch, x: Doubles, across: tuple[Doubles, Doubles], along: tuple[Doubles, Doubles]
) -> _Place:
    arc, half = patch.arc, patch.half
    share = arc.share * half.share / ((arc.high - arc.low) * (half.high - half.low))
    return _Place(x, across, along, share * (across[1] - across[0]) * (along[1] - along[0]))


def _inside(box: Box, bounds: list[tuple[Doubles, Doubles]]) -> tuple[Doubles, Doubles]:
    """Return the ends of what lies within `box` and all `bounds`, one place where nothing does."""
    low, high = box.low, box.high
    lows, highs = zip(*bounds, strict=True)
    begin = np.clip(np.max(lows, 0), low, high)
    return begin, np.maximum(np.clip(np.min(highs, 0), low, high), begin)


def _view(w: Doubles, face: Doubles) -> _View:
    y, z = face * w[:, 1], face * w[:, 2]
    return _View(face * w[:, 0], np.maximum(np.hypot(y, z), 1e-12), np.arctan2(y, z))


def _across(view: _View, u: Doubles, face: float, patch: _Patch) -> tuple[Doubles, Doubles]:
    """Return the bounds (P,) in X of yarn inclined by `u` that faces `view`, or for −1 does not.

    n·ω ∝ ρ X ω_x + cos v c changes its sign once, at X = −c / √(c² + ρ² ω_x²) on the side of ω_x.
    """
    c, aside = face * view.level * np.cos(u - view.phi), face * view.aside
    border = c / np.maximum(np.hypot(c, patch.section.flatness * aside), 1e-12)
    return np.where(aside > 0, -border, -1), np.where(aside < 0, border, 1)


def _along(view: _View, x: Doubles, section: Section) -> tuple[Doubles, Doubles]:
    """Return the bounds (P,) in S of yarn that faces `view` at a place across."""
    cos_v = np.sqrt(np.maximum(1 - x**2, 1e-12))
    reach = np.arccos(np.clip(-section.flatness * x * view.aside / (cos_v * view.level), -1, 1))
    scale = (1 + section.curvature * cos_v) / (1 + section.curvature)
    low, high = (np.clip(view.phi + a, -0.5 * np.pi, 0.5 * np.pi) for a in (-reach, reach))
    return scale * np.sin(low), scale * np.sin(high)


def _bend(s: ArrayLike, x: Doubles, section: Section) -> tuple[Doubles, Doubles]:
    """Return sin u and cos u at a place: sin u = S (1 + k) / (1 + k cos v)."""
    k = section.curvature
    cos_v = np.sqrt(np.maximum(1 - np.square(x), 0))
    sine = np.clip(np.asarray(s) * (1 + k) / (1 + k * cos_v), -STEEPEST, STEEPEST)
    return sine, np.sqrt(1 - sine**2)
