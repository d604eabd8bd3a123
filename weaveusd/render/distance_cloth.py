"""The cloth near and far: its texels where they are seen, its levels where they are not."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import drjit as dr
import mitsuba as mi
import numpy as np

from weaveusd.render import distance, lobes
from weaveusd.render.distance_frames import uniforms
from weaveusd.render.distance_kinds import Kinds, kind_properties
from weaveusd.render.distance_levels import COLOR, FALL, FLAT, NUMBERS, RISE, Levels
from weaveusd.render.exact import (
    Cloth,
    allowed_sides,
    asked_yarn,
    gap_weight,
    lobes_share,
    mirroring,
    sample_record,
)
from weaveusd.render.numbering import evenly
from weaveusd.render.packing import OPACITY

if TYPE_CHECKING:
    from numpy.typing import NDArray

SHARPNESS = 0.25
"""Side of a cell over that of a pixel at the level `_MIDDLE`."""

_MIDDLE, _BEFORE, _AFTER = 1.0, -4 / 3, 1.0
"""From its middle on, the level grows twice as fast as the pixel until it is `_AFTER` more; level 2
has cells of a crossing. Before, it falls three times as fast, until it is `_BEFORE` more: while a
pixel holds one yarn, its samples find that with less noise than cells do."""

_PLACES, _STRANDS, _CHANCES = 3, 9, 11
"""Ends of the numbers for level and cell, for the strands, and for their kinds."""

_ALL_BUT_ONE = 0.99999994
_STRAIGHT = 0.999999
"""Cosine of the angle to the eye from which on a hit is the first of its path."""

_SHARES = (FLAT, RISE, FALL, NUMBERS + FLAT, NUMBERS + RISE, NUMBERS + FALL)


@dataclass(frozen=True, slots=True)
class View:
    """How large a pixel is where it meets the cloth, in units of the scene.

    The footprint is `per_distance` times the distance to `eye`, plus `constant`. A `level` that
    is no negative number is used everywhere instead.
    """

    eye: tuple[float, float, float] = (0.0, 0.0, 0.0)
    per_distance: float = 0.0
    constant: float = 0.0
    level: int = -1


EVERYTHING_NEAR = View()


def seen_by(sensor: Any, level: int | None = None) -> View:
    """Return the view of a loaded sensor, or that of a level that is used everywhere."""
    if level is not None:
        return View(level=level)
    width, height = sensor.film().size()
    places = ((0.5, 0.5), (0.5 + 1 / width, 0.5), (0.5, 0.5 + 1 / height))
    rays = []
    for place in places:
        ray, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(*place), mi.Point2f(0.5))
        rays.append([np.asarray(v, np.float64).ravel() for v in (ray.o, ray.d)])
    (eye, ahead), *beside = rays
    turned = [float(np.linalg.norm(d - ahead)) for _, d in beside]
    moved = [float(np.linalg.norm(o - eye)) for o, _ in beside]
    # Of a perspective camera every ray starts on the near plane: its origin is not the eye.
    is_parallel = max(turned) < 1e-9
    if not is_parallel:
        eye = np.asarray(sensor.world_transform().matrix, np.float64).reshape(4, 4)[:3, 3]
    x, y, z = (float(c) for c in eye)
    if is_parallel:
        return View((x, y, z), 0.0, float(np.sqrt(moved[0] * moved[1])))
    return View((x, y, z), float(np.sqrt(turned[0] * turned[1])), 0.0)


def with_view(bsdf: dict[str, Any], view: View) -> dict[str, Any]:
    """Return the dictionary of a BSDF, seen by `view` where it is a cloth with levels."""
    return {**bsdf, "view": _tensor(view)} if "cells" in bsdf else bsdf


def distant_properties(levels: Levels, optics: NDArray[np.float32], view: View) -> dict[str, Any]:
    """Return what `DistantCloth` finds in the plugin's properties, from the optics of all yarns."""
    return {
        **kind_properties(levels, optics),
        "cells": mi.TensorXf(levels.numbers),
        "level_sizes": mi.TensorXf([[float(s) for s in levels.rows],
                                    [float(s) for s in levels.columns]]),
        "yarn_shape": mi.TensorXf([list(levels.bend), list(levels.flatness)]),
        "view": _tensor(view),
    }  # fmt: skip


def _tensor(view: View) -> Any:
    return mi.TensorXf([*view.eye, view.per_distance, view.constant, float(view.level)])


