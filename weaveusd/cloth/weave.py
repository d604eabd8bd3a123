"""A draft and a recipe become a weave."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from weaveusd.cloth.colors import laid_colors
from weaveusd.cloth.departures import departures
from weaveusd.cloth.layout import System, edges, lay_floats
from weaveusd.cloth.model import Floats, Weave
from weaveusd.contract import MAX_YARNS, ColorSpace
from weaveusd.errors import RecipeError
from weaveusd.yarn import model
from weaveusd.yarn.irregularity import Irregularity
from weaveusd.yarn.model import Recipe, Yarn, YarnSpec
from weaveusd.yarn.textile import diameter_mm, twist_angle

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.draft.model import Draft

    Indices = NDArray[np.int32]
    Doubles = NDArray[np.float64]

T = TypeVar("T", bound=np.generic)


def weave(draft: Draft, recipe: Recipe, *, color_space: ColorSpace = "lin_rec709") -> Weave:
    """Return one repeat of the cloth that `recipe` makes of `draft`.

    The recipe's sett is the mean sett of the cloth; where the draft spaces or thickens single
    threads, their proportions to each other are kept. Colors come into `color_space` and are
    clipped there. Where the cloth is not what the recipe states, `Weave.warnings` says so.
    Raises RecipeError when no yarn serves a palette entry that the draft uses, or there are more
    than `contract.MAX_YARNS` yarns.
    """
    warp_up = draft.drawdown()
    warp_pitch = _proportioned(10 / recipe.ends_per_cm, draft.ends, draft.warp_pitch_mm)
    weft_pitch = _proportioned(10 / recipe.picks_per_cm, draft.picks, draft.weft_pitch_mm)
    laid: list[tuple[YarnSpec, Yarn]] = []
    warp_yarn = _resolve("warp", draft.warp_color, draft, recipe, warp_pitch, color_space, laid)
    weft_yarn = _resolve("weft", draft.weft_color, draft, recipe, weft_pitch, color_space, laid)
    if len(laid) > MAX_YARNS:
        raise RecipeError(f"the draft needs {len(laid)} yarns, at most {MAX_YARNS} are supported")
    yarns = tuple(yarn for _, yarn in laid)

    warp = _system(yarns, warp_yarn, warp_pitch, draft.warp_thickness_mm)
    weft = _system(yarns, weft_yarn, weft_pitch, draft.weft_thickness_mm)
    warp_floats = lay_floats(warp_up.T, warp, weft, recipe.crimp_balance)
    weft_floats = lay_floats(~warp_up, weft, warp, 1 - recipe.crimp_balance)
    cloth = Weave(
        warp_up=_frozen(warp_up),
        yarns=yarns,
        warp_yarn=_frozen(warp_yarn),
        weft_yarn=_frozen(weft_yarn),
        warp_edge_mm=_frozen(warp.edge_mm),
        weft_edge_mm=_frozen(weft.edge_mm),
        warp_width_mm=_frozen(warp.width_mm),
        weft_width_mm=_frozen(weft.width_mm),
        warp_height_mm=_frozen(warp.height_mm),
        weft_height_mm=_frozen(weft.height_mm),
        warp_floats=_frozen_floats(warp_floats, transpose=True),
        weft_floats=_frozen_floats(weft_floats, transpose=False),
        crimp_balance=recipe.crimp_balance,
        color_space=color_space,
    )
    return replace(cloth, warnings=departures(cloth, recipe, [spec for spec, _ in laid]))


def lie(spec: YarnSpec, pitch_mm: float) -> tuple[float, float]:
    """Return width and thickness in mm of a yarn in a cloth of the given pitch.

    The section is an ellipse of the area that the count gives; its flatness, width or thickness
    are the recipe's where it states them. A yarn is never wider than its pitch: one that would
    be is squeezed sideways and keeps its area, or its thickness where that is stated.
    """
    diameter = diameter_mm(spec.tex, spec.fibre, spec.packing)
    if spec.width_mm is not None:
        free = spec.width_mm
    elif spec.height_mm is not None:
        free = diameter**2 / spec.height_mm
    else:
        free = diameter / math.sqrt(1.0 if spec.flatness is None else spec.flatness)
    width = min(free, pitch_mm)
    if spec.height_mm is not None:
        return width, spec.height_mm
    if spec.width_mm is not None and spec.flatness is not None:
        return width, spec.flatness * free**2 / width
    return width, diameter**2 / width


def _resolve(
    system: model.System,
    colors: Indices,
    draft: Draft,
    recipe: Recipe,
    pitch_mm: Doubles,
    color_space: ColorSpace,
    laid: list[tuple[YarnSpec, Yarn]],
) -> Indices:
    """Append to `laid` one yarn for each palette entry used; return every thread's index in it."""
    used, of_thread = np.unique(colors, return_inverse=True)
    first = len(laid)
    for entry in used:
        spec = _spec_for(recipe, system, int(entry) + 1)
        r, g, b = draft.palette[entry]
        look = laid_colors(spec, (float(r), float(g), float(b)), color_space)
        name = f"{system}_{entry + 1}"
        laid.append((spec, _laid(spec, system, name, *look, float(pitch_mm.mean()))))
    return (of_thread.reshape(-1) + first).astype(np.int32)


