"""What follows from a yarn's count: diameter and twist angle."""

from __future__ import annotations

import math

FIBRE_DENSITY = {
    "cotton": 1.52,
    "linen": 1.50,
    "wool": 1.31,
    "silk": 1.34,
    "polyester": 1.39,
    "nylon": 1.14,
    "viscose": 1.52,
}
"""Density of the fibre in g/cm³ (common tables; Morton & Hearle, recalled)."""


def diameter_mm(tex: float, fibre: str, packing: float) -> float:
    """Return the diameter of a round yarn, d = √(4 tex / (1000 π ρ φ)), in mm.

    `tex` in g/km, `packing` the share φ of fibre in the section, ρ the fibre's density in
    g/cm³ from `FIBRE_DENSITY`. With ρφ = 0.91 this is Peirce's 1 in / (28 √Ne).
    """
    return math.sqrt(4 * tex / (1000 * math.pi * FIBRE_DENSITY[fibre] * packing))


def twist_angle(twist_per_m: float, direction: str, diameter: float) -> float:
    """Return the angle of the outermost fibres to the yarn's axis, positive for S, in radians.

    tan α = π d T, with `diameter` d in mm and the twist T in turns a metre.
    """
    angle = math.atan(math.pi * diameter * twist_per_m / 1000)
    return angle if direction == "S" else -angle
