from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdLux

from tests.render.lights.lamps import card, disk_beside, irradiance, polygon, put, rect
from tests.render.stages import add_camera, add_dome, new_stage, picture, write_image
from weaveusd.render.lights import Lights, domes, pictures
from weaveusd.render.model import Losses
from weaveusd.render.xforms import Placing


def lamps(stage: Any) -> Any:
    """A lamp that shines down, and a place for copies of it."""
    light = UsdLux.SphereLight.Define(stage, "/Lamp/Bulb")
    light.CreateRadiusAttr(0.25)
    return light


def test_a_light_inside_instances_shines_at_each_of_them(mi: Any, tmp_path: Path) -> None:
    """E = π L Σ (r / d)² cos θ."""
    stage = card(tmp_path)
    stage.CreateClassPrim("/Lamp")
    lamps(stage)
    places = ((0.0, 0.0, 3.0), (2.0, 0.0, 4.0), (-2.0, 1.0, 5.0))
    for k, place in enumerate(places):
        copy = UsdGeom.Xform.Define(stage, f"/World/Copy{k}")
        copy.AddTranslateOp().Set(place)
        copy.GetPrim().GetReferences().AddInternalReference("/Lamp")
        copy.GetPrim().SetInstanceable(True)
    distances = np.linalg.norm(places, axis=1)
    expected = np.pi * sum(
        0.25**2 / d**3 * z for d, (_, _, z) in zip(distances, places, strict=True)
    )
    found, losses = irradiance(stage, 8192)
    assert found == pytest.approx(expected, rel=0.01)
    assert losses == []


def test_a_light_in_a_point_instancer_shines_at_each_place(mi: Any, tmp_path: Path) -> None:
    """Each place, size and turn counts; the copy that is turned away gives nothing."""
    stage = card(tmp_path)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/Many")
    light = UsdLux.DiskLight.Define(stage, "/World/Many/Lamp")
    light.CreateRadiusAttr(0.1)
    instancer.CreatePrototypesRel().AddTarget(light.GetPath())
    instancer.CreateProtoIndicesAttr([0, 0, 0])
    instancer.CreatePositionsAttr([(0, 0, 3), (2, 0, 4), (-2, 0, 2)])
    instancer.CreateScalesAttr([(1, 1, 1), (3, 3, 3), (1, 1, 1)])
    upright, turned = Gf.Quath(1, 0, 0, 0), Gf.Quath(0, 1, 0, 0)
    instancer.CreateOrientationsAttr([upright, upright, turned])
    found, losses = irradiance(stage, 8192)
    assert found == pytest.approx(disk_beside(0.1, 3, 0) + disk_beside(0.3, 4, 2), rel=0.01)
    assert losses == []


LAMPS = ("Panel", "Disk", "Ball", "Tube", "Egg")


def one_above_the_other(stage: Any) -> dict[str, Any]:
    """Lamps in line over the card, a sun, a point and a dome behind them all."""
    made = {
        "Panel": UsdLux.RectLight.Define(stage, "/World/Panel"),
        "Disk": UsdLux.DiskLight.Define(stage, "/World/Disk"),
        "Ball": UsdLux.SphereLight.Define(stage, "/World/Ball"),
        "Tube": UsdLux.CylinderLight.Define(stage, "/World/Tube"),
        "Egg": UsdLux.SphereLight.Define(stage, "/World/Egg"),
    }
    for k, light in enumerate(made.values()):
        put(light, at=(0, 0, 2 + k), scale=(1, 1, 0.5) if k == 4 else (1, 1, 1))
    point = made["Point"] = UsdLux.SphereLight.Define(stage, "/World/Point")
    put(point, at=(0, 0, 7))
    point.CreateRadiusAttr(0.2)
    point.CreateTreatAsPointAttr(True)
    sun = made["Sun"] = UsdLux.DistantLight.Define(stage, "/World/Sun")
    sun.CreateAngleAttr(1.0)
    sun.CreateIntensityAttr(100.0)
    made["Dome"] = add_dome(stage, 0.05)
    return made


