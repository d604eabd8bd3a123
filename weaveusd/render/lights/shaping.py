"""UsdLux's ShapingAPI: how the light of a lamp depends on the direction it leaves in.

With θ the angle off the light's -Z axis in the picture, L is multiplied by
``lerp(focusTint, 1, |cos θ|^focus)``, by ``1 - smoothstep(θ_start, θ_cone, θ)`` with
``θ_start = (1 - softness) θ_cone``, and by the IES profile (schema text of OpenUSD 26.11).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pxr import UsdLux

from weaveusd.errors import StageError
from weaveusd.render import textures
from weaveusd.render.lights import ies
from weaveusd.render.lights.inputs import Inputs, Refused

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

_NAMES = ("focus", "focusTint", "cone:angle", "cone:softness", "ies:file")


@dataclass(frozen=True, slots=True, eq=False)
class Shaping:
    """The shape of a light's emission.

    `axes` are unit vectors in the space of the picture: the light's x and y, and -Z, along which
    it shines. `cone` is (cutoff, softness), in radians and 0…1; None lets all directions pass.
    `focus` is (exponent, tint); `profile` relative intensities by angle off the axis and about it.
    """

    axes: Doubles  # (3, 3), rows x, y, -z
    cone: tuple[float, float] | None = None
    focus: tuple[float, Doubles] | None = None
    profile: NDArray[np.float32] | None = None  # (angles off, angles about), see `ies.sampled`

    @property
    def neutral(self) -> bool:
        """Return whether no direction differs from another."""
        return self.cone is None and self.focus is None and self.profile is None

    @property
    def unasked(self) -> bool:
        """Return whether it says no more than the schema's fallbacks, a cone of 90°, do."""
        cone = self.cone is None or self.cone == (math.radians(90.0), 0.0)
        return cone and self.focus is None and self.profile is None


def read_shaping(inputs: Inputs, world: Doubles) -> Shaping:
    """Return the shaping of a light placed by `world`, neutral where it asks for none.

    Raises
    ------
    Refused
        When one of its numbers is none. A broken profile is a loss, and left out.
    """
    axes = _axes(world)
    if not _is_shaped(inputs):
        return Shaping(axes)
    angle = inputs.number("shaping:cone:angle", 90.0)
    softness = min(max(inputs.number("shaping:cone:softness", 0.0), 0.0), 1.0)
    if angle < 0:
        raise Refused(f"shaping:cone:angle is {angle:g}, expected 0 or more")
    cone = (math.radians(angle), softness) if angle < 180 else None
    exponent = inputs.number("shaping:focus", 0.0)
    tint = inputs.color("shaping:focusTint", (0.0, 0.0, 0.0))
    if tint.min() < 0:
        raise Refused(f"shaping:focusTint is {tuple(tint)}, expected 0 or more")
    focus = (exponent, tint) if exponent > 0 and not (tint == 1).all() else None
    return Shaping(axes, cone, focus, _profile(inputs))


def _is_shaped(inputs: Inputs) -> bool:
    """Return whether shaping applies: its schema does, or an old file names one of its inputs."""
    if inputs.prim.HasAPI(UsdLux.ShapingAPI):
        return True
    attributes = (
        inputs.prim.GetAttribute(f"{p}shaping:{n}") for p in ("inputs:", "") for n in _NAMES
    )
    return any(a and a.HasAuthoredValue() for a in attributes)


def _profile(inputs: Inputs) -> NDArray[np.float32] | None:
    asset = inputs.value("shaping:ies:file", None)
    if not asset:
        return None
    where = f"{inputs.prim.GetPath()}.inputs:shaping:ies:file"
    scale = inputs.number("shaping:ies:angleScale", 0.0)
    normalize = inputs.flag("shaping:ies:normalize")
    try:
        path = textures.resolved(asset, where)
        key = path, scale, normalize
        if key not in inputs.files:
            profile = ies.read_profile(path, where)
            inputs.files[key] = ies.sampled(profile, scale, normalize=normalize)
    except StageError as error:
        inputs.losses.dropped(inputs.prim, str(error))
        return None
    table: NDArray[np.float32] = inputs.files[key]
    return table


def _axes(world: Doubles) -> Doubles:
    """Return the light's x, y and -z, made orthonormal around -z; y keeps a mirror's hand."""
    x, y, z = world[:3, :3].T
    ahead = -z / np.linalg.norm(z)
    x = x - ahead * (x @ ahead)
    x /= np.linalg.norm(x)
    y = y - ahead * (y @ ahead) - x * (y @ x)
    return np.stack([x, y / np.linalg.norm(y), ahead])
