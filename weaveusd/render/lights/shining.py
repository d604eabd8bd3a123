"""Shapes that shine because a light says so: MeshLightAPI, LightAPI, GeometryLight."""

from __future__ import annotations

from dataclasses import replace

from pxr import Usd, UsdGeom, UsdLux

from weaveusd.render.lights import area
from weaveusd.render.lights.emitters import glow
from weaveusd.render.lights.inputs import Inputs
from weaveusd.render.lights.shaping import read_shaping
from weaveusd.render.look import Look
from weaveusd.render.model import Losses
from weaveusd.render.xforms import Placing

_TINTS, _ALONE, _BARE = "materialGlowTintsLight", "independent", "noMaterialResponse"


def geometry_lights(stage: Usd.Stage, losses: Losses) -> dict[str, Usd.Prim]:
    """Return the path of each shape that a GeometryLight names, and that light."""
    found: dict[str, Usd.Prim] = {}
    everything = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), everything):
        if prim.GetTypeName() != "GeometryLight":
            continue
        targets = UsdLux.GeometryLight(prim).GetGeometryRel().GetTargets()
        if not targets:
            losses.dropped(prim, "names no geometry")
        for target in targets:
            shape = stage.GetPrimAtPath(target)
            if not (shape and shape.IsA(UsdGeom.Gprim)):
                losses.dropped(prim, f"names {target}, expected a shape")
            elif str(target) in found:
                losses.dropped(prim, f"{target} shines by another light already")
            else:
                found[str(target)] = prim
    return found


def shining_look(light: Inputs, placing: Placing, surface_area: float, look: Look) -> Look:
    """Return the look of a shape that shines as a light says; `surface_area` in stage units.

    `light:materialSyncMode` decides what becomes of the material. With noMaterialResponse the
    shape is clear and the light's alone; with independent it keeps its material, and its glow is
    the light's; with materialGlowTintsLight the light's color is multiplied by the glow, where
    the material has one.

    Raises
    ------
    Refused
        When one of the light's numbers is none.
    """
    mode = str(light.prim.GetAttribute("light:materialSyncMode").Get(light.time) or _BARE)
    shining = area.emitter(light, placing, surface_area)
    if mode == _BARE:
        return Look(area.CLEAR, emission=shining, opaque=False, pierced=True)
    if look.emission is None:
        return replace(look, emission=shining)
    if mode == _ALONE:
        light.losses.approximated(light.prim, "seen directly, it shows its light and not its glow")
        return replace(look, emission=shining)
    light.losses.approximated(light.prim, "seen directly, its glow is as bright as its light")
    shaping = read_shaping(light, placing.world(light.prim))
    tint = area.radiance(light, surface_area)
    return replace(look, emission=glow(look.emission["radiance"], tint, shaping))
