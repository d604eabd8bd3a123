"""Emitters that Mitsuba lacks: `weaveusd_glow`, `weaveusd_spot` and `weaveusd_sun`.

A glow is a surface whose radiance depends on the direction, as ShapingAPI says; a spot the same
without a surface; a sun shines from a cone of directions and is at the same place for the whole
scene. Call `register` before a scene with one of them is loaded.
"""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Any

import drjit as dr
import mitsuba as mi
import numpy as np

from weaveusd.render.lights.factor import Factor, properties_of
from weaveusd.render.lights.shaping import Shaping

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

GLOW, SPOT, SUN = "weaveusd_glow", "weaveusd_spot", "weaveusd_sun"

UNSEEN = ("directional", "point", SPOT, SUN)
"""Emitters of a single direction or point: only shadow rays find them."""

_FAR = 1e6
"""Distance of a sun, in units of the picture, whose scene spans some thousand."""


def glow(radiance: Any, tint: Doubles, shaping: Shaping | None = None) -> dict[str, Any]:
    """Return an emitter for a shape: a texture's radiance times `tint`, shaped."""
    register()
    return {"type": GLOW, "radiance": radiance} | properties_of(tint, shaping)


def of_ball(emitter: dict[str, Any], matrix: Doubles) -> dict[str, Any]:
    """Return the emitter, a glow or Mitsuba's `area`, for the image of the unit sphere.

    `matrix` (4, 4) keeps angles. Mitsuba's sphere takes the density of its cone from 1 - cos θ
    in single precision: at a half angle θ of 3′ it is a fifth too bright, at 0.7′ three times,
    and a smaller one is dark. Ours takes it from the sine.
    """
    made = dict(emitter)
    if made["type"] != GLOW:
        made = glow(made["radiance"], np.ones(3))
    center = mi.ScalarVector3f(*matrix[:3, 3].tolist())
    return made | {"center": center, "radius": float(np.linalg.norm(matrix[:3, 0]))}


def spot(position: Doubles, intensity: Doubles, shaping: Shaping) -> dict[str, Any]:
    """Return a shaped emitter without extent; `intensity` per steradian along its axis."""
    register()
    at = mi.ScalarVector3f(*position.tolist())
    return {"type": SPOT, "position": at} | properties_of(intensity, shaping)


def sun(toward: Doubles, radiance: Doubles, half_angle_rad: float) -> dict[str, Any]:
    """Return an emitter of one radiance within `half_angle_rad` of the direction `toward`."""
    register()
    return {
        "type": SUN,
        "toward": mi.ScalarVector3f(*toward.tolist()),
        "radiance": mi.ScalarVector3f(*radiance.tolist()),
        # 1 - cos of the half angle, without its cancellation.
        "height": 2 * math.sin(half_angle_rad / 2) ** 2,
    }


def register() -> None:
    """Make the emitters known to the active variant."""
    _register(mi.variant())


@cache
def _register(variant: str) -> None:
    for name, make in ((GLOW, _glow_class), (SPOT, _spot_class), (SUN, _sun_class)):
        mi.register_emitter(name, make(variant))


def _pointer(emitter: Any) -> Any:
    return mi.EmitterPtr(emitter) if dr.is_jit_v(mi.Float) else emitter


def _toward(it: Any, point: Any, distance: Any, direction: Any, emitter: Any) -> Any:
    """Return the sample of an emitter that nothing but a shadow ray can find."""
    ds = mi.DirectionSample3f()
    ds.p, ds.n, ds.uv = point, -direction, mi.Point2f(0)
    ds.time, ds.pdf, ds.delta = it.time, mi.Float(1), mi.Bool(True)
    ds.emitter, ds.d, ds.dist = _pointer(emitter), direction, distance
    return ds


class _Ball:
    """A sphere, evenly sampled within the cone under which a point sees it."""

    def __init__(self, props: Any) -> None:
        self.center, self.radius = mi.Point3f(*props["center"]), mi.Float(props["radius"])
        dr.make_opaque(self.center, self.radius)

    def density(self, point: Any, near: Any) -> Any:
        """Return the density per steradian: `near`, which is Mitsuba's, for a wide cone."""
        away = (self.center - point) / self.radius
        square = dr.rcp(dr.squared_norm(away))
        height = square / (1 + dr.safe_sqrt(1 - square))  # 1 - cos of the half angle
        return dr.select(square < 0.01, dr.rcp(dr.two_pi * height), near)


