"""A USD stage as a Mitsuba scene.

The stage is walked once. Every kind of prim has its module; what none of them knows becomes a
loss, so that nothing disappears in silence. Import this module after
`weaveusd.render.variant.prepare`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
from pxr import Usd, UsdGeom

from weaveusd import contract
from weaveusd.errors import StageError
from weaveusd.render import cameras, lights, materials, meshes, shapes
from weaveusd.render.model import Loss, Losses
from weaveusd.render.xforms import Placing, picture_scale, singular, stage_bounds

MAX_DEPTH = 16
"""Longest path of light, in segments."""


@dataclass(frozen=True, slots=True, eq=False)
class Translation:
    """A loaded scene with one sensor, and what it lacks."""

    scene: Any
    losses: tuple[Loss, ...]
    camera: str  # path of the prim, empty for the framing camera


def translate(
    stage: Usd.Stage,
    *,
    width: int,
    height: int,
    camera: str | None = None,
    context: str = contract.MITSUBA_CONTEXT,
) -> Translation:
    """Return the scene of `stage` at its earliest time, for a picture of the given pixels.

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
        `mitsuba` shows materials as the exact BSDF where they have one, `preview` as their
        UsdPreviewSurface.

    Raises
    ------
    StageError
        When the camera is none, a cloth's inputs or textures are broken, or Mitsuba refuses
        the scene.
    InputError
        For an unknown context.
    """
    return _Walk(stage, context).scene((width, height), camera)


class _Walk:
    """Gathers the entries of a scene from the prims of a stage."""

    def __init__(self, stage: Usd.Stage, context: str) -> None:
        self.stage = stage
        self.time = Usd.TimeCode.EarliestTime()
        self.losses = Losses()
        self.looks = materials.Looks(context, self.time, self.losses)
        self.bounds = stage_bounds(stage, self.time)
        scale = picture_scale(self.bounds)
        self.placing = Placing(scale, self.time)
        self.entries: list[Any] = []
        self.bsdfs: dict[tuple[int, bool], tuple[materials.Look, Any]] = {}
        self.lights = lights.Lights(stage, self.losses)
        self.pierced = False  # some surface lets light pass straight

    def scene(self, size: tuple[int, int], camera: str | None) -> Translation:
        """Return the scene of everything that is visible."""
        eye = cameras.find_camera(self.stage, camera)
        for error in self.stage.GetCompositionErrors():
            where = str(getattr(error, "rootSite", "")) or "/"
            self.losses.dropped(where, " ".join(str(error).split())[:300])
        if self.stage.GetStartTimeCode() < self.stage.GetEndTimeCode():
            self.losses.approximated("/", "animation is shown at its first moment")
        shines = self._gather() or self.lights.found
        self.entries += self.lights.entries()
        if not shines:
            self.losses.approximated("/", "stage has no light: a white dome lights it")
            self.entries.append(lights.DEFAULT_DOME)
        up_axis = str(UsdGeom.GetStageUpAxis(self.stage))
        if eye is None:
            self.losses.approximated("/", "stage has no camera: one that sees everything is used")
            sensor = cameras.framing_sensor(self.bounds, up_axis, size, self.placing.scale)
        else:
            sensor = cameras.sensor(eye, size, self._extent(), self.placing, self.losses)
        sensor["film"] = {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        }
        description: dict[str, Any] = {
            "type": "scene",
            "integrator": {"type": self._integrator(), "max_depth": MAX_DEPTH},
            "sensor": sensor,
        }
        description |= {f"entry_{k:05d}": entry for k, entry in enumerate(self.entries)}
        try:
            scene = mi.load_dict(description, parallel=False, optimize=False)
        except RuntimeError as error:
            root = self.stage.GetRootLayer().identifier
            reason = " ".join(str(error).split())[:300]
            raise StageError(f"{root}: Mitsuba refuses the scene: {reason}") from None
        path = str(eye.GetPath()) if eye is not None else ""
        return Translation(scene, self.losses.as_tuple(), path)

    def _gather(self) -> bool:
        """Collect the entries of all prims; return whether any of them shines."""
        shines = False
        walk = iter(
            Usd.PrimRange(
                self.stage.GetPseudoRoot(), Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
            )
        )
        for prim in walk:
            if prim.IsPseudoRoot() or not _is_drawn(prim, self.time):
                continue
            if lights.is_light(prim) and not prim.IsA(UsdGeom.Gprim):
                self.lights.add(prim, self.placing)
            elif prim.IsA(UsdGeom.PointInstancer):
                self.losses.dropped(prim, "PointInstancer with all its copies")
                walk.PruneChildren()
            elif prim.IsA(UsdGeom.Gprim):
                shines |= self._add_shape(prim)
            elif _is_unknown(prim):
                self.losses.dropped(prim, f"type {prim.GetTypeName()} is unknown")
        return shines

    def _add_shape(self, prim: Usd.Prim) -> bool:
        """Collect a surface; return whether its material shines."""
        world = self.placing.world(prim)
        opacity = UsdGeom.Gprim(prim).GetDisplayOpacityAttr().Get(self.time)
        if opacity and min(opacity) < 1:
            self.losses.dropped(prim, "displayOpacity below 1: the shape is opaque")
        if singular(world):
            self.losses.dropped(prim, "shape is flattened by its transform")
            return False
        if not prim.IsA(UsdGeom.Mesh):
            made = shapes.translate(prim, world, self.time, self.losses)
            if made is None:
                return False
            return self._add_analytic(prim, made)
        surface = meshes.read_surface(prim, world, self.time, self.losses)
        if surface is None:
            return False
        parts = meshes.parts(prim, surface, self.time, self.losses)
        shining = [self._add_part(prim, surface, part) for part in parts]
        return any(shining)

    def _add_part(self, prim: Usd.Prim, surface: meshes.Surface, part: meshes.Part) -> bool:
        look, color, uv = self.looks.of(part.prim), None, None
        if look is None:
            color = meshes.corner_primvar(prim, "displayColor", 3, surface, self.time, self.losses)
            look = materials.VERTEX_COLORED if color is not None else materials.PLAIN
        light = self.lights.of(prim, self.time)
        if light:
            look = self.lights.shine(light, look, meshes.surface_area(surface), self.placing)
        if look.uv is not None:
            uv = meshes.corner_primvar(prim, look.uv, 2, surface, self.time, self.losses)
            if uv is None:
                self.losses.approximated(prim, f"has no texture coordinates {look.uv}: 0 is used")
                uv = np.zeros((surface.indices.size, 2))
        properties = mi.Properties()
        properties["mesh_bsdf"] = self._bsdf(look, _both_sides(prim, self.time))
        if look.emission is not None:
            properties["mesh_emitter"] = mi.load_dict(look.emission, parallel=False)
        self.entries.append(meshes.to_mesh(surface, part, uv, color, properties))
        return look.emission is not None

    def _add_analytic(self, prim: Usd.Prim, entry: dict[str, Any]) -> bool:
        look = self.looks.of(prim)
        if look is None:
            colors = UsdGeom.Gprim(prim).GetDisplayColorAttr().Get(self.time)
            color = {"type": "rgb", "value": [float(v) for v in colors[0]]} if colors else None
            look = materials.default_look(color) if color else materials.PLAIN
        light = self.lights.of(prim, self.time)
        if light:
            extent = float(mi.load_dict(entry).surface_area()[0])
            look = self.lights.shine(light, look, extent, self.placing)
        if look.uv is not None:
            self.losses.approximated(
                prim, f"{prim.GetTypeName()} has no texture coordinates {look.uv} in USD"
            )
        entry["bsdf"] = self._bsdf(look, _both_sides(prim, self.time))
        if look.emission is not None:
            entry["emitter"] = look.emission
        self.entries.append(entry)
        return look.emission is not None

    def _bsdf(self, look: materials.Look, both_sides: bool) -> Any:
        """Return the BSDF, one object for all shapes that share a look."""
        self.pierced |= look.pierced
        key = (id(look), both_sides)
        if key not in self.bsdfs:
            bsdf = look.bsdf
            if look.opaque and both_sides:
                bsdf = {"type": "twosided", "bsdf": bsdf}
            # The look is kept beside its BSDF: its id must not pass to another one.
            self.bsdfs[key] = (look, mi.load_dict(bsdf, parallel=False, optimize=False))
        return self.bsdfs[key][1]

    def _integrator(self) -> str:
        """Return the integrator: the plain one stops shadow rays at gaps, the other does not."""
        return "volpath" if self.pierced and self.lights.unseen else "path"

    def _extent(self) -> float:
        if self.bounds is None:
            return 1.0
        return float(np.linalg.norm(self.bounds[1] - self.bounds[0])) * self.placing.scale or 1.0


def _is_drawn(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    """Return whether a prim is visible and meant for a final picture."""
    imageable = UsdGeom.Imageable(prim)
    if not imageable:
        return True
    if imageable.ComputeVisibility(time) == UsdGeom.Tokens.invisible:
        return False
    return imageable.ComputePurpose() in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)


def _is_unknown(prim: Usd.Prim) -> bool:
    """Return whether no schema defines the type that a prim says it is."""
    name = prim.GetTypeName()
    return bool(name) and not Usd.SchemaRegistry().FindConcretePrimDefinition(name)


def _both_sides(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    """Return whether the back shows: yes, unless the stage itself says no."""
    attribute = UsdGeom.Gprim(prim).GetDoubleSidedAttr()
    return bool(attribute.Get(time)) if attribute.HasAuthoredValue() else True
