"""The cloth from afar: light from all that warp and weft do within a pixel's footprint.

A hit of a footprint larger than the cells of `distance_levels` is shaded by strands of its cell:
two each of warp and weft, drawn evenly from flat, rising and falling classes. Along the arc through
which the spine of a strand turns, θ_h runs from h₀ to h₁, nearly evenly, so that the mean of the
Cauchy lobe over it is known exactly: with A = (h₁ − h₀)/2 and h = (h₀ + h₁)/2,

    mean C = [atan((h + A)/γ) − atan((h − A)/γ)] / (2 π A)

What is left to chance is drawn anew at every hit: the level, of the two next to the footprint; the
class, the arc and the place in it, the place on the yarn's section and the twist. So the mean of
many samples is that of the whole cell, and near and far pass into each other without a seam.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi

from weaveusd.render import distance_levels as dl
from weaveusd.render import lobes, sampling
from weaveusd.render.distance_frames import DRAWN, Frames, Section, across_at, arc_at, spaced

SHORTEST = 1e-4
"""The least half length of an arc in radians, below which it is a point."""


@dataclass(frozen=True, slots=True)
class Seen:
    """The texel of a hit, and where it is what is seen, rather than a cell."""

    here: Any
    opacity: Any
    yarn: lobes.LobeParameters
    normal: Any
    tangent: Any


@dataclass(frozen=True, slots=True)
class Strand:
    """The yarns of one class in a cell: their share, one frame, and the arc of its fibre."""

    share: Any
    yarn: lobes.LobeParameters
    guess: lobes.LobeParameters  # the yarn with a lobe as wide as its arc, to draw from
    fibre: lobes.Fibre
    ends: tuple[Any, Any]  # tangents at both ends of the arc
    inclinations: tuple[Any, Any]  # of the viewer at both ends


def strands(
    cell: Sequence[Any],
    optics: Sequence[Sequence[Sequence[Any]]],
    shape: Sequence[Sequence[Any]],
    seen: Seen | None,
    wi: Any,
    mirror: Any,
    chance: Sequence[Any],
) -> list[Strand]:
    """Return what is drawn of the classes of a cell, `DRAWN` strands of warp and as many of weft.

    Parameters
    ----------
    cell
        The numbers of `distance_levels.Levels` at the hit.
    optics
        Of every strand of warp and of weft, in the order of `YARN_INPUTS`.
    shape
        Bend k and flatness ρ of warp and of weft.
    seen
        The texel that takes the place of all where it is seen; None where none is.
    wi
        Where the viewer is, in the frame of the surface.
    mirror
        A vector by which the cloth's frame is multiplied where texture coordinates are mirrored.
    chance
        Uniform numbers: of X, P and the class of the warp, and of the weft.
    """
    found: list[tuple[Any, lobes.LobeParameters, Frames]] = []
    for system in range(2):
        numbers = cell[system * dl.NUMBERS : (system + 1) * dl.NUMBERS]
        bend, flatness = shape[system]
        color = mi.Color3f(*numbers[dl.COLOR : dl.COLOR + 3])
        covered = numbers[dl.FLAT] + numbers[dl.RISE] + numbers[dl.FALL]
        for number in range(DRAWN):
            yarn = lobes.LobeParameters(color, *optics[system][number])
            x, twist, place = (spaced(chance[3 * system + k], number) for k in range(3))
            section = Section(
                across_at(numbers, x),
                dr.lerp(numbers[dl.TWIST_LOW], numbers[dl.TWIST_HIGH], twist),
                bend, flatness, is_weft=system == 1, mirror=mirror,
            )  # fmt: skip
            frames = section.frames(arc_at(numbers, place * covered))
            found.append((covered * (1 / DRAWN), yarn, frames))
    if seen is not None:
        found = [_or_texel(seen, *drawn, first=k == 0) for k, drawn in enumerate(found)]
    return [_strand(*drawn, wi) for drawn in found]


def value(of: Sequence[Strand], wi: Any, wo: Any, allowed: Any) -> Any:
    """Return Σ share · f |n·ωo| over the strands; `allowed` tells whether a side counts."""
    total = mi.Color3f(0)
    for strand in of:
        direction = strand.fibre.direction(wo)
        spread = _spread(strand, wo)
        lit = lobes.value(strand.yarn, strand.fibre, direction, spread) * strand.share
        total += dr.select(allowed(wi, wo, direction), lit, 0)
    return total


def density(of: Sequence[Strand], wi: Any, wo: Any, allowed: Any, asked: Any) -> Any:
    """Return the density of `draw` at `wo`."""
    total = mi.Float(0)
    for strand, chance in zip(of, _chances(of), strict=True):
        direction = strand.fibre.direction(wo)
        found = sampling.density(asked(strand.guess), strand.fibre, direction)
        total += dr.select(allowed(wi, wo, direction), found * chance, 0)
    return total


def draw(
    of: Sequence[Strand], wi: Any, choice: Any, point: Any, allowed: Any, asked: Any
) -> tuple[Any, Any]:
    """Return a direction that is distributed after `density`, and whether it counts."""
    chances = _chances(of)
    fibre, guess = of[0].fibre, of[0].guess
    begin, width = mi.Float(0), chances[0]
    reached = chances[0]
    for strand, chance in zip(of[1:], chances[1:], strict=True):
        later = (choice >= reached) & (chance > 0)
        fibre = _select(later, strand.fibre, fibre)
        guess = _select(later, strand.guess, guess)
        begin, width = dr.select(later, reached, begin), dr.select(later, chance, width)
        reached = reached + chance
    rest = dr.clip((choice - begin) / dr.maximum(width, lobes.TINY), 0, 0.99999994)
    direction = sampling.sample(asked(guess), fibre, rest, point)
    wo = fibre.vector(direction)
    return wo, allowed(wi, wo, direction) & (reached > 0)


def coverage(of: Sequence[Strand]) -> Any:
    """Return the share of the cell that is yarn."""
    return dr.minimum(sum((strand.share for strand in of[1:]), of[0].share), 1)


def _strand(share: Any, yarn: lobes.LobeParameters, frames: Frames, wi: Any) -> Strand:
    low, within, high = frames
    fibre = lobes.fibre(wi, *within)
    ends = (low[1], high[1])
    first, last = (_inclination(wi, t) for t in ends)
    # From the mirror's side θo turns as θi does; what is drawn is as wide as that makes it, and one
    # lobe for surface and volume: the arc makes them alike.
    half = dr.maximum(0.5 * dr.abs(last - first), SHORTEST)
    wide = half / dr.atan2(half, dr.sqrt(yarn.gamma_s * yarn.gamma_v))
    guess = replace(yarn, gamma_s=wide, gamma_v=wide)
    return Strand(share, yarn, guess, fibre, ends, (first, last))


def _spread(strand: Strand, wo: Any) -> Any:
    """Return the function of γ that is the mean of the Cauchy lobe over the arc of a strand."""
    low, high = (
        0.5 * (theta + _inclination(wo, t))
        for theta, t in zip(strand.inclinations, strand.ends, strict=True)
    )
    half = dr.maximum(0.5 * dr.abs(high - low), SHORTEST)
    center = 0.5 * (low + high)

    def mean(gamma: Any) -> Any:
        span = dr.atan2(2 * half * gamma, dr.square(gamma) + dr.square(center) - dr.square(half))
        return span / (2 * math.pi * half)

    return mean


def _or_texel(
    seen: Seen, share: Any, yarn: lobes.LobeParameters, frames: Frames, *, first: bool
) -> tuple[Any, lobes.LobeParameters, Frames]:
    """Return a strand's parts where a cell is seen; where a texel is, the first strand is it."""
    if not first:
        return dr.select(seen.here, 0, share), yarn, frames
    turned = [
        (dr.select(seen.here, seen.normal, n), dr.select(seen.here, seen.tangent, t))
        for n, t in frames
    ]
    share = dr.select(seen.here, seen.opacity, share)
    return share, _select(seen.here, seen.yarn, yarn), turned


def _inclination(w: Any, t: Any) -> Any:
    return dr.asin(dr.clip(dr.dot(w, t), -1, 1))


def _chances(of: Sequence[Strand]) -> list[Any]:
    """Return how often each strand is drawn: by its share, so that none that is seen is missed."""
    total = sum((strand.share for strand in of[1:]), of[0].share)
    scale = dr.select(total > 0, 1 / dr.maximum(total, lobes.TINY), 0)
    return [dr.detach(strand.share * scale) for strand in of]


def _select(mask: Any, chosen: Any, other: Any) -> Any:
    """Return one of two dataclasses of arrays."""
    if isinstance(chosen, bool):
        return chosen
    if not hasattr(chosen, "__dataclass_fields__"):
        return dr.select(mask, chosen, other)
    return type(chosen)(
        **{
            name: _select(mask, getattr(chosen, name), getattr(other, name))
            for name in chosen.__dataclass_fields__
        }
    )