@pytest.mark.parametrize("rear", ["Sun", "Point", "Dome", "Egg"])
def test_lights_stand_in_the_way_of_no_other(mi: Any, tmp_path: Path, rear: str) -> None:
    """What lights give together is the sum of what each gives alone."""
    stage = card(tmp_path)
    made = one_above_the_other(stage)
    for light in made.values():
        light.MakeInvisible()
    total = 0.0
    shown = {*LAMPS, rear}
    for name in shown:
        made[name].MakeVisible()
        total += irradiance(stage, 8192)[0]
        made[name].MakeInvisible()
    for name in shown:
        made[name].MakeVisible()
    together, losses = irradiance(stage, 32768)
    assert together == pytest.approx(total, rel=0.015)
    assert losses == []


def test_a_lamp_is_clear_from_behind_and_shines_over_what_is_there(mi: Any, tmp_path: Path) -> None:
    stage = new_stage(tmp_path / "scene.usda")
    add_dome(stage, 0.25)
    panel = UsdLux.RectLight.Define(stage, "/World/Panel")
    panel.CreateWidthAttr(9.0)
    panel.CreateHeightAttr(9.0)
    panel.CreateIntensityAttr(8.0)
    turn = panel.AddRotateYOp()
    add_camera(stage, distance=5.0, fov=10)
    for degrees, seen in ((0.0, 0.25), (180.0, 8.25)):
        turn.Set(degrees)
        image, _ = picture(stage, 3, 16)
        assert image == pytest.approx(np.full((3, 3, 3), seen), rel=1e-3)


def test_copies_of_a_light_share_its_file_and_its_losses(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    write_image(tmp_path / "half.exr", np.ones((8, 8, 3), np.float32))
    light = rect(stage)
    light.CreateTextureFileAttr("./half.exr")
    light.CreateFiltersRel().AddTarget("/World/Barn")
    losses = Losses()
    lights = Lights(stage, losses)
    for _ in range(3):
        lights.add(light.GetPrim(), Placing(1.0, Usd.TimeCode.Default()))
    *made, night = lights.entries()
    assert len(made) == 3
    assert night["sampling_weight"] == 0
    assert len({id(entry["emitter"]["radiance"]) for entry in made}) == 1
    assert [str(loss) for loss in losses.as_tuple()] == [
        "/World/Light: light filter /World/Barn (dropped)"
    ]


def test_pictures_beyond_their_bound_are_halved(
    mi: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pictures, "MAX_TEXELS", 40)
    stage = card(tmp_path)
    pixels = np.zeros((8, 16, 3), np.float32)
    pixels[:, ::2] = 1.0
    write_image(tmp_path / "dome.exr", pixels)
    add_dome(stage).CreateTextureFileAttr("./dome.exr")
    found, losses = irradiance(stage, 1024)
    assert found == pytest.approx(np.pi / 2, rel=0.01)
    assert losses == [
        "/World/Dome: texture is halved until it has at most 40 texels (approximated)"
    ]


def test_pictures_beyond_their_memory_are_refused(
    mi: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pictures, "MAX_BYTES", 100)
    stage = card(tmp_path)
    write_image(tmp_path / "half.exr", np.ones((8, 8, 3), np.float32))
    light = rect(stage)
    light.CreateTextureFileAttr("./half.exr")
    put(light, at=(0, 0, 3))
    found, losses = irradiance(stage)
    corners = [(-2, -1, 3), (2, -1, 3), (2, 1, 3), (-2, 1, 3)]
    assert found == pytest.approx(polygon(corners), rel=0.01)
    assert len(losses) == 1
    assert "takes 768 bytes" in losses[0]


def test_more_pictured_domes_than_are_added_up_are_a_loss(
    mi: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import weaveusd.render.lights as package

    monkeypatch.setattr(package, "MAX_PICTURED", 2)
    assert domes.MAX_PICTURED >= 2
    stage = card(tmp_path)
    write_image(tmp_path / "dome.exr", np.ones((8, 16, 3), np.float32))
    for k in range(3):
        dome = UsdLux.DomeLight.Define(stage, f"/World/Dome{k}")
        dome.CreateTextureFileAttr("./dome.exr")
    found, losses = irradiance(stage, 1024)
    assert found == pytest.approx(2 * np.pi, rel=0.01)
    assert losses == ["/World/Dome2: 2 domes with pictures are shown already (dropped)"]