def _spec_for(recipe: Recipe, system: model.System, entry: int) -> YarnSpec:
    fitting = [y for y in recipe.yarns if system in y.systems]
    for spec in fitting:
        if entry in spec.palette:
            return spec
    for spec in fitting:
        if not spec.palette:
            return spec
    raise RecipeError(f"recipe {recipe.name}: no yarn for {system} threads of color {entry}")


def _laid(
    spec: YarnSpec,
    system: model.System,
    name: str,
    color: model.RGB,
    irregularity: Irregularity,
    pitch_mm: float,
) -> Yarn:
    width, height = lie(spec, pitch_mm)
    diameter = diameter_mm(spec.tex, spec.fibre, spec.packing)
    return Yarn(
        name=name,
        system=system,
        fibre=spec.fibre,
        tex=spec.tex,
        plies=spec.plies,
        twist_per_m=spec.twist_per_m,
        twist_direction=spec.twist_direction,
        packing=spec.packing,
        width_mm=width,
        height_mm=height,
        twist_angle=twist_angle(spec.twist_per_m, spec.twist_direction, diameter)
        if spec.twist_angle is None
        else spec.twist_angle,
        twist_deviation=spec.twist_deviation,
        twist_correlation_mm=spec.twist_correlation_mm,
        spine=spec.spine,
        kappa=spec.kappa,
        color=color,
        optics=spec.optics,
        crimp=spec.crimp,
        u_max=spec.u_max,
        irregularity=irregularity,
    )


def _proportioned(mean: float, count: int, shape: Doubles | None) -> Doubles:
    """Return (count,) values of the given mean, in the proportions of `shape`."""
    if shape is None or not float(shape.mean()) > 0:
        return np.full(count, mean)
    return np.asarray(np.maximum(shape / shape.mean(), 0.05) * mean)


def _system(
    yarns: Sequence[Yarn], of_thread: Indices, pitch: Doubles, thickness: Doubles | None
) -> System:
    scale = _proportioned(1.0, len(pitch), thickness)
    width = np.array([y.width_mm for y in yarns])[of_thread] * scale
    height = np.array([y.height_mm for y in yarns])[of_thread] * scale
    end_bend = np.array([y.spine == "end-bend" for y in yarns])[of_thread]
    return System(
        edges(pitch),
        np.minimum(width, pitch),
        height,
        end_bend,
        _stated([y.crimp for y in yarns], of_thread),
        _stated([y.u_max for y in yarns], of_thread),
    )


def _stated(values: Sequence[float | None], of_thread: Indices) -> Doubles | None:
    """Return the value of each thread's yarn, NaN where it states none; None if all do."""
    if all(value is None for value in values):
        return None
    of_yarn = np.array([math.nan if value is None else value for value in values])
    return np.asarray(of_yarn[of_thread])


def _frozen(array: NDArray[T]) -> NDArray[T]:
    array = np.ascontiguousarray(array)
    array.setflags(write=False)
    return array


def _frozen_floats(floats: Floats, *, transpose: bool) -> Floats:
    return Floats(
        thread=_frozen(floats.thread),
        start=_frozen(floats.start),
        count=_frozen(floats.count),
        length_mm=_frozen(floats.length_mm),
        center_mm=_frozen(floats.center_mm),
        bend_mm=_frozen(floats.bend_mm),
        u_max=_frozen(floats.u_max),
        at=_frozen(floats.at.T if transpose else floats.at),
    )
