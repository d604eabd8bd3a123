from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdLux

from tests.render.lights.lamps import card, irradiance, put, received, shaped


def wide_disk(stage: Any, **shaping: Any) -> Any:
    """A disk so wide that a cone of 60 degrees ends inside of it."""
    light = UsdLux.DiskLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(8.0)
    put(light, at=(0, 0, 3))
    return shaped(light, **shaping)


def small_sphere(stage: Any, degrees: float, **shaping: Any) -> tuple[Any, float]:
    """A small sphere that shines `degrees` past the card, and what it gives unshaped."""
    light = UsdLux.SphereLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.05)
    put(light, at=(0, 0, 4), turn=(0, degrees, 0))
    return shaped(light, **shaping), np.pi * (0.05 / 4) ** 2


@pytest.mark.parametrize("cone", [15.0, 40.0, 60.0])
def test_a_wide_disk_behind_a_cone_gives_pi_l_times_the_cones_squared_sine(
    mi: Any, tmp_path: Path, cone: float
) -> None:
    stage = card(tmp_path)
    wide_disk(stage, cone_angle=cone)
    found, losses = irradiance(stage, 65536)
    assert found == pytest.approx(np.pi * np.sin(np.radians(cone)) ** 2, rel=0.01)
    assert losses == []


@pytest.mark.parametrize("focus", [1.0, 6.0])
def test_a_focus_is_a_power_of_the_cosine(mi: Any, tmp_path: Path, focus: float) -> None:
    """E = L ∫ cos^f θ cos θ dω = 2π L (1 - cos^(f+2) θ_max) / (f + 2) under a disk."""
    stage = card(tmp_path)
    wide_disk(stage, focus=focus)
    edge = 3 / np.sqrt(9 + 64)
    expected = 2 * np.pi * (1 - edge ** (focus + 2)) / (focus + 2)
    assert irradiance(stage, 16384)[0] == pytest.approx(expected, rel=0.01)


def test_a_focus_tint_is_what_the_light_turns_to_off_its_axis(mi: Any, tmp_path: Path) -> None:
    """lerp(tint, 1, |cos θ|^f), channel by channel."""
    stage = card(tmp_path)
    _, plain = small_sphere(stage, 50.0, focus=2.0, focus_tint=Gf.Vec3f(1, 0.5, 0), cone_angle=90.0)
    power = np.cos(np.radians(50)) ** 2
    tint = np.array([1, 0.5, 0])
    found, losses = received(stage, 256)
    assert found == pytest.approx(plain * (tint + (1 - tint) * power), rel=0.01)
    assert losses == []


@pytest.mark.parametrize("degrees", [10.0, 20.0, 26.0, 34.0, 43.0])
def test_a_soft_cone_fades_by_a_smoothstep(mi: Any, tmp_path: Path, degrees: float) -> None:
    """1 - s²(3 - 2s), s = (θ - θ_start) / (θ_cone - θ_start), θ_start = (1 - softness) θ_cone."""
    stage = card(tmp_path)
    _, plain = small_sphere(stage, degrees, cone_angle=40.0, cone_softness=0.5)
    s = np.clip((degrees - 20) / 20, 0, 1)
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(plain * (1 - s * s * (3 - 2 * s)), rel=0.015, abs=1e-9)
    assert losses == []


@pytest.mark.parametrize(("degrees", "share"), [(0.0, 1.0), (28.0, 1.0), (32.0, 0.0), (180.0, 0.0)])
def test_a_hard_cone_lets_everything_pass_inside_and_nothing_outside(
    mi: Any, tmp_path: Path, degrees: float, share: float
) -> None:
    stage = card(tmp_path)
    _, plain = small_sphere(stage, degrees, cone_angle=30.0)
    assert irradiance(stage, 256)[0] == pytest.approx(plain * share, rel=0.01)


def test_a_cone_of_the_schema_hides_the_rear_half_of_a_sphere(mi: Any, tmp_path: Path) -> None:
    """90 degrees where ShapingAPI applies, none where it does not."""
    stage = card(tmp_path)
    light, plain = small_sphere(stage, 180.0)
    assert irradiance(stage, 256)[0] == 0
    light.GetPrim().RemoveAPI(UsdLux.ShapingAPI)
    assert irradiance(stage, 256)[0] == pytest.approx(plain, rel=0.01)


def test_a_focus_shines_backwards_where_the_cone_lets_it(mi: Any, tmp_path: Path) -> None:
    """The cosine counts by its absolute value."""
    stage = card(tmp_path)
    _, plain = small_sphere(stage, 150.0, focus=3.0, cone_angle=180.0)
    expected = plain * np.cos(np.radians(30)) ** 3
    assert irradiance(stage, 256)[0] == pytest.approx(expected, rel=0.01)


def test_a_shaped_point_is_a_spot(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    light, plain = small_sphere(stage, 20.0, cone_angle=30.0, focus=4.0)
    light.CreateTreatAsPointAttr(True)
    found, losses = irradiance(stage, 16)
    assert found == pytest.approx(plain * np.cos(np.radians(20)) ** 4, rel=1e-3)
    assert losses == []
    light.GetPrim().GetAttribute("inputs:shaping:cone:angle").Set(15.0)
    assert irradiance(stage, 16)[0] == 0


@pytest.mark.parametrize("scale", [(1, 1, 3), (-2, 2, 2), (3, 1, 1)])
def test_the_axis_of_shaping_is_the_lights_own_under_any_scale(
    mi: Any, tmp_path: Path, scale: Any
) -> None:
    stage = card(tmp_path)
    light = UsdLux.DiskLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.02)
    light.CreateNormalizeAttr(True)
    put(light, at=(0, 0, 4), turn=(0, 25, 0), scale=scale)
    shaped(light, focus=2.0)
    cosine = np.cos(np.radians(25))
    assert irradiance(stage, 256)[0] == pytest.approx(cosine * cosine**2 / 16, rel=0.01)


def test_an_old_file_is_shaped_without_the_prefix(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    light, _ = small_sphere(stage, 20.0)
    light.GetPrim().RemoveAPI(UsdLux.ShapingAPI)
    prim = light.GetPrim()
    prim.CreateAttribute("shaping:cone:angle", Sdf.ValueTypeNames.Float).Set(15.0)
    found, losses = irradiance(stage, 16)
    assert found == 0
    assert losses == [
        "/World/Light: shaping:cone:angle is read as inputs:shaping:cone:angle (approximated)"
    ]


def test_a_shaped_light_is_seen_as_bright_as_it_shines(mi: Any, tmp_path: Path) -> None:
    """Rays that a surface sends out find it as shadow rays do: both kinds of sample agree."""
    import mitsuba

    stage = card(tmp_path)
    light = wide_disk(stage, focus=2.0, cone_angle=50.0, cone_softness=0.3)
    assert light
    from weaveusd.render.translate import translate

    scene = translate(stage, width=3, height=3).scene
    found = []
    for kind in (
        {"emitter_samples": 0, "bsdf_samples": 1},
        {"emitter_samples": 1, "bsdf_samples": 0},
    ):
        integrator = mitsuba.load_dict({"type": "direct"} | kind)
        image = np.array(mitsuba.render(scene, integrator=integrator, spp=16384, seed=1))
        found.append(image.mean())
    assert found[0] == pytest.approx(found[1], rel=0.01)