def _glow_class(variant: str) -> type:
    class Glow(mi.Emitter):  # type: ignore[misc]
        """A shape whose radiance follows `Factor`."""

        def __init__(self, props: Any) -> None:
            mi.Emitter.__init__(self, props)
            self.radiance = props.get_unbounded_texture("radiance")
            self.factor = Factor(props)
            self.ball = _Ball(props) if "radius" in props else None
            self.m_flags = mi.EmitterFlags.Surface | mi.EmitterFlags.SpatiallyVarying

        def eval(self, si: Any, active: Any = True) -> Any:
            front = active & (mi.Frame3f.cos_theta(si.wi) > 0)
            factor = self.factor.of(si.to_world(si.wi), front)
            return dr.select(front, self.radiance.eval(si, front) * factor, 0)

        def sample_direction(self, it: Any, sample: Any, active: Any = True) -> tuple[Any, Any]:
            ds = self.get_shape().sample_direction(it, sample, active)
            ds.emitter = _pointer(self)
            if self.ball is not None:
                ds.pdf = self.ball.density(it.p, ds.pdf)
            found = active & (ds.pdf > 0)
            return ds, self._arriving(it, ds, found) / dr.select(found, ds.pdf, 1)

        def pdf_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            front = active & (dr.dot(ds.d, ds.n) < 0)
            density = self.get_shape().pdf_direction(it, ds, front)
            if self.ball is not None:
                density = self.ball.density(it.p, density)
            return dr.select(front, density, 0)

        def eval_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return self._arriving(it, ds, active)

        def _arriving(self, it: Any, ds: Any, active: Any) -> Any:
            """Return the radiance that comes from the point and along the line of a sample."""
            front = active & (dr.dot(ds.d, ds.n) < 0)
            si = mi.SurfaceInteraction3f(ds, it.wavelengths)
            factor = self.factor.of(-ds.d, front)
            return dr.select(front, self.radiance.eval(si, front) * factor, 0)

        def bbox(self) -> Any:
            return self.get_shape().bbox()

        def to_string(self) -> str:
            return f"Glow[{len(self.factor.parts)} kinds of shaping, {variant}]"

    return Glow


def _unseen_class() -> type:
    class Unseen(mi.Emitter):  # type: ignore[misc]
        """An emitter that no ray hits."""

        def eval(self, si: Any, active: Any = True) -> Any:
            return mi.Color3f(0)

        def pdf_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return mi.Float(0)

        def eval_direction(self, it: Any, ds: Any, active: Any = True) -> Any:
            return mi.Color3f(0)

        def bbox(self) -> Any:
            return mi.ScalarBoundingBox3f()

    return Unseen


def _spot_class(variant: str) -> type:
    class Spot(_unseen_class()):  # type: ignore[misc]
        """A point whose intensity follows `Factor`."""

        def __init__(self, props: Any) -> None:
            mi.Emitter.__init__(self, props)
            self.position = mi.Point3f(*props["position"])
            dr.make_opaque(self.position)
            self.factor = Factor(props)
            self.m_flags = mi.EmitterFlags.DeltaPosition

        def sample_direction(self, it: Any, sample: Any, active: Any = True) -> tuple[Any, Any]:
            away = self.position - it.p
            squared = dr.squared_norm(away)
            distance = dr.sqrt(squared)
            direction = away / distance
            ds = _toward(it, self.position, distance, direction, self)
            value = self.factor.of(-direction, active) / squared
            return ds, dr.select(active & (squared > 0), value, 0)

        def to_string(self) -> str:
            return f"Spot[{len(self.factor.parts)} kinds of shaping, {variant}]"

    return Spot


def _sun_class(variant: str) -> type:
    class Sun(_unseen_class()):  # type: ignore[misc]
        """One radiance from every direction of a cone."""

        def __init__(self, props: Any) -> None:
            mi.Emitter.__init__(self, props)
            self.frame = mi.Frame3f(mi.Vector3f(*props["toward"]))
            self.radiance = mi.Color3f(*props["radiance"])
            self.height = mi.Float(props["height"])
            dr.make_opaque(self.frame, self.radiance, self.height)
            self.m_flags = mi.EmitterFlags.Infinite | mi.EmitterFlags.DeltaDirection

        def sample_direction(self, it: Any, sample: Any, active: Any = True) -> tuple[Any, Any]:
            # Uniform in solid angle, 2π (1 - cos θ) in all; exact for the smallest sun.
            below = self.height * sample.x
            across = dr.safe_sqrt(below * (2 - below))
            sine, cosine = dr.sincos(dr.two_pi * sample.y)
            direction = self.frame.to_world(mi.Vector3f(across * cosine, across * sine, 1 - below))
            ds = _toward(it, it.p + direction * _FAR, mi.Float(_FAR), direction, self)
            return ds, dr.select(active, self.radiance * (dr.two_pi * self.height), 0)

        def to_string(self) -> str:
            return f"Sun[{variant}]"

    return Sun