class DistantCloth(Cloth):
    """`Cloth` where a pixel is smaller than the finest cell, else the strands of a cell.

    Both are looked up at every hit, unless `look` has found that one of them serves all.
    """

    def __init__(self, props: Any, *texels: Any) -> None:
        super().__init__(*texels)
        self.cells = mi.Float(props["cells"].array)
        rows, columns = (_listed(props["level_sizes"][i].array) for i in range(2))
        starts = [0.0]
        for r, c in zip(rows, columns, strict=True):
            starts.append(starts[-1] + r * c)
        self.top = len(rows) - 1
        self.finest = rows[0] * columns[0]
        self.table = [mi.Float(column) for column in (starts[:-1], rows, columns)]
        shape = props["yarn_shape"]
        self.shape = [[mi.Float(shape[i].array[k]) for i in range(2)] for k in range(2)]
        self.kinds = Kinds(props)
        view = _listed(props["view"].array)
        self.eye, self.footprint = mi.Point3f(*view[:3]), [mi.Float(view[3]), mi.Float(view[4])]
        self.fixed = int(view[5])
        self.shows_texels = self.shows_cells = True
        dr.make_opaque(self.table, self.shape, self.eye, self.footprint)

    def look(self, si: Any, hit: Any) -> None:
        """Leave out texels or cells that none of the interactions `hit` of a picture show.

        Where there is none, nothing is known, and both stay. A hit that was not looked at and
        would show what is left out shows the other, from next to where they meet.
        """
        self.shows_texels = self.shows_cells = True
        texels = dr.any(hit & (self.level(si, 0.0) < 0))
        cells = dr.any(hit & (self.level(si, _ALL_BUT_ONE) >= 0))
        if texels or cells:
            self.shows_texels, self.shows_cells = bool(texels), bool(cells)

    def level(self, si: Any, chance: Any) -> Any:
        """Return the level to use, a whole number; -1 stands for the texels themselves."""
        if self.fixed >= 0:
            return mi.Float(min(self.fixed, self.top))
        side = SHARPNESS * self.pixel(si)
        area = dr.norm(dr.cross(si.dp_du, si.dp_dv)) / (
            self.repeats.x * self.repeats.y * self.finest
        )
        halvings = 0.5 * dr.log2(dr.maximum(dr.square(side) / dr.maximum(area, 1e-30), 1e-30))
        beyond = halvings - _MIDDLE
        halvings += dr.clip(dr.minimum(beyond, 2 * beyond), _BEFORE, _AFTER)
        halvings = dr.select(area > 0, halvings, -1)
        return dr.clip(dr.floor(halvings + chance), -1 if self.shows_texels else 0, self.top)

    def pixel(self, si: Any) -> Any:
        """Return the side of a pixel where it meets the cloth, the short one, in scene units.

        By the differentials of the ray where an integrator gives them, else by the view.
        """
        by_view = dr.norm(si.p - self.eye) * self.footprint[0] + self.footprint[1]
        if not si.has_uv_partials():
            return by_view
        x, y = (si.dp_du * step.x + si.dp_dv * step.y for step in (si.duv_dx, si.duv_dy))
        # The sides of the footprint are the singular values of the two steps: the sum of their
        # squares is that of the steps, their product the area.
        total, area = dr.squared_norm(x) + dr.squared_norm(y), dr.norm(dr.cross(x, y))
        spread = dr.safe_sqrt(dr.square(total) - dr.square(2 * area))
        long = dr.sqrt(0.5 * (total + spread))
        return dr.select(total > 0, area / dr.maximum(long, 1e-30), by_view)

    def place(self, si: Any, active: Any) -> tuple[Any, Any, list[Any]]:
        """Return where a level serves, the index of its cell, and uniform numbers."""
        u, v = si.uv.x * self.repeats.x, si.uv.y * self.repeats.y
        chance = self.chances(si, u, v)
        level = self.level(si, chance[0])
        far = active & (level >= 0)
        index = mi.UInt32(dr.maximum(level, 0))
        start, rows, columns = (dr.gather(mi.Float, column, index, far) for column in self.table)
        row = _wrapped(v * rows + chance[1] - 0.5, rows)
        column = _wrapped(u * columns + chance[2] - 0.5, columns)
        return far, mi.UInt32(start + row * columns + column), chance[_PLACES:]

    def chances(self, si: Any, u: Any, v: Any) -> list[Any]:
        """Return uniform numbers for the hit at texture coordinates in repeats.

        Those of the strands lie evenly over the samples of a pixel where it is what they see. A
        later hit of a path must not know what the first has drawn: its numbers are of its place.
        """
        chance = uniforms(u, v, _CHANCES)
        ahead = dr.dot(si.to_world(si.wi), dr.normalize(self.eye - si.p))
        is_first = (si.time > 0) & (ahead > _STRAIGHT)
        even = evenly(si.time, _STRANDS - _PLACES)
        for k, number in enumerate(even, _PLACES):
            chance[k] = dr.select(is_first, number, chance[k])
        return chance

    def strands(self, si: Any, active: Any) -> list[distance.Strand]:
        """Return what a pixel sees of the cloth at the interaction: strands, or one texel."""
        far, at, chance = self.place(si, active)
        seen = None
        if self.shows_texels:
            texel = self.texel(si, active & ~far)
            seen = distance.Seen(~far, texel[OPACITY], *self.yarn(si, texel, active & ~far))
        cell = _row(self.cells, at, far)
        optics = [self.kinds.drawn(k, at, far, chance[6 + k]) for k in range(2)]
        return distance.strands(cell, optics, self.shape, seen, si.wi, mirroring(si), chance)

    def opacity(self, si: Any, active: Any) -> Any:
        """Return the share of the interaction that is yarn."""
        if not self.shows_cells:
            return super().opacity(si, active)
        far, at, _ = self.place(si, active)
        numbers = _row(self.cells, at, far)
        covered = dr.minimum(sum(numbers[i] for i in _SHARES), 1)
        return dr.select(far, covered, super().opacity(si, active & ~far))

    def color(self, si: Any, active: Any) -> Any:
        """Return about what share of light comes back."""
        if not self.shows_cells:
            return super().color(si, active)
        far, at, _ = self.place(si, active)
        numbers = _row(self.cells, at, far)
        total = mi.Color3f(0)
        for first in (0, NUMBERS):
            share = sum(numbers[first + i] for i in (FLAT, RISE, FALL))
            total += mi.Color3f(*numbers[first + COLOR : first + COLOR + 3]) * share
        return dr.select(far, total, super().color(si, active & ~far))

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any) -> tuple[Any, Any]:
        """Return value times cosine, and density; both 0 where the side rule forbids `wo`."""
        if not self.shows_cells:
            return super().eval_pdf(ctx, si, wo, active)
        value, pdf = self._eval_pdf(ctx, si, wo, self.strands(si, active))
        return dr.select(active, value, 0), dr.select(active, pdf, 0)

    def _eval_pdf(self, ctx: Any, si: Any, wo: Any, of: list[distance.Strand]) -> tuple[Any, Any]:
        allowed, asked = partial(allowed_sides, ctx), partial(asked_yarn, ctx)
        value = distance.value(of, si.wi, wo, allowed)
        pdf = distance.density(of, si.wi, wo, allowed, asked)
        return value, pdf * lobes_share(ctx, distance.coverage(of))

    def sample(self, ctx: Any, si: Any, choice: Any, point: Any, active: Any) -> tuple[Any, Any]:
        """Return a sample and its weight: of the null component in gaps, else of the lobes."""
        if not self.shows_cells:
            return super().sample(ctx, si, choice, point, active)

        of = self.strands(si, active)
        opacity = distance.coverage(of)
        share = lobes_share(ctx, opacity)
        passes = choice >= share
        choice = dr.clip(choice / dr.maximum(share, lobes.TINY), 0, 0.99999994)
        allowed, asked = partial(allowed_sides, ctx), partial(asked_yarn, ctx)
        wo, counts = distance.draw(of, si.wi, choice, point, allowed, asked)
        value, pdf = self._eval_pdf(ctx, si, wo, of)
        counts &= active & (pdf > 0)
        bs = sample_record(si.wi, wo, passes, share, dr.select(counts, pdf, 0))
        weight = dr.select(counts, value / dr.maximum(pdf, 1e-20), 0)
        through = mi.Color3f(gap_weight(share, opacity))
        return bs, dr.select(passes, dr.select(active, through, 0), weight)


def _wrapped(place: Any, count: Any) -> Any:
    """Return the whole cell at a place on a periodic axis."""
    turned = dr.floor(place) - count * dr.floor(dr.floor(place) / count)
    return dr.clip(turned, 0, count - 1)


def _row(values: Any, row: Any, active: Any) -> list[Any]:
    """Return a row of two systems' numbers, gathered four at a time."""
    found: list[Any] = []
    for quarter in range(2 * NUMBERS // 4):
        at = row * (2 * NUMBERS // 4) + quarter
        found += [mi.Float(n) for n in dr.gather(mi.Vector4f, values, at, active)]
    return found


def _listed(values: Any) -> list[float]:
    return [float(v) for v in values]
