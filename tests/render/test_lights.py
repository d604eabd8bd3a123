from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdLux

from tests.render.stages import add_camera, add_dome, add_mesh, new_stage, picture, write_image

ALBEDO = 0.5


def card(tmp_path: Path, up: str = "Y") -> Any:
    """A gray card that faces +z, seen from there."""
    stage = new_stage(tmp_path / "scene.usda", up)
    add_mesh(stage, color=(ALBEDO,) * 3)
    add_camera(stage, fov=2)
    return stage


def irradiance(stage: Any, spp: int = 1024) -> tuple[float, list[str]]:
    """Irradiance at the middle of the card, from its known albedo."""
    image, losses = picture(stage, 5, spp)
    return float(image[1:4, 1:4].mean()) * np.pi / ALBEDO, losses


def test_a_constant_dome_lights_with_pi_times_its_radiance(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    add_dome(stage, 0.7)
    found, losses = irradiance(stage)
    assert found == pytest.approx(np.pi * 0.7, rel=0.01)
    assert losses == []


@pytest.mark.parametrize("normalize", [False, True])
def test_a_rect_light_is_as_bright_as_its_form_factor_says(
    mi: Any, tmp_path: Path, normalize: bool
) -> None:
    stage, width, height, distance = card(tmp_path), 4.0, 2.0, 3.0
    light = UsdLux.RectLight.Define(stage, "/World/Light")
    light.AddTranslateOp().Set((0.0, 0.0, distance))
    light.AddScaleOp().Set((2.0, 2.0, 1.0))
    light.CreateWidthAttr(width / 2)
    light.CreateHeightAttr(height / 2)
    light.CreateIntensityAttr(3.0)
    light.CreateExposureAttr(1.0)
    light.CreateNormalizeAttr(normalize)
    stage.GetPrimAtPath("/World/Camera").GetAttribute("xformOp:translate").Set((0, 0, 2.5))
    # Four times the form factor of a corner at distance d: Lambert's formula for a rectangle.
    a, b = width / 2 / distance, height / 2 / distance
    factor = (
        4
        / (2 * np.pi)
        * sum(
            x / np.sqrt(1 + x * x) * np.arctan(y / np.sqrt(1 + x * x)) for x, y in ((a, b), (b, a))
        )
    )
    radiance = 3.0 * 2.0 / (width * height if normalize else 1)
    found, losses = irradiance(stage)
    assert found == pytest.approx(radiance * np.pi * factor, rel=0.01)
    assert losses == []


def test_a_rect_light_shines_along_minus_z_only(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    light = UsdLux.RectLight.Define(stage, "/World/Light")
    light.AddTranslateOp().Set((0.0, 0.0, 20.0))
    light.AddRotateYOp().Set(180.0)
    found, _ = irradiance(stage, 16)
    assert found == 0


@pytest.mark.parametrize("normalize", [False, True])
def test_a_disk_light_is_as_bright_as_its_form_factor_says(
    mi: Any, tmp_path: Path, normalize: bool
) -> None:
    stage = card(tmp_path)
    light = UsdLux.DiskLight.Define(stage, "/World/Light")
    light.AddTranslateOp().Set((0.0, 0.0, 20.0))
    light.CreateRadiusAttr(5.0)
    light.CreateIntensityAttr(3.0)
    light.CreateNormalizeAttr(normalize)
    radiance = 3.0 / (np.pi * 25 if normalize else 1)
    found, _ = irradiance(stage)
    assert found == pytest.approx(np.pi * radiance * 25 / (25 + 400), rel=0.01)


@pytest.mark.parametrize("normalize", [False, True])
def test_a_sphere_light_obeys_the_inverse_square(mi: Any, tmp_path: Path, normalize: bool) -> None:
    stage = card(tmp_path)
    light = UsdLux.SphereLight.Define(stage, "/World/Light")
    light.AddTranslateOp().Set((0.0, 0.0, 20.0))
    light.AddScaleOp().Set((2.0, 2.0, 2.0))
    light.CreateRadiusAttr(1.0)
    light.CreateIntensityAttr(3.0)
    light.CreateNormalizeAttr(normalize)
    radiance = 3.0 / (4 * np.pi * 4 if normalize else 1)
    found, _ = irradiance(stage)
    assert found == pytest.approx(np.pi * radiance * (2 / 20) ** 2, rel=0.01)


@pytest.mark.parametrize(("angle", "normalize"), [(0.0, False), (10.0, True), (10.0, False)])
def test_a_distant_light_gives_the_irradiance_that_usd_defines(
    mi: Any, tmp_path: Path, angle: float, normalize: bool
) -> None:
    stage = card(tmp_path)
    light = UsdLux.DistantLight.Define(stage, "/World/Light")
    light.AddRotateXOp().Set(60.0)
    light.CreateIntensityAttr(3.0)
    light.CreateAngleAttr(angle)
    light.CreateNormalizeAttr(normalize)
    cap = np.pi * np.sin(np.radians(angle / 2)) ** 2 if angle and not normalize else 1.0
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(3.0 * cap * 0.5, rel=0.01)
    assert losses == []


def test_color_and_temperature_tint_a_light(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    dome = add_dome(stage)
    dome.CreateColorAttr(Gf.Vec3f(0.2, 0.4, 0.8))
    dome.CreateEnableColorTemperatureAttr(True)
    dome.CreateColorTemperatureAttr(3000.0)
    image, _ = picture(stage, 5, 256)
    tint = np.array(UsdLux.BlackbodyTemperatureAsRgb(3000.0)) * (0.2, 0.4, 0.8)
    assert image.mean(axis=(0, 1)) == pytest.approx(ALBEDO * tint, rel=0.02)


# A lat-long picture seen from inside: its middle is +z, a quarter to the left +x, the top +y.
MARKS = {"+z": (0.5, 0.5), "+x": (0.25, 0.5), "-x": (0.75, 0.5), "+y": (0.5, 0.02)}
LOOKING = {"+z": (0, 180), "+x": (0, -90), "-x": (0, 90), "+y": (90, 0)}


def marked_dome(tmp_path: Path, mark: str, up: str, kind: str = "DomeLight") -> Any:
    """A dome that is dark but for one place, and a camera that looks along -z."""
    stage = new_stage(tmp_path / "scene.usda", up)
    pixels = np.full((64, 128, 3), 1e-4, np.float32)
    column, row = int(MARKS[mark][0] * 128), int(MARKS[mark][1] * 64)
    if mark == "+y":
        pixels[:3] = 1.0
    else:
        pixels[row - 3 : row + 3, column - 3 : column + 3] = 1.0
    write_image(tmp_path / "dome.exr", pixels)
    dome = stage.DefinePrim("/World/Dome", kind)
    dome.CreateAttribute("inputs:texture:file", Sdf.ValueTypeNames.Asset).Set("./dome.exr")
    camera = add_camera(stage, distance=0.0, fov=4)
    return stage, camera


@pytest.mark.parametrize("mark", list(MARKS))
def test_a_dome_picture_hangs_where_usd_says(mi: Any, tmp_path: Path, mark: str) -> None:
    stage, camera = marked_dome(tmp_path, mark, "Y")
    pitch, yaw = LOOKING[mark]
    camera.AddRotateYOp().Set(float(yaw))
    camera.AddRotateXOp().Set(float(pitch))
    image, _ = picture(stage, 5, 16)
    assert image[2, 2] == pytest.approx([1, 1, 1], abs=0.02)
    camera.GetPrim().GetAttribute("xformOp:rotateY").Set(float(yaw) + 37)
    camera.GetPrim().GetAttribute("xformOp:rotateX").Set(float(pitch) - 40)
    assert picture(stage, 5, 16)[0][2, 2].max() < 0.01


@pytest.mark.parametrize(
    ("up", "kind", "pole", "brightest"),
    [
        ("Z", "DomeLight", None, "y"),  # a plain dome stands on Y in any stage
        ("Z", "DomeLight_1", "scene", "z"),
        ("Y", "DomeLight_1", "Z", "z"),
        ("Z", "DomeLight_1", "Y", "y"),
    ],
)
def test_the_top_of_a_dome_points_along_its_pole(
    mi: Any, tmp_path: Path, up: str, kind: str, pole: str | None, brightest: str
) -> None:
    stage, camera = marked_dome(tmp_path, "+y", up, kind)
    if pole:
        stage.GetPrimAtPath("/World/Dome").GetAttribute("poleAxis").Set(pole)
    turn = {"y": (90.0, 0.0), "z": (180.0, 0.0)}[brightest]
    camera.AddRotateXOp().Set(turn[0])
    assert picture(stage, 5, 16)[0][2, 2].min() > 0.9


def test_a_turned_dome_turns_its_picture(mi: Any, tmp_path: Path) -> None:
    stage, _ = marked_dome(tmp_path, "+x", "Y")
    # The mark on +x comes to -z, where the camera looks, by a quarter turn about +y.
    UsdLux.DomeLight(stage.GetPrimAtPath("/World/Dome")).AddRotateYOp().Set(90.0)
    assert picture(stage, 5, 16)[0][2, 2].min() > 0.9


def test_a_stage_without_light_gets_a_white_dome_and_a_loss(mi: Any, tmp_path: Path) -> None:
    image, losses = picture(card(tmp_path), 5, 64)
    assert image.mean() == pytest.approx(ALBEDO, rel=0.02)
    assert losses == ["/: stage has no light: a white dome lights it (approximated)"]


def test_a_light_of_another_renderer_is_reported(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    add_dome(stage)
    light = stage.DefinePrim("/World/Foreign", "PluginLight")
    light.GetAttribute("info:id").Set("PxrEnvDayLight")
    _, losses = picture(stage, 5, 1)
    assert losses == ["/World/Foreign: PluginLight PxrEnvDayLight is another renderer's (dropped)"]
