"""Yarn colors as recipes state them: the draft's, display sRGB, CIE Lab, or a spectrum."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, cast

from weaveusd.yarn.model import RGB, OutsideColor
from weaveusd.yarn.spectrum import read_reflectance
from weaveusd.yarn.toml import shown

if TYPE_CHECKING:
    from weaveusd.yarn.toml import Table

ILLUMINANTS = ("D50", "D65")
_HEX = re.compile(r"#[0-9a-fA-F]{6}")


@dataclass(frozen=True, slots=True)
class YarnColor:
    """A color: display sRGB, None for the draft's; how it was stated; where outside Rec.709.

    Components of a color in `outside`, and of no other, may leave 0…1.
    """

    srgb: RGB | None
    stated: str
    outside: tuple[OutsideColor, ...] = ()


def read_color(table: Table, folder: Path) -> YarnColor:
    """Return the `color` of a yarn's table; files that it names are in `folder`.

    ``"draft"`` (or nothing), ``"#rrggbb"``, ``{ lab = [L, a, b], illuminant = "D50" }`` or
    ``{ reflectance = "file.csv" }``. A color outside Rec.709 is not clipped. Raises RecipeError.
    """
    value = table.take("color", "draft")
    if isinstance(value, dict):
        return _measured(table, folder)
    if value == "draft":
        return YarnColor(None, "draft")
    if not isinstance(value, str) or not _HEX.fullmatch(value):
        expected = '"draft", "#rrggbb", { lab = …, illuminant = … } or { reflectance = … }'
        raise table.error("color", f"found {shown(value)}, expected {expected}")
    return YarnColor(srgb_from_hex(value), value)


def _measured(table: Table, folder: Path) -> YarnColor:
    from weaveusd.yarn import colorimetry

    color = table.table("color")
    if color.one_of("lab", "reflectance") == "lab":
        lab = _lab(color)
        illuminant = color.text("illuminant", choices=ILLUMINANTS)
        stated = f"Lab {lab[0]:g} {lab[1]:g} {lab[2]:g} {illuminant}"
        asked = colorimetry.linear_from_lab(lab, illuminant)
    else:
        name = color.text("reflectance")
        stated = f"reflectance {name}"
        asked = colorimetry.linear_from_reflectance(
            *read_reflectance(folder, name, color.place("reflectance"))
        )
    color.close()
    # Rounded, so that the last bit of a machine's mathematics never reaches a file.
    srgb = cast("RGB", tuple(round(v, 9) for v in srgb_from_linear(asked)))
    inside = all(0 <= v <= 1 for v in srgb)
    outside = () if inside else (OutsideColor(f"{table.place('color')}: {stated}", asked),)
    return YarnColor(srgb, stated, outside)


def _lab(color: Table) -> tuple[float, float, float]:
    value = color.take("lab")
    if (
        not isinstance(value, list)
        or len(value) != 3
        or any(isinstance(v, bool) or not isinstance(v, (int, float)) for v in value)
        or not (0 <= value[0] <= 100 and all(-150 <= v <= 150 for v in value[1:]))
    ):
        expected = "[L, a, b] with L 0 to 100, a and b -150 to 150"
        raise color.error("lab", f"found {shown(value)}, expected {expected}")
    lightness, a, b = value
    return float(lightness), float(a), float(b)


def srgb_from_hex(text: str) -> RGB:
    """Return the components 0…1 of a ``#rrggbb``."""
    r, g, b = (int(text[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return r, g, b


def decode_srgb(value: float) -> float:
    """Return the linear value of one display sRGB component (IEC 61966-2-1)."""
    linear: float = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
    return linear


def linear_from_srgb(color: RGB) -> RGB:
    """Return linear Rec.709 components of display sRGB ones (IEC 61966-2-1).

    Beyond 0…1 either end of the curve goes on, so that `srgb_from_linear` is the inverse.
    """
    r, g, b = (decode_srgb(v) for v in color)
    return r, g, b


def srgb_from_linear(color: RGB) -> RGB:
    """Return display sRGB components of linear Rec.709 ones, the inverse of `linear_from_srgb`."""
    r, g, b = (12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055 for v in color)
    return r, g, b
