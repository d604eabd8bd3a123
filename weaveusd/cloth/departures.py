"""Where a cloth is not what its recipe states: what could not be had, and said, not hidden."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.cloth.colors import clipped_colors
from weaveusd.cloth.measures import areal_density_g_m2

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.yarn.model import Recipe, YarnSpec

WEIGHT_TOLERANCE = 0.15
"""Share by which the computed weight may leave the one that a recipe states."""


def departures(weave: Weave, recipe: Recipe, specs: Sequence[YarnSpec]) -> tuple[str, ...]:
    """Return one line for each statement of `recipe` that `weave` does not keep.

    `specs` are what the recipe states of each of `weave.yarns`. Reported are colors outside
    the cloth's color space, yarns narrowed to their pitch, inclinations beyond what a yarn of
    that thickness reaches, and a weight that is off by more than `WEIGHT_TOLERANCE`.
    """
    found = [
        *clipped_colors(specs, weave.color_space),
        *_narrowed(weave, recipe, specs),
        *_flattened(weave, recipe, specs),
        *_weight(weave, recipe),
    ]
    return tuple(dict.fromkeys(found))


def _narrowed(weave: Weave, recipe: Recipe, specs: Sequence[YarnSpec]) -> Iterator[str]:
    for spec, yarn in zip(specs, weave.yarns, strict=True):
        if spec.width_mm is not None and yarn.width_mm < spec.width_mm:
            yield (
                f"recipe {recipe.name}: yarn {spec.name}: stated {spec.width_mm:g} mm wide, but "
                f"{yarn.system} threads lie {yarn.width_mm:.3g} mm apart; narrowed to that"
            )


def _flattened(weave: Weave, recipe: Recipe, specs: Sequence[YarnSpec]) -> Iterator[str]:
    systems = (
        ("warp", weave.warp_floats, weave.warp_yarn),
        ("weft", weave.weft_floats, weave.weft_yarn),
    )
    for system, floats, yarn_of_thread in systems:
        for index, spec in enumerate(specs):
            bent = (yarn_of_thread[floats.thread] == index) & (floats.u_max > 0)
            if spec.u_max is None or not bent.any():
                continue
            least = float(np.min(floats.u_max[bent]))
            if least < spec.u_max - 1e-6:
                yield (
                    f"recipe {recipe.name}: yarn {spec.name}: stated u_max "
                    f"{math.degrees(spec.u_max):.3g}°, but floats of its thickness in the "
                    f"{system} turn no further than {math.degrees(least):.3g}°"
                )


def _weight(weave: Weave, recipe: Recipe) -> Iterator[str]:
    if (stated := recipe.weight_g_m2) is None:
        return
    computed = areal_density_g_m2(weave)
    if abs(computed / stated - 1) > WEIGHT_TOLERANCE:
        yield (
            f"recipe {recipe.name}: stated {stated:g} g/m², but its yarns, sett and crimp give "
            f"{computed:.3g}"
        )
