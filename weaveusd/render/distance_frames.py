"""Frames of a cell's yarns: where on its arcs, sections and twists they are drawn.

The frame of a yarn at S, X and P is that of `distance_levels`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import mitsuba as mi

from weaveusd.render import distance_levels as dl
from weaveusd.render import lobes

DRAWN = 2
"""Strands of each system that are drawn for a hit."""

ARCS = 4
"""Arcs into which a class is cut; a strand lies in one of them."""

STEEPEST = 0.9998
"""The largest sin u: beyond it a yarn is seen by nobody."""

_MIXED = 16777216.0

Frames = list[tuple[Any, Any]]
"""Normal and tangent at the beginning, a place within and the end of an arc."""


def uniforms(u: Any, v: Any, count: int) -> list[Any]:
    """Return `count` numbers in 0…1 that are as good as random, of a place on the cloth."""
    first, second = (mi.UInt32((w - dr.floor(w)) * _MIXED) for w in (u, v))
    found: list[Any] = []
    while len(found) < count:
        first, second = mi.sample_tea_32(first, second, 4)
        for number in (first, second):
            found += [mi.Float(number & 0xFFFF) / 65536, mi.Float(number >> 16) / 65536]
    return found[:count]


@dataclass(frozen=True, slots=True)
class Section:
    """A place on the yarns of a system: X, P, k and ρ, and how its frames turn to the cloth's."""

    x: Any
    twist: Any
    bend: Any
    flatness: Any
    is_weft: bool
    mirror: Any

    def frames(self, arc: Sequence[Any]) -> Frames:
        """Return normal and tangent at the beginning, a place within and the end of an arc of S."""
        cos_v = dr.safe_sqrt(1 - dr.square(self.x))
        side = self.flatness * self.x
        scale = dr.rsqrt(dr.maximum(dr.square(side) + dr.square(cos_v), lobes.TINY))
        side, up = side * scale, cos_v * scale
        sin_t, cos_t = self.twist, dr.safe_sqrt(1 - dr.square(self.twist))
        stretch = (1 + self.bend) / (1 + self.bend * cos_v)
        found: Frames = []
        for s in arc:
            sin_u = dr.clip(s * stretch, -STEEPEST, STEEPEST)
            cos_u = dr.sqrt(1 - dr.square(sin_u))
            along = (cos_t * cos_u + sin_t * side * sin_u, sin_t * side * cos_u - cos_t * sin_u)
            normal = self._in_cloth(side, up * sin_u, up * cos_u)
            found.append((normal, self._in_cloth(-sin_t * up, *along)))
        return found

    def _in_cloth(self, x: Any, y: Any, z: Any) -> Any:
        return self.mirror * (mi.Vector3f(y, -x, z) if self.is_weft else mi.Vector3f(x, y, z))


def spaced(chance: Any, number: int) -> Any:
    """Return one of `DRAWN` numbers in 0…1 that lie evenly apart, each of them uniform."""
    place = chance + number / DRAWN
    return place - dr.floor(place)


def across_at(numbers: Sequence[Any], place: Any) -> Any:
    """Return X at a place on both halves of the yarns, first that where X is positive.

    |X| grows in the first and shrinks in the other: strands half a place apart differ in it.
    """
    right = numbers[dl.RIGHT]
    is_right = place < right
    within = dr.select(is_right, place, 1 - place)
    within /= dr.maximum(dr.select(is_right, right, 1 - right), lobes.TINY)
    aside = dr.lerp(numbers[dl.ASIDE_LOW], numbers[dl.ASIDE_HIGH], within)
    return dr.select(is_right, aside, -aside)


def arc_at(numbers: Sequence[Any], place: Any) -> Sequence[Any]:
    """Return begin, place and end in S of the arc at a place among the shares of a system."""
    rises = place >= numbers[dl.FLAT]
    falls = place >= numbers[dl.FLAT] + numbers[dl.RISE]
    low = dr.select(falls, numbers[dl.FALL_LOW], numbers[dl.RISE_LOW])
    high = dr.select(falls, numbers[dl.FALL_HIGH], numbers[dl.RISE_HIGH])
    share = dr.select(falls, numbers[dl.FALL], numbers[dl.RISE])
    within = place - numbers[dl.FLAT] - dr.select(falls, numbers[dl.RISE], 0)
    along = ARCS * dr.clip(within / dr.maximum(share, lobes.TINY), 0, 0.99999994)
    part = dr.floor(along)
    ends = (dr.lerp(low, high, place / ARCS) for place in (part, along, part + 1))
    return [dr.select(rises, s, 0) for s in ends]
