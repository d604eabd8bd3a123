"""Display colors to reflectance."""

from __future__ import annotations

from weaveusd.yarn.model import RGB


def linear_from_srgb(color: RGB) -> RGB:
    """Return linear Rec.709 components of display sRGB ones, 0…1 (IEC 61966-2-1)."""
    r, g, b = (v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in color)
    return r, g, b
