"""DomeLight and DomeLight_1: read one by one, shown together as one environment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np
from pxr import UsdGeom, UsdLux

from weaveusd.render.lights import panorama
from weaveusd.render.lights.inputs import Inputs, Refused, emission
from weaveusd.render.lights.pictures import read_picture
from weaveusd.render.lights.shaping import read_shaping
from weaveusd.render.xforms import Placing, rotation, to_mitsuba

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Pixels = NDArray[np.float32]

MAX_PICTURED = 16
"""Domes with a picture that are added up; every one but the largest has to be turned."""

_AUTOMATIC = "automatic"


@dataclass(frozen=True, slots=True, eq=False)
class Dome:
    """A light from all around: `tint`, times a lat-long picture where there is one."""

    tint: Doubles  # (3,)
    picture: Pixels | None  # (H, W, 3)
    turn: Doubles  # (3, 3) orthogonal, from the dome's space to the picture's


def read_dome(inputs: Inputs, placing: Placing) -> Dome:
    """Return a dome; one whose texture cannot be read has its tint alone, and a loss says so.

    Raises
    ------
    Refused
        When one of its numbers is none.
    """
    _note_portals(inputs)
    tint = emission(inputs)
    world = placing.world(inputs.prim)
    if not read_shaping(inputs, world).unasked:
        inputs.losses.dropped(inputs.prim, "shaping of a light without a place")
    if _pole(inputs) == "Z":
        world = world @ rotation("X", 90)
    left, _, right = np.linalg.svd(world[:3, :3])
    turn = left @ right
    picture = read_picture(inputs) if tint.any() else None
    return Dome(tint, None if picture is None else _latlong(inputs, picture.pixels), turn)


def environment(domes: list[Dome]) -> dict[str, Any] | None:
    """Return the emitter that is the sum of all domes, None where they are dark.

    The largest picture is shown as it is; others are turned and interpolated onto its raster,
    and keep their flux.
    """
    lit = [dome for dome in domes if dome.tint.any()]
    pictured = [dome for dome in lit if dome.picture is not None]
    even = sum((dome.tint for dome in lit if dome.picture is None), np.zeros(3))
    if not pictured:
        radiance = {"type": "rgb", "value": even.tolist()}
        return {"type": "constant", "radiance": radiance} if even.any() else None
    base = max(pictured, key=lambda dome: 0 if dome.picture is None else dome.picture.size)
    total = _tinted(base, base)
    for dome in pictured:
        if dome is not base:
            total += _tinted(dome, base)
    total += even.astype(np.float32)
    placed = np.eye(4)
    placed[:3, :3] = base.turn
    return {"type": "envmap", "bitmap": mi.Bitmap(total), "to_world": to_mitsuba(placed)}


def _tinted(dome: Dome, base: Dome) -> Pixels:
    """Return the picture of a dome in the space and on the raster of another."""
    assert dome.picture is not None
    assert base.picture is not None
    picture = dome.picture
    if dome is not base:
        size = base.picture.shape[0], base.picture.shape[1]
        source_from_target = dome.turn.T @ base.turn
        turned = panorama.resampled(picture, panorama.LATLONG, size, source_from_target)
        before, after = panorama.flux(picture), panorama.flux(turned)
        keep = np.divide(before, after, out=np.ones(3), where=after > 0)
        picture = turned * keep.astype(np.float32)
    return np.ascontiguousarray(picture * dome.tint.astype(np.float32), np.float32)


def _latlong(inputs: Inputs, picture: Pixels) -> Pixels | None:
    """Return the picture as lat-long, None and a loss where its layout cannot be read."""
    layout = str(inputs.value("texture:format", _AUTOMATIC))
    height, width = picture.shape[:2]
    if layout == _AUTOMATIC:
        if width != 2 * height:
            inputs.losses.approximated(
                inputs.prim, f"texture of {width} x {height} texels is taken as latlong"
            )
        layout = panorama.LATLONG
    if layout not in (panorama.LATLONG, panorama.BALL, panorama.ANGULAR, panorama.CROSS):
        inputs.losses.dropped(
            inputs.prim, f"dome texture in the format {layout}: the dome has one color"
        )
        return None
    if min(height, width) < 2:
        # Mitsuba interpolates between rows and columns.
        picture = np.repeat(np.repeat(picture, 2, axis=0), 2, axis=1)
    try:
        return panorama.to_latlong(picture, layout)
    except ValueError as error:
        inputs.losses.dropped(inputs.prim, f"dome texture {error}: the dome has one color")
        return None


def _pole(inputs: Inputs) -> str:
    """Return the axis that the top of a dome's picture lies on: Y but for DomeLight_1."""
    if inputs.prim.GetTypeName() != "DomeLight_1":
        return "Y"
    pole = inputs.prim.GetAttribute("poleAxis").Get(inputs.time)
    if pole in (None, "scene"):
        return str(UsdGeom.GetStageUpAxis(inputs.prim.GetStage()))
    if pole not in ("Y", "Z"):
        raise Refused(f"poleAxis is {pole}, expected scene, Y or Z")
    return str(pole)


def _note_portals(inputs: Inputs) -> None:
    portals = UsdLux.DomeLight(inputs.prim).GetPortalsRel() or inputs.prim.GetRelationship(
        "portals"
    )
    for target in portals.GetTargets() if portals else ():
        inputs.losses.approximated(
            inputs.prim, f"portal {target} guides no samples: the dome shines through everything"
        )
