"""Yarn and Recipe: what the threads of a cloth are made of, and how close they lie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from weaveusd.yarn.irregularity import REGULAR, Irregularity

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

    `tex` is the linear density of the whole yarn, all plies. `twist_angle` is that of the fibres
    on the yarn's surface to its axis, positive for S. `height_mm` is the thickness out of the
    cloth's plane. `color`, like the colors in `irregularity`, is an albedo in the color space of
    the cloth. `crimp` (arc length over chord, less one) and `u_max` (inclination at the ends of
    floats) are None where they follow from the threads that touch; a stated `u_max` shapes the
    yarn even where a `crimp` is stated too.
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
    crimp: float | None = None
    u_max: float | None = None
    irregularity: Irregularity = REGULAR


@dataclass(frozen=True, slots=True)
class OutsideColor:
    """A color outside Rec.709: file, line, key and what they state; linear Rec.709, unclipped."""

    stated: str
    linear: RGB


@dataclass(frozen=True, slots=True)
class YarnSpec:
    """A yarn as a recipe states it, before it meets a draft and a sett.

    `palette` lists the palette entries, counted from 1, that the yarn serves; empty means all.
    `tex` is the linear density of the whole yarn and `count` what the recipe said of it.
    `color` is display sRGB, or None to take the draft's; `color_stated` is how the recipe stated
    it; of a mélange or mouliné it is the mean of the colors in `irregularity`. A color outside
    Rec.709 has components outside 0…1, since only a cloth knows its color space;
    `colors_outside` lists them. `width_mm`, `height_mm`, `flatness` (height over width),
    `twist_angle` (radians, positive for S), `crimp` and `u_max` (radians) are None where they
    follow from the count, the twist, the weave and the sett.
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
    count: str = ""
    height_mm: float | None = None
    twist_angle: float | None = None
    crimp: float | None = None
    u_max: float | None = None
    color_stated: str = "draft"
    colors_outside: tuple[OutsideColor, ...] = ()
    irregularity: Irregularity = REGULAR


@dataclass(frozen=True, slots=True)
class Recipe:
    """The yarns of a cloth and their sett.

    `crimp_balance` is the share of the crimp height that the warp takes, 0…1. `kind` is `yarn`
    for a recipe that suits any draft and `fabric` for one that belongs to a weave. `source`
    says where the numbers come from and `certainty` how far to trust them. For a fabric,
    `weave` is the notation of its weave, as `weaveusd.draft.make` reads it, and `finish` what was
    done to it after the loom; both describe, and nothing is computed from them. `weight_g_m2` is
    the weight that its source gives; a cloth that comes out otherwise is reported.
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
    weave: str = ""
    finish: str = ""
    weight_g_m2: float | None = None
