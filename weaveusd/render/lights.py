"""UsdLux lights as Mitsuba emitters."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np
from pxr import Usd, UsdGeom, UsdLux

from weaveusd.errors import StageError
from weaveusd.render import textures
from weaveusd.render.model import Losses
from weaveusd.render.xforms import Placing, rotation, scaling, singular, to_mitsuba, uniform_scale

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

Entry = dict[str, Any]

DEFAULT_DOME: Entry = {"type": "constant", "radiance": {"type": "rgb", "value": [1.0, 1.0, 1.0]}}
"""Lights a stage that has no light of its own."""


def is_light(prim: Usd.Prim) -> bool:
    """Return whether the prim is a light of any kind."""
    return bool(prim.HasAPI(UsdLux.LightAPI))


def translate_light(prim: Usd.Prim, placing: Placing, losses: Losses) -> Entry | None:
    """Return Mitsuba's emitter, or shape with an emitter, of a light; None where it is dropped.

    Radiance is color · intensity · 2^exposure · blackbody, divided by the light's area in stage
    units where `inputs:normalize` says so.
    """
    make = _KINDS.get(prim.GetTypeName())
    if make is None:
        losses.dropped(prim, f"{prim.GetTypeName() or 'untyped light'} is not supported")
        return None
    if singular(placing.world(prim)):
        losses.dropped(prim, "light is flattened by its transform")
        return None
    _note_unsupported(prim, placing.time, losses)
    return make(prim, placing, losses)


def emission(prim: Usd.Prim, time: Usd.TimeCode) -> Doubles:
    """Return color · intensity · 2^exposure · blackbody, linear RGB."""
    light = UsdLux.LightAPI(prim)
    color = np.array(light.GetColorAttr().Get(time), np.float64)
    power = light.GetIntensityAttr().Get(time) * 2.0 ** light.GetExposureAttr().Get(time)
    if light.GetEnableColorTemperatureAttr().Get(time):
        kelvin = light.GetColorTemperatureAttr().Get(time)
        color = color * np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin), np.float64)
    total = color * power
    if not np.isfinite(total).all() or total.min() < 0:
        raise StageError(f"{prim.GetPath()}: emits {tuple(total)}, expected finite, not negative")
    return np.asarray(total)


def _rect(prim: Usd.Prim, placing: Placing, losses: Losses) -> Entry | None:
    light, time = UsdLux.RectLight(prim), placing.time
    width, height = light.GetWidthAttr().Get(time), light.GetHeightAttr().Get(time)
    if light.GetTextureFileAttr().Get(time):
        losses.dropped(prim, "texture of a rect light")
    matrix = rotation("Y", 180) @ scaling(width / 2, height / 2, 1)
    axes = placing.unscaled(prim)[:3, :3] @ matrix[:3, :3]
    area = 4 * float(np.linalg.norm(np.cross(axes[:, 0], axes[:, 1])))
    return _area_light("rectangle", placing.world(prim) @ matrix, prim, area, placing, losses)


def _disk(prim: Usd.Prim, placing: Placing, losses: Losses) -> Entry | None:
    radius = UsdLux.DiskLight(prim).GetRadiusAttr().Get(placing.time)
    matrix = rotation("Y", 180) @ scaling(radius, radius, 1)
    axes = placing.unscaled(prim)[:3, :3] @ matrix[:3, :3]
    area = math.pi * float(np.linalg.norm(np.cross(axes[:, 0], axes[:, 1])))
    return _area_light("disk", placing.world(prim) @ matrix, prim, area, placing, losses)


def _sphere(prim: Usd.Prim, placing: Placing, losses: Losses) -> Entry | None:
    light, time = UsdLux.SphereLight(prim), placing.time
    radius, world = light.GetRadiusAttr().Get(time), placing.unscaled(prim)
    if light.GetTreatAsPointAttr().Get(time):
        losses.approximated(prim, "light treated as a point is shown as its sphere")
    scale = uniform_scale(world)
    if scale is None:
        losses.approximated(prim, "stretched sphere light is shown as a sphere of equal volume")
        scale = abs(float(np.linalg.det(world[:3, :3]))) ** (1 / 3)
    world_radius = radius * scale
    matrix = np.eye(4)
    matrix[:3, 3] = placing.world(prim)[:3, 3]
    matrix = matrix @ scaling(*(world_radius * placing.scale,) * 3)
    area = 4 * math.pi * world_radius**2
    return _area_light("sphere", matrix, prim, area, placing, losses)


def _distant(prim: Usd.Prim, placing: Placing, losses: Losses) -> Entry:
    light, time = UsdLux.DistantLight(prim), placing.time
    angle = math.radians(light.GetAngleAttr().Get(time)) / 2
    irradiance = emission(prim, time)
    if angle > 0:
        losses.approximated(prim, "distant light casts sharp shadows, whatever its angle")
        if not UsdLux.LightAPI(prim).GetNormalizeAttr().Get(time):
            irradiance = irradiance * math.pi * math.sin(min(angle, math.pi / 2)) ** 2
    direction = placing.world(prim)[:3, :3] @ (0.0, 0.0, -1.0)
    direction /= np.linalg.norm(direction)
    return {"type": "directional", "direction": direction.tolist(), "irradiance": _rgb(irradiance)}


def _dome(prim: Usd.Prim, placing: Placing, losses: Losses) -> Entry:
    light, time = UsdLux.DomeLight(prim), placing.time
    tint = emission(prim, time)
    file = prim.GetAttribute("inputs:texture:file").Get(time)
    if not file:
        return {"type": "constant", "radiance": _rgb(tint)}
    layout = prim.GetAttribute("inputs:texture:format").Get(time)
    if layout not in (UsdLux.Tokens.automatic, UsdLux.Tokens.latlong):
        losses.dropped(prim, f"dome texture in the format {layout}: the dome has one color")
        return {"type": "constant", "radiance": _rgb(tint)}
    where = f"{prim.GetPath()}.inputs:texture:file"
    image = textures.read_image(textures.resolved(file, where), where)
    pixels = textures.linear(image, "auto")[..., :3]
    if pixels.shape[2] < 3:
        pixels = np.repeat(pixels[..., :1], 3, axis=2)
    if pixels.min() < 0:
        losses.approximated(prim, "negative radiance in the dome texture is taken as 0")
    lit = np.maximum(pixels, 0) * tint.astype(np.float32)
    world = placing.world(prim)
    if _pole(prim, light, time) == "Z":
        world = world @ rotation("X", 90)
    left, _, right = np.linalg.svd(world[:3, :3])
    turned = np.eye(4)
    turned[:3, :3] = left @ right
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(lit, np.float32)),
        "to_world": to_mitsuba(turned),
    }


_KINDS: dict[str, Callable[[Usd.Prim, Placing, Losses], Entry | None]] = {
    "RectLight": _rect,
    "DiskLight": _disk,
    "SphereLight": _sphere,
    "DistantLight": _distant,
    "DomeLight": _dome,
    "DomeLight_1": _dome,
}


def _pole(prim: Usd.Prim, light: Any, time: Usd.TimeCode) -> str:
    """Return the axis that the top of a dome's picture lies on: Y but for DomeLight_1."""
    pole = prim.GetAttribute("poleAxis")
    wish = pole.Get(time) if pole else "Y"
    if wish == "scene":
        return str(UsdGeom.GetStageUpAxis(prim.GetStage()))
    return str(wish or "Y")


