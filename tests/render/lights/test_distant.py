from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import UsdLux

from tests.render.lights.lamps import card, irradiance, put, shaped
from tests.render.stages import add_mesh, picture
from weaveusd.render.lights.distant import size


def sun(stage: Any, angle: float, intensity: float = 3.0) -> Any:
    light = UsdLux.DistantLight.Define(stage, "/World/Sun")
    light.CreateAngleAttr(angle)
    light.CreateIntensityAttr(intensity)
    return light


@pytest.mark.parametrize("angle", [0.0, 0.53, 10.0, 50.0])
@pytest.mark.parametrize("normalize", [False, True])
def test_a_sun_gives_pi_l_times_its_squared_sine_and_the_cosine(
    mi: Any, tmp_path: Path, angle: float, normalize: bool
) -> None:
    """E = π L sin²θ cos α, θ half the angle; with normalize, or parallel, E = I cos α."""
    stage = card(tmp_path)
    light = sun(stage, angle)
    light.CreateNormalizeAttr(normalize)
    put(light, turn=(60, 0, 0))
    parallel = normalize or angle == 0
    cap = 1.0 if parallel else np.pi * np.sin(np.radians(angle / 2)) ** 2
    found, losses = irradiance(stage, 4096)
    assert found == pytest.approx(3 * cap * 0.5, rel=0.01)
    assert losses == []


def test_a_sun_of_half_the_sky_gives_pi_l(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    sun(stage, 180.0)
    assert irradiance(stage, 16384)[0] == pytest.approx(3 * np.pi, rel=0.01)


def test_a_sun_wider_than_half_the_sky_is_divided_by_both_of_its_faces() -> None:
    """size = π (2 - sin²θ) beyond θ = π/2, which meets π sin²θ there and ends at 2π."""
    assert size(np.pi / 2) == pytest.approx(np.pi)
    assert size(np.pi / 2 + 1e-6) == pytest.approx(np.pi)
    assert size(np.pi * 0.75) == pytest.approx(1.5 * np.pi)


def test_a_sun_keeps_the_schemas_intensity_and_angle(mi: Any, tmp_path: Path) -> None:
    """50000 and 0.53°: E = 50000 π sin²(0.265°)."""
    stage = card(tmp_path)
    UsdLux.DistantLight.Define(stage, "/World/Sun")
    expected = 50000 * np.pi * np.sin(np.radians(0.265)) ** 2
    assert irradiance(stage, 256)[0] == pytest.approx(expected, rel=0.01)


def test_a_sun_casts_the_half_shadow_that_its_angle_makes(mi: Any, tmp_path: Path) -> None:
    """Under the straight edge of a shade h above, at x aside of it, the visible part of a disk.

    With t = x / (h tan θ) in -1…1, the part of a disk beyond a chord at t is
    (arccos t - t √(1 - t²)) / π; near the axis a disk of directions is one of tangents.
    """
    stage = card(tmp_path)
    height, half = 1.0, np.radians(5.0)
    sun(stage, 10.0, 1 / (np.pi * np.sin(half) ** 2))
    # The shade covers x < edge, so the part of the sun at smaller x is hidden.
    for t in (-0.6, 0.0, 0.5):
        edge = t * height * np.tan(half)
        square = [(-9, -9, height), (edge, -9, height), (edge, 9, height), (-9, 9, height)]
        add_mesh(stage, "/World/Shade", points=square, color=(0, 0, 0))
        seen = (np.arccos(t) - t * np.sqrt(1 - t * t)) / np.pi
        camera = stage.GetPrimAtPath("/World/Camera")
        camera.GetAttribute("xformOp:translate").Set((0, 0, 0.5))
        camera.GetAttribute("focalLength").Set(2000.0)
        found, _ = irradiance(stage, 16384)
        assert found == pytest.approx(seen, abs=0.01)


def test_a_sun_sees_through_the_gaps_of_what_lets_light_pass(mi: Any, tmp_path: Path) -> None:
    """A shade of opacity 1/2 halves it, although only shadow rays find a sun."""
    from tests.render.stages import bind, preview_material

    stage = card(tmp_path)
    put(sun(stage, 2.0, 1 / (np.pi * np.sin(np.radians(1)) ** 2)), turn=(40, 0, 0))
    square = [(-9, -9, 3), (9, -9, 3), (9, 9, 3), (-9, 9, 3)]
    shade = add_mesh(stage, "/World/Shade", points=square)
    material, _ = preview_material(
        stage, "/World/Veil", diffuseColor=(0.0, 0.0, 0.0), opacity=0.5, ior=1.0
    )
    bind(shade, material)
    found, _ = irradiance(stage, 4096)
    assert found == pytest.approx(0.5 * np.cos(np.radians(40)), rel=0.02)


def test_a_sun_shines_along_minus_z_from_behind_nothing(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    put(sun(stage, 1.0), turn=(180, 0, 0))
    assert irradiance(stage, 16)[0] == 0


def test_the_shaping_of_a_sun_is_a_loss(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    light = shaped(sun(stage, 1.0))
    assert picture(stage, 3, 1)[1] == []  # the cone of the schema, which exporters like to write
    shaped(light, cone_angle=20.0)
    _, losses = picture(stage, 3, 1)
    assert losses == ["/World/Sun: shaping of a light without a place (dropped)"]
