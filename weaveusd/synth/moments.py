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

from weaveusd.contract import MAX_MOMENT_TEXELS, MOMENT_TEXELS_A_THREAD
from weaveusd.synth.boxes import reduced

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.cloth.model import Floats, Weave
    from weaveusd.synth.model import TextureSet
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

ALBEDO = MOMENTS
SHARE = ALBEDO + 3
"""Where a A and the opacity of the first kind stand in a row of sums, behind the moments."""

TEXTURES = ("normal", "tangent", "opacity", "system", "yarn_id", "base_color")
"""Channels of the textures that the maps are made from."""

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

    `kinds` are those of `synth.kinds`. Where there is but one, `share` is the system's opacity,
    which FLAT + RISING + FALLING is as well.
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
    the rest is as of `moment_sums.MomentSums`, whose bits these are.
    """
    # Imported here: numba takes half a second that nobody else should pay.
    from weaveusd.synth.moment_sums import MomentSums

    size = textures.width, textures.height
    sums = MomentSums(weave, size, width=width, height=height, gains=gains)
    rows = max(1, BAND_TEXELS // textures.width)
    for last in range(textures.height, 0, -rows):
        band = textures.band(max(0, last - rows), last)
        sums.add({name: band[name][::-1] for name in TEXTURES})
    return sums.maps()


def map_size(weave: Weave, texture_size: tuple[int, int]) -> tuple[int, int]:
    """Return width and height of the maps that are published beside textures of `texture_size`.

    They have `MOMENT_TEXELS_A_THREAD` texels a thread, but no more than the textures, either way;
    both sides are halved until there are at most `MAX_MOMENT_TEXELS`.
    """
    across, along = texture_size
    width = min(across, MOMENT_TEXELS_A_THREAD * weave.ends)
    height = min(along, MOMENT_TEXELS_A_THREAD * weave.picks)
    while width * height > MAX_MOMENT_TEXELS:
        width, height = max(1, width // 2), max(1, height // 2)
    return width, height


def sections(weave: Weave) -> tuple[Section, Section]:
    """Return flatness and curvature of warp and weft: means over threads and over crossings."""
    return (
        _section(weave.warp_floats, weave.warp_height_mm, weave.warp_width_mm),
        _section(weave.weft_floats, weave.weft_height_mm, weave.weft_width_mm),
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
    flatness = math.fsum(height_mm / width_mm) / len(width_mm)
    return Section(float(settled(flatness)), float(settled(weighed)))


def _frozen(values: Doubles) -> Floats32:
    out = values.astype(np.float32)
    out.flags.writeable = False
    return out