def _area_light(
    shape: str, matrix: Doubles, prim: Usd.Prim, area: float, placing: Placing, losses: Losses
) -> Entry | None:
    """Return a black shape that emits, None for one without extent; `area` in stage units."""
    if singular(matrix):
        losses.dropped(prim, "light has no extent")
        return None
    time = placing.time
    radiance = emission(prim, time)
    if UsdLux.LightAPI(prim).GetNormalizeAttr().Get(time) and area > 0:
        radiance = radiance / area
    return {
        "type": shape,
        "to_world": to_mitsuba(matrix),
        "bsdf": {"type": "diffuse", "reflectance": _rgb(np.zeros(3))},
        "emitter": {"type": "area", "radiance": _rgb(radiance)},
    }


def _rgb(values: Doubles) -> Entry:
    return {"type": "rgb", "value": [float(v) for v in values]}


def _note_unsupported(prim: Usd.Prim, time: Usd.TimeCode, losses: Losses) -> None:
    """Report what Mitsuba's emitters cannot do and the light asks for."""
    light = UsdLux.LightAPI(prim)
    for name, attribute in (
        ("diffuse multiplier", light.GetDiffuseAttr()),
        ("specular multiplier", light.GetSpecularAttr()),
    ):
        if attribute.Get(time) not in (None, 1.0):
            losses.dropped(prim, f"{name} of a light")
    if prim.HasAPI(UsdLux.ShapingAPI):
        losses.dropped(prim, "shaping of a light: it shines as without cone and focus")
    if prim.HasAPI(UsdLux.ShadowAPI):
        losses.dropped(prim, "shadow settings of a light")
    for relation in ("light:filters", "collection:lightLink:excludes"):
        link = prim.GetRelationship(relation)
        if link and link.GetTargets():
            losses.dropped(prim, f"{relation} of a light")
