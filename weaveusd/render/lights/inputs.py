"""What a light of USD says about itself, read so that no value from outside can do harm."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Sdf, Usd, UsdLux

from weaveusd.render.color import known, linear
from weaveusd.render.model import Losses

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

BRIGHTEST = 1e30
"""Radiance beyond which single precision has no room left for a sum."""


class Refused(Exception):  # noqa: N818 - it is caught where it becomes a loss
    """A light that cannot be shown; the message is what the loss says."""


@dataclass(frozen=True, slots=True)
class Inputs:
    """Reads the inputs of one light at one time.

    A name without `inputs:`, as USD wrote it before version 21.02, is read where the light has
    no other opinion, and a loss says so. `files` keeps what was read for the lights of a stage.
    """

    prim: Usd.Prim
    time: Usd.TimeCode
    losses: Losses
    files: dict[Any, Any] = field(default_factory=dict)

    def value(self, name: str, fallback: Any) -> Any:
        """Return the value of `inputs:name`, else `fallback`."""
        attribute = self.prim.GetAttribute(f"inputs:{name}")
        if attribute and attribute.HasAuthoredConnections():
            self.losses.dropped(self.prim, f"network that feeds inputs:{name}")
        if not (attribute and attribute.HasAuthoredValue()):
            old = self.prim.GetAttribute(name)
            if old and old.HasAuthoredValue():
                self.losses.approximated(self.prim, f"{name} is read as inputs:{name}")
                attribute = old
        value = attribute.Get(self.time) if attribute else None
        return fallback if value is None else value

    def number(self, name: str, fallback: float) -> float:
        """Return a finite number.

        Raises
        ------
        Refused
            When the stage gives none.
        """
        value = self.value(name, fallback)
        try:
            number = float(value)
        except (TypeError, ValueError):
            raise Refused(f"{name} is {_brief(value)}, expected a number") from None
        if not math.isfinite(number):
            raise Refused(f"{name} is {number}, expected a finite number")
        return number

    def extent(self, name: str, fallback: float) -> float:
        """Return a length, 0 or more, or raise `Refused`."""
        length = self.number(name, fallback)
        if length < 0:
            raise Refused(f"{name} is {length:g}, expected 0 or more")
        return length

    def flag(self, name: str) -> bool:
        """Return a truth value, false where the stage says nothing."""
        return bool(self.value(name, False))

    def color(self, name: str, fallback: tuple[float, float, float]) -> Doubles:
        """Return a finite color in linear Rec.709, or raise `Refused`."""
        value = self.value(name, fallback)
        try:
            color = np.asarray(value, np.float64).reshape(3)
        except (TypeError, ValueError):
            raise Refused(f"{name} is {_brief(value)}, expected a color") from None
        if not np.isfinite(color).all():
            raise Refused(f"{name} is {_brief(value)}, expected finite numbers")
        space = self.color_space(name)
        if not space:
            return color
        inside = np.asarray(linear(color.astype(np.float32), space), np.float64)
        if inside.min() < 0 <= color.min():
            self.losses.approximated(self.prim, f"{name} beyond Rec.709 is clipped")
            inside = np.maximum(inside, 0)
        return inside

    def color_space(self, name: str) -> str:
        """Return the color space that the stage states for an input, empty where it is unknown.

        A color without one has that of the prims above it, a file its own alone.
        """
        attribute = self.prim.GetAttribute(f"inputs:{name}")
        space = str(attribute.GetColorSpace()) if attribute else ""
        if attribute and not space and attribute.GetTypeName() != Sdf.ValueTypeNames.Asset:
            space = str(Usd.ColorSpaceAPI.ComputeColorSpaceName(attribute, None))
        if not known(space):
            self.losses.approximated(self.prim, f"color space {space} of {name} is unknown")
            return ""
        return space


def emission(inputs: Inputs) -> Doubles:
    """Return color · intensity · 2^exposure · blackbody, three numbers, linear Rec.709.

    This is L of UsdLux before it is divided by the light's size. The blackbody is
    `UsdLux.BlackbodyTemperatureAsRgb`, of luminance 1. Multipliers of diffuse and specular
    response are part of it where they agree.

    Raises
    ------
    Refused
        When it is negative or beyond what single precision holds.
    """
    color = inputs.color("color", (1.0, 1.0, 1.0))
    power = inputs.number("intensity", 1.0) * np.exp2(inputs.number("exposure", 0.0))
    if inputs.flag("enableColorTemperature"):
        # The conversion ends the process where it is given no number; `number` refuses that.
        kelvin = inputs.number("colorTemperature", 6500.0)
        color = color * np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin), np.float64)
    total = color * (power * _multiplier(inputs))
    return bounded(total)


def bounded(value: Doubles) -> Doubles:
    """Return a color that Mitsuba can add up, or raise `Refused`."""
    if not (np.isfinite(value).all() and value.min() >= 0 and value.max() <= BRIGHTEST):
        shown = ", ".join(f"{v:g}" for v in value)
        raise Refused(f"emits ({shown}), expected 0 to {BRIGHTEST:g}")
    return np.asarray(value)


def _multiplier(inputs: Inputs) -> float:
    """Return by what diffuse and specular response are multiplied, 1 where they differ."""
    diffuse, specular = inputs.number("diffuse", 1.0), inputs.number("specular", 1.0)
    if diffuse == specular:
        if diffuse != 1:
            inputs.losses.approximated(
                inputs.prim, f"diffuse and specular of {diffuse:g} dim the light's own face too"
            )
        return diffuse
    inputs.losses.dropped(
        inputs.prim, f"multipliers of response: diffuse {diffuse:g}, specular {specular:g}"
    )
    return 1.0


def _brief(value: Any) -> str:
    return " ".join(str(value).split())[:60]
