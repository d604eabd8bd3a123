"""What is proven: the yarns of presets, those that scatter alike taken together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.errors import InputError
from weaveusd.shading.microcylinder import Parameters
from weaveusd.shading.normalization import normalization
from weaveusd.yarn.recipe import preset_names, read_preset

if TYPE_CHECKING:
    from weaveusd.yarn.model import Optics


@dataclass(frozen=True, slots=True)
class Subject:
    """A way to scatter: its optics, and the yarns that do, as preset/yarn."""

    yarns: tuple[str, ...]
    optics: Optics

    @property
    def name(self) -> str:
        """Name of the first yarn, and how many others scatter alike."""
        others = len(self.yarns) - 1
        return self.yarns[0] + (f" and {others} alike" if others else "")

    def parameters(self, albedo: float, *, gaussian: bool = False) -> Parameters:
        """Return the parameters of the BSDF in a gray of that albedo; A has one channel."""
        o = self.optics
        gray = np.array([albedo])
        return Parameters(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v, o.tau, gray, gaussian)


def subjects(presets: Sequence[str] = ()) -> tuple[Subject, ...]:
    """Return how the yarns of `presets` scatter, by default of all, each way once.

    Raises
    ------
    RecipeError
        A name is no preset.
    """
    groups: dict[Optics, list[str]] = {}
    for name in dict.fromkeys(presets or preset_names()):
        for spec in read_preset(name).yarns:
            groups.setdefault(spec.optics, []).append(f"{name}/{spec.name}")
    return tuple(Subject(tuple(yarns), optics) for optics, yarns in groups.items())


def inclinations(degrees: Sequence[float]) -> tuple[float, ...]:
    """Return angles in radians from degrees; raises InputError beyond ±89.9°."""
    for angle in degrees:
        if not abs(angle) <= 89.9:
            raise InputError(f"angle: found {angle:g}°, expected -89.9° to 89.9°")
    return tuple(float(np.radians(angle)) for angle in degrees)


def shader_inputs(params: Parameters) -> dict[str, list[float]]:
    """Return the inputs of the exact shader for one yarn of these parameters."""
    n_v = normalization(
        params.eta, params.k_d, params.k_s, params.gamma_s, params.gamma_v, params.gaussian
    )
    return {
        "eta": [params.eta],
        "k_d": [params.k_d],
        "k_s": [params.k_s],
        "gamma_s": [params.gamma_s],
        "gamma_v": [params.gamma_v],
        "tau": [params.tau],
        "normalization": [n_v],
    }
