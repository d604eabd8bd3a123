"""A USD stage as a Mitsuba scene.

What a walk over the stage met is assembled, lit and seen by one camera. Import this module after
`weaveusd.render.variant.prepare`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from pxr import Usd, UsdGeom

from weaveusd import contract
from weaveusd.errors import StageError
from weaveusd.render import cameras, lights, materials
from weaveusd.render.assembly import assemble
from weaveusd.render.distance_cloth import EVERYTHING_NEAR, seen_by, with_view
from weaveusd.render.gather import Found, Walk
from weaveusd.render.geometry import Bounds, Placed
from weaveusd.render.look import Look
from weaveusd.render.model import AUTO, FULL, Lod, Loss, Losses
from weaveusd.render.motion import moves
from weaveusd.render.pieces import Pieces
from weaveusd.render.xforms import Placing, picture_scale
from weaveusd.stage import captured_diagnostics

DEFAULT_PURPOSES = ("render",)

MAX_DEPTH = 16
"""Longest path of light, in segments."""


@dataclass(frozen=True, slots=True, eq=False)
class Translation:
    """A loaded scene with one sensor, and what it lacks."""

    scene: Any
    losses: tuple[Loss, ...]
    camera: str  # path of the prim, empty for the framing camera
    exposure: float = 1.0  # what the radiance is multiplied by in the picture


def translate(
    stage: Usd.Stage,
    *,
    width: int,
    height: int,
    camera: str | None = None,
    context: str = contract.MITSUBA_CONTEXT,
    frame: float | None = None,
    purposes: tuple[str, ...] = DEFAULT_PURPOSES,
    lod: Lod = FULL,
) -> Translation:
    """Return the scene of `stage` at one time, for a picture of the given pixels.

    Parameters
    ----------
    stage
        An open stage, in units and with an up axis of its own.
    width, height
        Pixels.
    camera
        Path of a camera; by default the stage's first one, and without any a camera that sees
        all there is.
    context
        `mitsuba` for the exact cloth, `mtlx` or `openpbr` for MaterialX networks, `preview` for
        UsdPreviewSurface; what a material lacks is looked for in the next of these.
    frame
        Time code of the picture; by default the earliest one.
    purposes
        What is drawn beside the purpose `default`: any of `render`, `proxy` and `guide`.
    lod
        Detail of exact cloths, as in `weaveusd.render.run.render`.

    Raises
    ------
    StageError
        When the camera is none, a cloth's inputs or textures are broken, or Mitsuba refuses
        the scene.
    InputError
        For an unknown context.
    """
    time = Usd.TimeCode.EarliestTime() if frame is None else Usd.TimeCode(frame)
    # Numbers that overflow are found where they are used, and told as losses.
    quiet = np.errstate(over="ignore", invalid="ignore", divide="ignore")
    with captured_diagnostics() as messages, quiet:
        made = _Scene(stage, context, time, purposes, lod).translation((width, height), camera)
    told = Losses()
    for message in messages:
        told.approximated("/", f"USD says: {message[:200]}")
    return replace(made, losses=made.losses + told.as_tuple())


class _Scene:
    """Puts together what a scene holds."""

    def __init__(
        self,
        stage: Usd.Stage,
        context: str,
        time: Usd.TimeCode,
        purposes: tuple[str, ...],
        lod: Lod,
    ) -> None:
        self.stage, self.time = stage, time
        self.view = EVERYTHING_NEAR
        self.losses = Losses()
        if lod != FULL and not dr.is_jit_v(mi.Float):
            self.losses.approximated("/", "cloth is shown in full: scalar variants have no levels")
            lod = FULL
        self.lod = lod
        looks = materials.Looks(context, time, self.losses, levels=lod != FULL)
        self.lights = lights.Lights(stage, self.losses)
        pieces = Pieces(time, looks, self.lights, self.losses)
        self.walk = Walk(stage, purposes, pieces, self.losses)
        self.bsdfs: dict[tuple[int, bool], tuple[Look, Any]] = {}
        self.pierced = False  # some surface lets light pass straight

    def translation(self, size: tuple[int, int], camera: str | None) -> Translation:
        """Return the scene of everything that is seen."""
        eye = cameras.find_camera(self.stage, camera)
        for error in self.stage.GetCompositionErrors():
            where = str(getattr(error, "rootSite", "")) or "/"
            self.losses.dropped(where, " ".join(str(error).split())[:300])
        if self.time == Usd.TimeCode.EarliestTime() and moves(self.stage):
            self.losses.approximated("/", "animation is shown at its first moment")
        found = self.walk.everything()
        bounds = _bounds(found)
        placing = Placing(picture_scale(bounds), self.time)
        sensor, exposure = self._sensor(eye, size, bounds, placing)
        if self.lod != FULL:
            level = None if self.lod == AUTO else int(self.lod)
            self.view = seen_by(mi.load_dict(sensor, parallel=False), level)
        entries = self._entries(found, placing.scale)
        description: dict[str, Any] = {
            "type": "scene",
            "integrator": {"type": self._integrator(), "max_depth": MAX_DEPTH},
            "sensor": sensor,
        }
        description |= {f"entry_{k:05d}": entry for k, entry in enumerate(entries)}
        try:
            scene = mi.load_dict(description, parallel=False, optimize=False)
        except RuntimeError as error:
            root = self.stage.GetRootLayer().identifier
            reason = " ".join(str(error).split())[:300]
            raise StageError(f"{root}: Mitsuba refuses the scene: {reason}") from None
        path = str(eye.GetPath()) if eye is not None else ""
        return Translation(scene, self.losses.as_tuple(), path, exposure)

    def _entries(self, found: Found, scale: float) -> list[Any]:
        """Return the shapes and lights of the scene; a white dome where nothing shines."""
        shines = any(shape.look.emission is not None for shape in found.shapes)
        entries = assemble(found.shapes, scale, self._dress, self.losses)
        for light, placing in found.lights:
            self.lights.add(light, placing.scaled(scale))
        entries += self.lights.entries()
        if not shines and not self.lights.found:
            self.losses.approximated("/", "stage has no light: a white dome lights it")
            entries.append(lights.DEFAULT_DOME)
        return entries

    def _sensor(
        self, eye: Usd.Prim | None, size: tuple[int, int], bounds: Bounds | None, placing: Placing
    ) -> tuple[dict[str, Any], float]:
        """Return the sensor with its film, and what the picture is multiplied by."""
        up_axis = str(UsdGeom.GetStageUpAxis(self.stage))
        if eye is None:
            self.losses.approximated("/", "stage has no camera: one that sees everything is used")
            sensor = cameras.framing_sensor(bounds, up_axis, size, placing.scale)
            return sensor | {"film": cameras.film(size)}, 1.0
        extent = 1.0
        if bounds is not None:
            extent = float(np.linalg.norm(bounds[1] - bounds[0])) * placing.scale or 1.0
        sensor = cameras.sensor(eye, size, extent, placing, self.losses)
        return sensor, cameras.exposure(eye, self.time, self.losses)

    def _dress(self, placed: Placed) -> tuple[Any, dict[str, Any] | None]:
        """Return the BSDF of a shape, one object for all that share a look, and its emitter."""
        look, both_sides = placed.look, placed.both_sides
        self.pierced |= look.pierced
        key = (id(look), both_sides)
        if key not in self.bsdfs:
            bsdf = with_view(look.bsdf, self.view)
            if look.opaque and both_sides:
                bsdf = {"type": "twosided", "bsdf": bsdf}
            # The look is kept beside its BSDF: its id must not pass to another one.
            self.bsdfs[key] = (look, mi.load_dict(bsdf, parallel=False, optimize=False))
        return self.bsdfs[key][1], look.emission

    def _integrator(self) -> str:
        """Return the integrator: the plain one stops shadow rays at gaps, the other does not."""
        pierced = self.pierced or self.lights.clear
        return "volpath" if pierced and self.lights.unseen else "path"


def _bounds(found: Found) -> Bounds | None:
    """Return the corners of all shapes, in stage units, else of all lights; None for nothing."""
    boxes = [placed.bounds() for placed in found.shapes]
    if not boxes:
        places = [placing.unscaled(light)[:3, 3] for light, placing in found.lights]
        boxes = [(place, place) for place in places if np.isfinite(place).all()]
    if not boxes:
        return None
    low, high = np.array(boxes).swapaxes(0, 1)
    return low.min(axis=0), high.max(axis=0)
