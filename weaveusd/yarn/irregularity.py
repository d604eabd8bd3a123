"""How far a yarn strays from its mean, and over what length it comes back."""

from __future__ import annotations

from dataclasses import dataclass

RGB = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Irregularity:
    """Standard deviations of a yarn's properties and the lengths over which they hold, in mm.

    `thickness` is relative (slub, thick and thin places), `bend` relative from float to float,
    `color` in ΔE of CIE Lab (lightness, between threads and along them). `hairiness`, 0…1, is
    how much of the light beside a yarn its loose fibres catch. `melange` lists the colors
    of fibres that are mixed before spinning, with their shares; `strands` the colors of the
    plies of a mouliné, one a ply. They are linear: in a recipe Rec.709, not clipped, in a cloth
    its color space. Both are empty for a yarn of one color.
    """

    thickness: float = 0.0
    thickness_correlation_mm: float = 10.0
    bend: float = 0.0
    color: float = 0.0
    color_correlation_mm: float = 20.0
    hairiness: float = 0.0
    melange: tuple[tuple[RGB, float], ...] = ()
    strands: tuple[RGB, ...] = ()


REGULAR = Irregularity()
"""A yarn that is the same everywhere."""
