"""UsdLux lights as Mitsuba emitters.

`Lights` gathers those of a stage; each family has its module. Import after
`weaveusd.render.variant.prepare`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom, UsdLux

from weaveusd.render.lights import area, shining
from weaveusd.render.lights.distant import distant
from weaveusd.render.lights.domes import MAX_PICTURED, Dome, environment, read_dome
from weaveusd.render.lights.emitters import UNSEEN
from weaveusd.render.lights.inputs import Inputs, Refused, emission
from weaveusd.render.lights.unsupported import note_unsupported
from weaveusd.render.look import Look
from weaveusd.render.model import Losses
from weaveusd.render.xforms import Placing, singular

__all__ = ["DEFAULT_DOME", "Lights", "is_light"]

DEFAULT_DOME: dict[str, Any] = {
    "type": "constant",
    "radiance": {"type": "rgb", "value": [1.0, 1.0, 1.0]},
}
"""Lights a stage that has no light of its own."""

_NIGHT: dict[str, Any] = {
    "type": "constant",
    "radiance": {"type": "rgb", "value": [0.0, 0.0, 0.0]},
    "sampling_weight": 0.0,
}
"""Lies behind clear lamps: Mitsuba shows no path that met nothing solid before it left a scene."""

_PLACED: dict[str, Callable[[Inputs, Placing], Any]] = {
    "RectLight": area.rect,
    "DiskLight": area.disk,
    "SphereLight": area.sphere,
    "CylinderLight": area.cylinder,
    "DistantLight": distant,
}
_DOMES = ("DomeLight", "DomeLight_1")


def is_light(prim: Usd.Prim) -> bool:
    """Return whether the prim is a light of any kind, shapes that shine among them."""
    return bool(prim.HasAPI(UsdLux.LightAPI))


@dataclass(slots=True)
class Lights:
    """Gathers the lights of a stage.

    `found` says whether the stage has a light that is understood, be it turned off; `unseen`
    whether one is without size, so that only shadow rays find it; `clear` whether one has a
    surface, which lets light pass straight.
    """

    stage: Usd.Stage
    losses: Losses
    found: bool = False
    unseen: bool = False
    clear: bool = False
    _entries: list[Any] = field(default_factory=list)
    _domes: list[Dome] = field(default_factory=list)
    _noted: set[Usd.Prim] = field(default_factory=set)
    _files: dict[Any, Any] = field(default_factory=dict)
    _geometry: dict[str, Usd.Prim] = field(init=False)

    def __post_init__(self) -> None:
        self._geometry = shining.geometry_lights(self.stage, self.losses)

    def add(self, prim: Usd.Prim, placing: Placing) -> None:
        """Take in a light that is no shape of the stage; what cannot be shown becomes a loss.

        `placing` says where it is, and at which time: the same light may be added at several
        places.
        """
        kind = prim.GetTypeName()
        if kind == "GeometryLight":
            return  # its shape shines where it is met
        if kind == "PortalLight":
            self.losses.approximated(prim, "portal guides no samples")
            return
        inputs = Inputs(prim, placing.time, self.losses, self._files)
        try:
            with np.errstate(all="ignore"):  # a number that overflows is refused where it is used
                self._take(kind, inputs, placing)
        except Refused as reason:
            self.losses.dropped(prim, str(reason))
            return
        self._note(inputs)

    def of(self, shape: Usd.Prim, time: Usd.TimeCode) -> Usd.Prim | None:
        """Return the light that makes a shape of the stage shine: itself, or a GeometryLight."""
        if is_light(shape):
            return shape
        light = self._geometry.get(str(shape.GetPath()))
        if light and UsdGeom.Imageable(light).ComputeVisibility(time) != UsdGeom.Tokens.invisible:
            return light
        return None

    def shine(self, light: Usd.Prim, look: Look, surface_area: float, placing: Placing) -> Look:
        """Return the look of a shape under `light`, the one that `of` gave for it.

        `surface_area` is that of the whole shape in the units that `placing` places in.
        """
        inputs = Inputs(light, placing.time, self.losses, self._files)
        try:
            with np.errstate(all="ignore"):
                made = shining.shining_look(inputs, placing, surface_area / placing.scale**2, look)
        except Refused as reason:
            self.losses.dropped(light, str(reason))
            return look
        self.clear |= made.bsdf is area.CLEAR
        self._note(inputs)
        return made

    def entries(self) -> list[Any]:
        """Return what to put into a scene for all lights taken in, the environment last."""
        sky = environment(self._domes)
        if sky is None and self.clear:
            sky = _NIGHT
        return [*self._entries, sky] if sky is not None else list(self._entries)

    def _note(self, inputs: Inputs) -> None:
        """Say that there is a light, and what it lacks, of many copies once."""
        self.found = True
        if inputs.prim not in self._noted:
            self._noted.add(inputs.prim)
            note_unsupported(inputs)

    def _take(self, kind: str, inputs: Inputs, placing: Placing) -> None:
        if singular(placing.world(inputs.prim)):
            raise Refused("light is flattened by its transform")
        if kind in _DOMES:
            self._add_dome(read_dome(inputs, placing))
        elif kind in _PLACED:
            self._place(_PLACED[kind], inputs, placing)
        else:
            raise Refused(_stranger(inputs.prim))

    def _add_dome(self, dome: Dome) -> None:
        pictured = sum(known.picture is not None for known in self._domes)
        if dome.picture is not None and pictured >= MAX_PICTURED:
            raise Refused(f"{MAX_PICTURED} domes with pictures are shown already")
        self._domes.append(dome)

    def _place(
        self, make: Callable[[Inputs, Placing], Any], inputs: Inputs, placing: Placing
    ) -> None:
        if not emission(inputs).any():
            return  # turned off: it neither shines nor stands in the way
        made = make(inputs, placing)
        without_size = isinstance(made, dict) and made["type"] in UNSEEN
        self.unseen |= without_size
        self.clear |= not without_size
        self._entries.append(made)


def _stranger(prim: Usd.Prim) -> str:
    """Return why a light of an unknown kind is left out."""
    kind = prim.GetTypeName() or "untyped light"
    if kind == "PluginLight":
        node = prim.GetAttribute("info:id").Get() or "without a name"
        return f"PluginLight {node} is another renderer's"
    return f"{kind} is not supported"
