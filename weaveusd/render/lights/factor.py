"""By what a light's emission is multiplied in a direction: `Shaping` in Mitsuba's terms."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import drjit as dr
import mitsuba as mi
import numpy as np

from weaveusd.render.lights.shaping import Shaping

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


def properties_of(tint: Doubles, shaping: Shaping | None) -> dict[str, Any]:
    """Return the properties from which a plugin makes its `Factor`."""
    made: dict[str, Any] = {"tint": mi.ScalarVector3f(*tint.tolist())}
    if shaping is None or shaping.neutral:
        return made
    made |= {f"axis_{k}": mi.ScalarVector3f(*axis.tolist()) for k, axis in enumerate(shaping.axes)}
    if shaping.cone is not None:
        cutoff, softness = shaping.cone
        made |= {"cone": cutoff, "cone_start": cutoff * (1 - softness)}
    if shaping.focus is not None:
        exponent, off_axis = shaping.focus
        made |= {"focus": exponent, "focus_tint": mi.ScalarVector3f(*off_axis.tolist())}
    if shaping.profile is not None:
        made["profile"] = mi.TensorXf(np.ascontiguousarray(shaping.profile[..., None]))
    return made


class Factor:
    """What the emission of a light is multiplied by, from its direction in the picture."""

    def __init__(self, props: Any) -> None:
        self.tint = mi.Color3f(*props["tint"])
        dr.make_opaque(self.tint)
        self.parts: list[Callable[[Any, Any], Any]] = []
        if "axis_0" not in props:
            return
        self.axes = [mi.Vector3f(*props[f"axis_{k}"]) for k in range(3)]
        dr.make_opaque(self.axes)
        if "cone" in props:
            self.cone = [mi.Float(props[name]) for name in ("cone_start", "cone")]
            dr.make_opaque(self.cone)
            self.parts.append(self._within_cone)
        if "focus" in props:
            self.exponent = mi.Float(props["focus"])
            self.off_axis = mi.Color3f(*props["focus_tint"])
            dr.make_opaque(self.exponent, self.off_axis)
            self.parts.append(self._focused)
        if "profile" in props:
            self.profile = mi.Texture2f(
                props["profile"], use_accel=False, wrap_mode=dr.WrapMode.Clamp
            )
            self.parts.append(self._measured)

    def of(self, direction: Any, active: Any) -> Any:
        """Return the factor for light that leaves along the unit vector `direction`."""
        factor = self.tint
        for part in self.parts:
            factor = factor * part(direction, active)
        return factor

    def _off_axis(self, direction: Any) -> Any:
        return dr.safe_acos(dr.dot(direction, self.axes[2]))

    def _within_cone(self, direction: Any, active: Any) -> Any:
        start, end = self.cone
        theta = self._off_axis(direction)
        t = dr.clip((theta - start) / dr.maximum(end - start, 1e-12), 0, 1)
        return dr.select(theta <= end, dr.select(end > start, 1 - t * t * (3 - 2 * t), 1), 0)

    def _focused(self, direction: Any, active: Any) -> Any:
        along = dr.power(dr.maximum(dr.abs(dr.dot(direction, self.axes[2])), 1e-12), self.exponent)
        return dr.lerp(self.off_axis, mi.Color3f(1), along)

    def _measured(self, direction: Any, active: Any) -> Any:
        x, y = (dr.dot(direction, axis) for axis in self.axes[:2])
        # Horizontal 0° is -x and grows towards -y: see `ies`.
        about = dr.atan2(-y, -x)
        about = dr.select(about < 0, about + dr.two_pi, about)
        rows, columns, _ = self.profile.tensor().shape
        across = about * ((columns - 1) / dr.two_pi)
        down = self._off_axis(direction) * ((rows - 1) / dr.pi)
        uv = mi.Point2f((across + 0.5) / columns, (down + 0.5) / rows)
        return self.profile.eval(uv, active)[0]
