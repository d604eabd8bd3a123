"""Moment maps: what the yarns under a texel are like on average, and how much they differ.

Warp and weft are apart, since the mean of both directions is one that no fibre has. A texel of a
texture shows one point of a yarn, which three numbers tell, in that yarn's frame (physics.md C)::

    S = sin u (1 + k cos v) / (1 + k)      place along the float, −1…1; u inclination, v section
    X = sin v                              place across the yarn, −1…1
    P = sin ψ                              twist of the fibre

k is thickness over bend, b/R₀. On a circular bend S is a multiple of the place along the yarn and X
one of the place across, so that a piece of a yarn is a box in (S, X), which means and variances
tell exactly. All channels are linear in the texels: a plain mip map of them is one of larger
footprints. Only sums, products, quotients and square roots are used, so that bits are the same
everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.synth.boxes import add_rows, columns_reduced, reduced

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.cloth.model import Floats, Weave
    from weaveusd.synth.model import Band, TextureSet
    from weaveusd.yarn.model import Optics

    Doubles = NDArray[np.float64]
    Floats32 = NDArray[np.float32]

(
    FLAT,  # a where |S| ≤ STRAIGHT
    RISING, FALLING,  # a where S is positive, where it is negative
    ACROSS,  # a X
    RISING_S, RISING_SS, FALLING_S, FALLING_SS,  # a S and a S² of both
    ASIDE,  # a |X|
    ACROSS_XX,  # a X²
    TWIST, TWIST_PP,  # a P and a P²
) = range(12)  # fmt: skip
MOMENTS = 12
"""Channels of a system's moments; a is the opacity of the system's yarn in the texel."""

STRAIGHT = 1e-3
"""|S| below which a yarn is straight: the middle of a long float is a class of its own."""

BAND_TEXELS = 2**17
"""Texels of the textures that are in memory at once."""


@dataclass(frozen=True, slots=True)
class Section:
    """The shape of a system's yarns, in which its moments are written.

    Any numbers describe a single texel exactly; with the yarns' own means a float is a box.
    """

    flatness: float  # b/a, thickness over width
    curvature: float  # k = b/R₀


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """What of one system lies under a piece of cloth, such as a texel of a mip map."""

    weft: bool
    section: Section
    moments: Floats32  # (12,) in the order of this module's names
    albedo: Floats32  # (3,) a A, the opacity times the fibre's albedo
    share: Floats32  # (kinds,) opacity of the yarns of each kind
    kinds: tuple[Optics, ...]


@dataclass(frozen=True, slots=True, eq=False)
class MomentMaps:
    """Moment maps of one system: row 0 at y = 0, column 0 at x = 0. Arrays are read-only.

    `kinds` are the optics of the system's yarns without repetition. Where there is but one,
    `share` is the system's opacity, which FLAT + RISING + FALLING is as well.
    """

    weft: bool
    section: Section
    moments: Floats32  # (h, w, 12)
    albedo: Floats32  # (h, w, 3)
    share: Floats32  # (h, w, kinds)
    kinds: tuple[Optics, ...]

    def footprint(self, row: int, column: int) -> Footprint:
        """Return one texel."""
        at = row, column
        return Footprint(
            self.weft, self.section, self.moments[at], self.albedo[at], self.share[at], self.kinds
        )

    def reduced(self, width: int, height: int) -> MomentMaps:
        """Return maps of `width` × `height` texels, no more than there are, by box filtering."""
        maps = self.moments, self.albedo, self.share
        moments, albedo, share = (_frozen(reduced(m, width, height)) for m in maps)
        return replace(self, moments=moments, albedo=albedo, share=share)

    def levels(self) -> Iterator[MomentMaps]:
        """Yield these maps and each half of the last, down to a single texel."""
        maps = self
        yield maps
        while maps.share.shape[:2] != (1, 1):
            height, width = maps.share.shape[:2]
            maps = maps.reduced(max(1, width // 2), max(1, height // 2))
            yield maps


def moment_maps(
    weave: Weave,
    textures: TextureSet,
    *,
    width: int,
    height: int,
    gains: Sequence[float] | None = None,
) -> tuple[MomentMaps, MomentMaps]:
    """Return the moment maps of warp and weft, each texel the mean of the textures under it.

    Maps as large as `textures` have no variance. `textures` are those of `weave`, read in bands;
    `gains` are the factors from base color to A for each of `weave.yarns`, by default 1. Raises
    ValueError unless the maps have at least one texel and no more than the textures either way.
    """
    if not (1 <= width <= textures.width and 1 <= height <= textures.height):
        raise ValueError(
            f"{width} × {height} texels, expected 1 × 1 to {textures.width} × {textures.height}"
        )
    gain = np.ones(len(weave.yarns)) if gains is None else np.asarray(gains, float)
    systems = [_System(weave, weft, section) for weft, section in enumerate(sections(weave))]
    sums = [np.zeros((height, width, system.channels)) for system in systems]
    rows = max(1, BAND_TEXELS // textures.width)
    for first in range(0, textures.height, rows):
        band = textures.band(first, min(textures.height, first + rows))
        for system, total in zip(systems, sums, strict=True):
            fine = columns_reduced(system.channels_of(band, gain), width)
            add_rows(total, fine, first, textures.height)
    warp, weft = (system.maps(total) for system, total in zip(systems, sums, strict=True))
    return warp, weft


def sections(weave: Weave) -> tuple[Section, Section]:
    """Return flatness and curvature of warp and weft: means over threads and over crossings."""
    return (
        _section(weave.warp_floats, weave.warp_height_mm, weave.warp_width_mm),
        _section(weave.weft_floats, weave.weft_height_mm, weave.weft_width_mm),
    )


def texel_moments(band: Band, section: Section, *, weft: bool) -> Doubles:
    """Return the moments (rows, width, 12) of single texels, 0 where the other system is.

    `band` holds `normal`, `tangent`, `opacity` and `system`. The yarn's frame is found back from
    the normal, n ∝ (ρ sin v, sin u cos v, cos u cos v) with ρ = b/a, and the fibre,
    t = cos ψ T − sin ψ T_v (physics.md C), turned so that ψ lies within ±90°.
    """
    n_x, n_y, n_z = _in_yarn_frame(band["normal"], weft)
    t_x, t_y, t_z = _in_yarn_frame(band["tangent"], weft)
    up = np.sqrt(n_y * n_y + n_z * n_z)
    scale = 1 / np.maximum(up, 1e-12)
    sin_u, cos_u = n_y * scale, n_z * scale
    flat = section.flatness * up
    x = n_x / np.sqrt(n_x * n_x + flat * flat)
    k = section.curvature
    s = sin_u * (1 + k * np.sqrt(np.maximum(1 - x * x, 0))) / (1 + k)
    forward = np.where(t_y * cos_u - t_z * sin_u < 0, -1.0, 1.0)
    p = -forward * (t_x * up - n_x * (t_y * sin_u + t_z * cos_u))

    a = np.where(band["system"][..., 0] == float(weft), band["opacity"][..., 0], 0).astype(float)
    rising, falling = a * (s > STRAIGHT), a * (s < -STRAIGHT)
    out = np.empty((*a.shape, MOMENTS))
    out[..., RISING], out[..., FALLING] = rising, falling
    out[..., FLAT] = a - rising - falling
    out[..., RISING_S], out[..., RISING_SS] = rising * s, rising * s * s
    out[..., FALLING_S], out[..., FALLING_SS] = falling * s, falling * s * s
    out[..., ACROSS], out[..., ASIDE], out[..., ACROSS_XX] = a * x, a * np.abs(x), a * x * x
    out[..., TWIST], out[..., TWIST_PP] = a * p, a * p * p
    return out


class _System:
    """Which channels a system has, and how texels become them."""

    def __init__(self, weave: Weave, weft: int, section: Section) -> None:
        self.weft, self.section = bool(weft), section
        system = "weft" if weft else "warp"
        optics = [yarn.optics for yarn in weave.yarns]
        own = (yarn.optics for yarn in weave.yarns if yarn.system == system)
        self.kinds = tuple(dict.fromkeys(own))
        kind = {o: k for k, o in enumerate(self.kinds)}
        self.kind_of_yarn = np.array([kind.get(o, -1) for o in optics])

    @property
    def channels(self) -> int:
        return MOMENTS + 3 + len(self.kinds)

    def channels_of(self, band: Band, gain: Doubles) -> Doubles:
        """Return moments, albedo and shares (rows, width, channels), side by side."""
        yarn = np.maximum(band["yarn_id"][..., 0], 0).astype(np.intp)
        moments = texel_moments(band, self.section, weft=self.weft)
        a = moments[..., FLAT] + moments[..., RISING] + moments[..., FALLING]
        albedo = band["base_color"].astype(float) * (a * gain[yarn])[..., None]
        share = a[..., None] * (self.kind_of_yarn[yarn][..., None] == np.arange(len(self.kinds)))
        return np.concatenate([moments, albedo, share], -1)

    def maps(self, channels: Doubles) -> MomentMaps:
        """Return channels (h, w, c) as maps."""
        moments, albedo, share = np.split(channels, [MOMENTS, MOMENTS + 3], -1)
        return MomentMaps(
            self.weft, self.section, _frozen(moments), _frozen(albedo), _frozen(share), self.kinds
        )


def _section(floats: Floats, height_mm: Doubles, width_mm: Doubles) -> Section:
    # Imported here: numba takes half a second that nobody else should pay.
    from weaveusd.synth.noise import settled
    from weaveusd.synth.spine import circle_radius

    bent = floats.u_max > 0
    half = 0.5 * height_mm[floats.thread[bent]]
    radius = circle_radius(floats.bend_mm[bent], settled(floats.u_max[bent]), half)
    count = floats.count[bent]
    weighed = math.fsum(count * half / radius) / int(count.sum()) if bent.any() else 0.0
    return Section(math.fsum(height_mm / width_mm) / len(width_mm), weighed)


def _in_yarn_frame(vectors: Floats32, weft: bool) -> tuple[Doubles, Doubles, Doubles]:
    """Return components across the yarn, along it and out of the cloth."""
    x, y, z = (vectors[..., i].astype(float) for i in range(3))
    return (-y, x, z) if weft else (x, y, z)


def _frozen(values: Doubles) -> Floats32:
    out = values.astype(np.float32)
    out.flags.writeable = False
    return out
