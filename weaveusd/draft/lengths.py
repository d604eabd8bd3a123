"""Pitch and thickness of the threads of a WIF, in millimetres."""

from __future__ import annotations

from decimal import Context, Decimal
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.draft.loom import Loom
from weaveusd.draft.model import LENGTH_LIMITS_MM
from weaveusd.draft.rows import Rows
from weaveusd.draft.text import quoted

if TYPE_CHECKING:
    from weaveusd.draft.model import Doubles

_INCH = Decimal("25.4")
_UNITS_MM: dict[str, Decimal] = {
    **dict.fromkeys(("decipoints", "decipoint"), _INCH / 720),
    **dict.fromkeys(("inches", "inch", "in"), _INCH),
    **dict.fromkeys(("centimeters", "centimeter", "centimetres", "centimetre", "cm"), Decimal(10)),
    **dict.fromkeys(
        ("millimeters", "millimeter", "millimetres", "millimetre", "mm"), Decimal(1)
    ),
}  # fmt: skip
_PLACEHOLDER_CM = (Decimal("0.0185"), Decimal("0.0213"))
PLACEHOLDER_MM = (0.185, 0.213)
"""Pitch and thickness that Handweaving.net writes into every draft, whatever the cloth."""

_EXACT = Context(prec=100)  # decimal to decimal: what was written comes back to the last bit


def read_lengths(rows: Rows, loom: Loom) -> dict[str, Doubles | None]:
    """Return the pitch and thickness of ends and picks: fields of a Draft, None if unstated.

    Spacing is the pitch, center to center. The zooms of the standard magnify threads on the
    screen; they are no lengths, and ignored.
    """
    lengths: dict[str, Doubles | None] = {}
    for system, prefix, count in (("WARP", "warp", loom.ends), ("WEFT", "weft", loom.picks)):
        lengths[f"{prefix}_pitch_mm"] = None
        lengths[f"{prefix}_thickness_mm"] = None
        _note_zoom(rows, system)
        pitch = _Stated(rows, loom, system, "Spacing", count)
        thickness = _Stated(rows, loom, system, "Thickness", count)
        unit = _unit(rows, system, pitch, thickness)
        if unit is not None:
            lengths[f"{prefix}_pitch_mm"] = pitch.in_mm(unit)
            lengths[f"{prefix}_thickness_mm"] = thickness.in_mm(unit)
    return lengths


class _Stated:
    """What a file says of one length of one system: of all threads, and of single ones."""

    def __init__(self, rows: Rows, loom: Loom, system: str, key: str, count: int) -> None:
        self._rows, self._system, self._key, self._count = rows, system, key, count
        row = rows.value(system, key)
        self.line = row[0] if row else 0
        self.default = rows.real(system, row, key) if row else None
        if self.default == 0:
            rows.warn(self.line, system, f"{key} is 0 and taken as not stated")
            self.default = None
        self.single = self._singles(loom)

    def _singles(self, loom: Loom) -> dict[int, Decimal]:
        name = f"{self._system} {self._key.upper()}"
        first = loom.numbering.first_row(name, self._count)
        single = {}
        zeros = beyond = 0
        for number, row in self._rows.keyed(name).items():
            if not row[1]:
                continue
            value = self._rows.real(name, row, f"row {number}")
            if not 0 <= number - first < self._count:
                beyond += 1
            elif value == 0:
                zeros += 1
            else:
                single[number - first] = value
        if zeros:
            self._rows.warn(0, name, f"{zeros} rows are 0 and taken as not stated")
        if beyond:
            self._rows.warn(0, name, f"{beyond} rows are beyond the {self._count} threads; ignored")
        return single

    def smallest(self) -> Decimal | None:
        """Return the least value stated, None where there is none."""
        values = list(self.single.values())
        if self.default is not None:
            values.append(self.default)
        return min(values, default=None)

    def in_mm(self, unit: Decimal) -> Doubles | None:
        """Return the length of each thread in mm; None where nothing plausible is stated."""
        if self.smallest() is None:
            return None
        default = self.default
        if default is None:
            default = sorted(self.single.values())[len(self.single) // 2]
            if len(self.single) < self._count:
                self._warn(f"is stated for some threads only; the others get {default}")
        lengths = np.full(self._count, float(_EXACT.multiply(default, unit)))
        for thread, value in self.single.items():
            lengths[thread] = float(_EXACT.multiply(value, unit))
        low, high = LENGTH_LIMITS_MM
        if lengths.min() < low or lengths.max() > high:
            self._warn(f"leaves {low} to {high} mm; taken as not stated")
            return None
        return lengths

    def _warn(self, message: str) -> None:
        self._rows.warn(self.line, self._system, f"{self._key} {message}")


def _unit(rows: Rows, system: str, pitch: _Stated, thickness: _Stated) -> Decimal | None:
    """Return the millimetres in a unit; None when no length holds."""
    values = [value for s in (pitch, thickness) if (value := s.smallest()) is not None]
    if not values:
        return None
    row = rows.value(system, "Units")
    if row is None:
        other = "WEFT" if system == "WARP" else "WARP"
        row = rows.value(other, "Units")
        if row is None:
            rows.warn(0, system, "states lengths without Units; taken as not stated")
            return None
        rows.warn(0, system, f"states lengths without Units; those of [{other}] are taken")
    line, text = row
    name = " ".join(text.lower().split())
    unit = _UNITS_MM.get(name)
    if unit is None:
        rows.warn(line, system, f"Units are {quoted(text)}; its lengths are taken as not stated")
        return None
    if name.startswith("decipoint") and min(values) < 1:
        rows.warn(line, system, "a length below one decipoint; read as inches, as WeaveIt writes")
        return _INCH
    if (
        unit == 10
        and (pitch.default, thickness.default) == _PLACEHOLDER_CM
        and not (pitch.single or thickness.single)
    ):
        rows.warn(
            pitch.line, system, "Spacing and Thickness are Handweaving.net's placeholder; "
            "taken as not stated",
        )  # fmt: skip
        return None
    return unit


def _note_zoom(rows: Rows, system: str) -> None:
    for key in ("Spacing Zoom", "Thickness Zoom"):
        row = rows.value(system, key)
        if row is not None:
            rows.real(system, row, key)
            rows.warn(row[0], system, f"{key} is for the screen; ignored")
        if (section := rows.section(f"{system} {key.upper()}")) is not None:
            rows.warn(section.line, section.name, "is for the screen; ignored")
