from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from weaveusd.render import variant
from weaveusd.render.lights import emitters
from weaveusd.render.lights.shaping import Shaping
from weaveusd.render.xforms import to_mitsuba

DOWN = np.array([(-1.0, 0, 0), (0, 1, 0), (0, 0, -1)])  # x, y and -z of a light turned about y
SHAPED = Shaping(
    DOWN, cone=(np.radians(50), 0.4), focus=(2.0, np.array((1, 0.5, 0))),
    profile=np.linspace(2, 0, 361, dtype=np.float32)[:, None].repeat(721, 1),
)  # fmt: skip
WHITE = {"type": "rgb", "value": [1.0, 1.0, 1.0]}


def emitter(kind: str) -> dict[str, Any]:
    if kind == emitters.SUN:
        return {"sun": emitters.sun(np.array((0, 0.6, 0.8)), np.array((1.0, 2, 3)), 0.3)}
    if kind == emitters.SPOT:
        return {"spot": emitters.spot(np.array((0.5, 0, 2)), np.array((1.0, 2, 3)), SHAPED)}
    import mitsuba as mi

    if kind == "ball":
        matrix = np.array([(0.05, 0, 0, 0), (0, 0.05, 0, 0), (0, 0, 0.05, 2), (0, 0, 0, 1)])
        bright = {"type": "area", "radiance": {"type": "rgb", "value": [1.0, 2.0, 3.0]}}
        shining = emitters.of_ball(bright, matrix)
        return {"ball": {"type": "sphere", "to_world": to_mitsuba(matrix), "emitter": shining}}
    place = mi.ScalarTransform4f().translate([0, 0, 2]).rotate([0, 1, 0], 180)
    glow = emitters.glow(WHITE, np.array((1.0, 2, 3)), SHAPED)
    return {"disk": {"type": "disk", "to_world": place, "emitter": glow}}


def render(kind: str, integrator: str, spp: int) -> Any:
    import mitsuba as mi

    eye = mi.ScalarTransform4f().look_at(origin=[0, 0, 1], target=[0, 0, 0], up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}}
    scene = mi.load_dict(
        {
            "type": "scene",
            "sensor": {"type": "perspective", "fov": 10, "to_world": eye, "film": film},
            "card": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": WHITE}},
        }
        | emitter(kind)
    )
    image = mi.render(scene, integrator=mi.load_dict({"type": integrator}), spp=spp, seed=2)
    return np.array(image).mean(axis=(0, 1))


@pytest.mark.parametrize("kind", [emitters.SUN, emitters.SPOT, emitters.GLOW, "ball"])
def test_variants_and_integrators_agree_on_our_emitters(mi: Any, kind: str) -> None:
    vectorized = render(kind, "path", 4096)
    assert vectorized.min() > 0
    assert render(kind, "volpath", 4096) == pytest.approx(vectorized, rel=0.01)
    variant.prepare(variant.SCALAR)
    assert render(kind, "path", 256) == pytest.approx(vectorized, rel=0.05)


def test_a_sun_is_sampled_evenly_within_its_cone(mi: Any) -> None:
    """cos θ is even between cos θ_max and 1, and the angle about the axis all around."""
    half, count = 1.9, 1 << 16
    toward = np.array((0.36, 0.48, 0.8))
    sun = mi.load_dict(emitters.sun(toward, np.ones(3), half))
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(1, count)
    it = mi.SurfaceInteraction3f()
    it.p = mi.Point3f(1, 2, 3)
    ds, weight = sun.sample_direction(it, sampler.next_2d())
    direction = np.array(ds.d).T
    height = (1 - direction @ toward) / (1 - np.cos(half))
    histogram, _ = np.histogram(height, 16, (0, 1))
    expected = count / 16
    assert ((histogram - expected) ** 2 / expected).sum() < 40  # 15 degrees of freedom, p > 0.0005
    assert height.min() >= -1e-5
    assert height.max() <= 1 + 1e-5
    # What is sampled evenly in solid angle has the mean (1 + cos θ) / 2 along its axis.
    mean = direction.mean(axis=0)
    assert mean == pytest.approx(toward * (1 + np.cos(half)) / 2, abs=0.01)
    assert np.array(weight)[0] == pytest.approx(2 * np.pi * (1 - np.cos(half)), rel=1e-5)
