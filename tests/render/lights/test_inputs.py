from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from tests.render.lights.lamps import card, corners, irradiance, polygon, put, received, rect
from tests.render.stages import add_dome, picture
from weaveusd.render.lights import Lights
from weaveusd.render.model import Losses
from weaveusd.render.xforms import Placing


@pytest.mark.parametrize(
    ("kind", "name", "value", "said"),
    [
        ("RectLight", "intensity", float("nan"), "intensity is nan, expected a finite number"),
        ("RectLight", "intensity", -1.0, "emits (-1, -1, -1), expected 0 to 1e+30"),
        ("RectLight", "exposure", 1e30, "emits (inf, inf, inf), expected 0 to 1e+30"),
        ("RectLight", "color", (1.0, float("inf"), 1.0), "color is (1, inf, 1), expected finite"),
        ("RectLight", "width", -2.0, "width is -2, expected 0 or more"),
        ("RectLight", "height", 0.0, "light has no extent"),
        ("DiskLight", "radius", float("inf"), "radius is inf, expected a finite number"),
        ("SphereLight", "radius", 0.0, "light has no extent"),
        ("CylinderLight", "length", 0.0, "light has no extent"),
        ("DistantLight", "angle", -1.0, "angle is -1, expected 0 or more"),
        ("DomeLight", "exposure", float("-inf"), "exposure is -inf, expected a finite number"),
        ("DomeLight", "specular", float("nan"), "specular is nan, expected a finite number"),
    ],
)
def test_a_light_with_an_impossible_number_is_dropped_by_name(
    mi: Any, tmp_path: Path, kind: str, name: str, value: Any, said: str
) -> None:
    stage = card(tmp_path)
    light = stage.DefinePrim("/World/Light", kind)
    light.GetAttribute(f"inputs:{name}").Set(value)
    _, losses = irradiance(stage, 1)
    assert any(loss.startswith("/World/Light: ") and said in loss for loss in losses), losses
    assert any("a white dome lights it" in loss for loss in losses)


