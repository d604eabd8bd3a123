"""A look at a scene before its picture is taken, for cloths to leave out what it does not show.

Import this module after `weaveusd.render.variant.prepare`.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from weaveusd.render.distance_cloth import DistantCloth

SIDE = 256
"""Rays across and down the picture: what lies between them is much like what they meet."""


def look(scene: Any) -> None:
    """Let every cloth of a loaded scene with levels `look` at what its first sensor sees of it."""
    found = {id(bsdf): bsdf for bsdf in (shape.bsdf() for shape in scene.shapes())}
    cloths = [b for b in found.values() if isinstance(getattr(b, "cloth", None), DistantCloth)]
    if not cloths:
        return
    index = dr.arange(mi.UInt32, SIDE * SIDE)
    place = (mi.Point2f(index % SIDE, index // SIDE) + 0.5) / SIDE
    ray, _ = scene.sensors()[0].sample_ray(0.0, 0.5, place, mi.Point2f(0.5))
    si = scene.ray_intersect(ray)
    for bsdf in cloths:
        bsdf.cloth.look(si, si.is_valid() & (si.bsdf() == mi.BSDFPtr(bsdf)))
