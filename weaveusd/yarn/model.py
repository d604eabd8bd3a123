"""Yarn and Recipe: what the threads of a cloth are made of, and how close they lie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

System = Literal["warp", "weft"]
Spine = Literal["circle", "conic", "end-bend"]
Twist = Literal["S", "Z"]
RGB = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Optics:
    """Parameters of the microcylinder BSDF (Sadeghi et al. 2013); angles in radians."""

    eta: float
    k_d: float
    k_s: float
    gamma_s: float
    gamma_v: float
    tau: float


@dataclass(frozen=True, slots=True)
class Yarn:
    """A yarn as it lies in the cloth. Lengths in mm, angles in radians.

    `twist_angle` is that of the fibres on the yarn's surface to its axis, positive for S.
    `height_mm` is the thickness out of the cloth's plane. `color` is an albedo in linear
    Rec.709.
    """

    name: str
    system: System
    fibre: str
    tex: float
    plies: int
    twist_per_m: float
    twist_direction: Twist
    packing: float
    width_mm: float
    height_mm: float
    twist_angle: float
    twist_deviation: float
    twist_correlation_mm: float
    spine: Spine
    kappa: float
    color: RGB
    optics: Optics


@dataclass(frozen=True, slots=True)
class YarnSpec:
    """A yarn as a recipe states it, before it meets a draft and a sett.

    `palette` lists the palette entries, counted from 1, that the yarn serves; empty means all.
    `color` is display sRGB, or None to take the draft's. `width_mm` and `flatness` (height over
    width) are None where they follow from the count and the sett.
    """

    name: str
    systems: tuple[System, ...]
    palette: tuple[int, ...]
    fibre: str
    tex: float
    plies: int
    twist_per_m: float
    twist_direction: Twist
    packing: float
    width_mm: float | None
    flatness: float | None
    twist_deviation: float
    twist_correlation_mm: float
    spine: Spine
    kappa: float
    color: RGB | None
    optics: Optics


@dataclass(frozen=True, slots=True)
class Recipe:
    """The yarns of a cloth and their sett.

    `crimp_balance` is the share of the crimp height that the warp takes, 0…1. `kind` is `yarn`
    for a recipe that suits any draft and `fabric` for one that belongs to a weave. `source`
    says where the numbers come from and `certainty` how far to trust them.
    """

    name: str
    title: str
    kind: Literal["yarn", "fabric"]
    source: str
    certainty: str
    ends_per_cm: float
    picks_per_cm: float
    crimp_balance: float
    yarns: tuple[YarnSpec, ...]