def test_a_color_temperature_that_is_no_number_ends_no_process(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    light = rect(stage)
    light.CreateEnableColorTemperatureAttr(True)
    light.CreateColorTemperatureAttr(float("nan"))
    put(light, at=(0, 0, 3))
    _, losses = irradiance(stage, 1)
    assert "/World/Light: colorTemperature is nan, expected a finite number (dropped)" in losses


def test_a_text_where_a_number_belongs_is_a_loss(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    text = '#usda 1.0\ndef RectLight "Light"\n{\n    string inputs:width = "wide"\n}\n'
    assert stage.GetRootLayer().ImportFromString(text)
    _, losses = picture(stage, 3, 1)
    assert "/Light: width is wide, expected a number (dropped)" in losses


def test_a_network_that_feeds_an_input_is_a_loss(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    dome = add_dome(stage)
    ramp = UsdShade.Shader.Define(stage, "/World/Ramp")
    output = ramp.CreateOutput("out", Sdf.ValueTypeNames.Color3f)
    UsdLux.LightAPI(dome).CreateInput("color", Sdf.ValueTypeNames.Color3f).ConnectToSource(output)
    assert "/World/Dome: network that feeds inputs:color (dropped)" in irradiance(stage, 1)[1]


def test_color_temperature_and_exposure_multiply(mi: Any, tmp_path: Path) -> None:
    """L = color · intensity · 2^exposure · blackbody, channel by channel."""
    stage = card(tmp_path)
    dome = add_dome(stage, 0.5)
    dome.CreateExposureAttr(2.0)
    dome.CreateColorAttr(Gf.Vec3f(0.2, 0.4, 0.8))
    dome.CreateEnableColorTemperatureAttr(True)
    found = {}
    for kelvin in (3000.0, 6500.0, 9000.0):
        dome.CreateColorTemperatureAttr(kelvin)
        found[kelvin], losses = received(stage, 256)
        assert losses == []
        tint = np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin)) * (0.2, 0.4, 0.8)
        assert found[kelvin] == pytest.approx(np.pi * 2 * tint, rel=0.01)
    ratio = found[3000.0][0] / found[3000.0][2] * found[9000.0][2] / found[9000.0][0]
    assert ratio > 5  # red against blue, warm against cool


def test_a_color_in_another_space_is_taken_to_rec709(mi: Any, tmp_path: Path) -> None:
    """srgb_texture: ((v + 0.055) / 1.055)^2.4; a space that nobody knows is named."""
    stage = card(tmp_path)
    dome = add_dome(stage)
    dome.CreateColorAttr(Gf.Vec3f(0.5, 0.5, 0.5)).SetColorSpace("srgb_texture")
    expected = np.pi * ((0.5 + 0.055) / 1.055) ** 2.4
    assert irradiance(stage, 256) == (pytest.approx(expected, rel=0.01), [])
    dome.GetColorAttr().ClearColorSpace()
    world = Usd.ColorSpaceAPI.Apply(stage.GetPrimAtPath("/World"))
    world.CreateColorSpaceNameAttr("srgb_rec709_scene")
    assert irradiance(stage, 256) == (pytest.approx(expected, rel=0.01), [])
    dome.GetColorAttr().SetColorSpace("mystery")
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(np.pi / 2, rel=0.01)
    assert losses == ["/World/Dome: color space mystery of color is unknown (approximated)"]


def test_a_color_beyond_rec709_is_clipped_and_said(mi: Any, tmp_path: Path) -> None:
    """The red primary of ACEScg has negative green and blue; its red is 1.7 times ours."""
    stage = card(tmp_path)
    dome = add_dome(stage)
    dome.CreateColorAttr(Gf.Vec3f(1, 0, 0)).SetColorSpace("lin_ap1_scene")
    found, losses = received(stage, 256)
    assert found == pytest.approx(np.pi * np.array((1.705, 0, 0)), rel=0.01)
    assert losses == ["/World/Dome: color beyond Rec.709 is clipped (approximated)"]


def test_multipliers_of_response_that_agree_dim_the_light(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    dome = add_dome(stage)
    dome.CreateDiffuseAttr(0.25)
    assert irradiance(stage, 64)[1] == [
        "/World/Dome: multipliers of response: diffuse 0.25, specular 1 (dropped)"
    ]
    dome.CreateSpecularAttr(0.25)
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(np.pi / 4, rel=0.01)
    assert losses == [
        "/World/Dome: diffuse and specular of 0.25 dim the light's own face too (approximated)"
    ]


@pytest.mark.parametrize(("frame", "intensity", "height"), [(1, 0.5, 3), (2, 1.25, 4), (3, 2, 5)])
def test_a_light_shines_as_it_does_at_the_frame_of_the_picture(
    mi: Any, tmp_path: Path, frame: float, intensity: float, height: float
) -> None:
    """Linear between its time samples, brightness and place."""
    stage = card(tmp_path)
    light = rect(stage)
    move = light.AddTranslateOp()
    for time, value, z in ((1, 0.5, 3.0), (3, 2.0, 5.0)):
        light.GetIntensityAttr().Set(value, time)
        move.Set(Gf.Vec3d(0, 0, z), time)
    panel = [(-2, -1, height), (2, -1, height), (2, 1, height), (-2, 1, height)]
    found, losses = irradiance(stage, frame=frame)
    assert found == pytest.approx(intensity * polygon(panel), rel=0.01)
    assert losses == []


def test_an_invisible_light_is_dark(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    add_dome(stage)
    UsdGeom.Xform.Define(stage, "/World/Group").CreateVisibilityAttr("invisible")
    UsdLux.DistantLight.Define(stage, "/World/Group/Sun")
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(np.pi, rel=0.01)
    assert losses == []


def test_an_input_of_old_files_without_its_prefix_is_read_and_named(
    mi: Any, tmp_path: Path
) -> None:
    stage = card(tmp_path)
    light = rect(stage)
    light.GetPrim().CreateAttribute("intensity", Sdf.ValueTypeNames.Float).Set(3.0)
    world = put(light, at=(0, 0, 3))
    found, losses = irradiance(stage)
    assert found == pytest.approx(3 * polygon(corners(world, 4, 2)), rel=0.01)
    assert losses == ["/World/Light: intensity is read as inputs:intensity (approximated)"]


# --- Whatever a stage says ----------------------------------------------------------------------

KINDS = ("RectLight", "DiskLight", "SphereLight", "CylinderLight", "DistantLight", "DomeLight",
         "DomeLight_1", "GeometryLight", "PortalLight", "PluginLight")  # fmt: skip
APIS = ("ShapingAPI", "ShadowAPI")
NUMBERS = st.sampled_from([0.0, -1.0, 1e-30, 1e30, 3e38, float("nan"), float("inf"), 90.0, 400.0])


@settings(
    max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.sampled_from(KINDS), st.data())
def test_no_value_of_an_input_ends_a_translation(mi: Any, kind: str, data: Any) -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/Light", kind)
    for api in APIS:
        prim.ApplyAPI(api)
    names = [a.GetName() for a in prim.GetAttributes() if a.GetName().startswith("inputs:")]
    for name in data.draw(st.lists(st.sampled_from(names), max_size=4, unique=True)):
        attribute = prim.GetAttribute(name)
        type_name = str(attribute.GetTypeName())
        value = data.draw(NUMBERS)
        made = {
            "float": value,
            "bool": True,
            "color3f": Gf.Vec3f(value, 1, value),
            "asset": Sdf.AssetPath("./nowhere"),
            "token": "nonsense",
        }
        attribute.Set(made[type_name])
    xform = UsdGeom.Xformable(prim)
    if xform:
        xform.AddScaleOp().Set(Gf.Vec3f(data.draw(NUMBERS), 1, 1))
    losses = Losses()
    lights = Lights(stage, losses)
    lights.add(prim, Placing(1.0, Usd.TimeCode.Default()))
    for entry in lights.entries():
        if isinstance(entry, dict):
            mi.load_dict(entry)
    assert lights.found or losses.as_tuple() or kind == "GeometryLight"
