"""One moment of a stage that moves, and what of it is drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from pxr import Gf, UsdGeom, UsdLux, UsdUtils

import weaveusd
from tests.render.stages import add_mesh, domed_stage, middle, picture
from weaveusd.errors import InputError

RED, GREEN = (0.8, 0.1, 0.1), (0.1, 0.8, 0.1)


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return domed_stage(tmp_path)


def test_points_colors_and_transforms_are_those_of_the_frame(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage)
    color = mesh.CreateDisplayColorAttr()
    color.Set([Gf.Vec3f(*RED)], 1)
    color.Set([Gf.Vec3f(*GREEN)], 3)
    move = mesh.AddTranslateOp()
    move.Set((0, 0, 0), 3)
    move.Set((9, 0, 0), 4)
    points = mesh.GetPointsAttr()
    still = points.Get()
    points.Clear()
    points.Set(still, 4)
    points.Set([p - Gf.Vec3f(9, 0, 0) for p in still], 5)
    assert middle(stage, frame=1)[0] == pytest.approx(RED, rel=0.03)
    assert middle(stage, frame=2)[0] == pytest.approx((0.45, 0.45, 0.1), rel=0.03)
    assert middle(stage, frame=3)[0] == pytest.approx(GREEN, rel=0.03)
    assert middle(stage, frame=4)[0] == pytest.approx((1, 1, 1))
    assert middle(stage, frame=5)[0] == pytest.approx(GREEN, rel=0.03)
    assert middle(stage, frame=99)[0] == pytest.approx(GREEN, rel=0.03)


def test_visibility_and_lights_are_those_of_the_frame(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, color=RED)
    seen = UsdGeom.Imageable(mesh).CreateVisibilityAttr()
    seen.Set("inherited", 1)
    seen.Set("invisible", 2)
    dome = UsdLux.DomeLight(stage.GetPrimAtPath("/World/Dome")).GetIntensityAttr()
    dome.Set(1.0, 1)
    dome.Set(3.0, 3)
    assert middle(stage, frame=1)[0] == pytest.approx(RED, rel=0.03)
    assert middle(stage, frame=2)[0] == pytest.approx((2, 2, 2))
    assert middle(stage, frame=3)[0] == pytest.approx((3, 3, 3))


def test_only_what_moves_is_called_animation(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, color=RED)
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(100)
    assert middle(stage)[1] == []
    move = mesh.AddTranslateOp()
    move.Set((0, 0, 0), 1)
    move.Set((0, 0, 0), 2)
    assert middle(stage)[1] == []
    move.Set((0.01, 0, 0), 3)
    assert middle(stage)[1] == ["/: animation is shown at its first moment (approximated)"]
    assert middle(stage, frame=1)[1] == []


def test_purposes_are_drawn_as_asked_for(mi: Any, stage: Any) -> None:
    group = UsdGeom.Xform.Define(stage, "/World/Group")
    group.CreatePurposeAttr("guide")
    add_mesh(stage, "/World/Group/Card", color=RED)
    other = add_mesh(stage, "/World/Group/Other", color=GREEN)
    other.AddTranslateOp().Set((0, 0, 0.1))
    other.CreatePurposeAttr("proxy")
    white = pytest.approx((1, 1, 1))
    assert middle(stage)[0] == white
    assert middle(stage, purposes=("guide",))[0] == pytest.approx(RED, rel=0.03)
    assert middle(stage, purposes=("proxy",))[0] == pytest.approx(GREEN, rel=0.03)
    assert middle(stage, purposes=("guide", "proxy", "render"))[0] == pytest.approx(GREEN, rel=0.03)
    assert middle(stage, purposes=())[0] == white


def test_a_purpose_can_be_hidden_by_its_own_visibility(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, color=RED)
    mesh.CreatePurposeAttr("render")
    assert middle(stage)[0] == pytest.approx(RED, rel=0.03)
    UsdGeom.VisibilityAPI.Apply(mesh.GetPrim()).CreateRenderVisibilityAttr("invisible")
    assert middle(stage)[0] == pytest.approx((1, 1, 1))


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usdz"])
def test_every_kind_of_file_is_read(mi: Any, stage: Any, tmp_path: Path, suffix: str) -> None:
    add_mesh(stage, color=RED)
    flat = tmp_path / "flat.usdc"
    stage.Export(str(flat))
    file = flat
    if suffix == ".usda":
        file = tmp_path / "flat.usda"
        stage.Export(str(file))
    elif suffix == ".usdz":
        file = tmp_path / "flat.usdz"
        assert UsdUtils.CreateNewUsdzPackage(str(flat), str(file))
    result = weaveusd.render(file, width=9, height=9, spp=64)
    assert result.image[4, 4] == pytest.approx(RED, rel=0.1)
    assert result.losses == ()


def test_a_loss_that_many_share_is_told_once_and_counted(mi: Any, stage: Any) -> None:
    for k in range(12):
        UsdGeom.NurbsPatch.Define(stage, f"/World/Patch{k}")
    stage.DefinePrim("/World/Smoke", "Volume")
    _, losses = picture(stage, 4, 1)
    assert losses == [
        "/World/Patch0, and 11 more: NurbsPatch is not supported (dropped)",
        "/World/Smoke: Volume is not supported (dropped)",
    ]


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"frame": float("nan")}, "frame is nan, expected a time code"),
        ({"purposes": ["preview"]}, "unknown purpose 'preview': expected render, proxy, guide"),
    ],
)
def test_moments_and_purposes_that_are_none_are_refused(
    stage: Any, tmp_path: Path, setting: dict[str, Any], message: str
) -> None:
    stage.Save()
    with pytest.raises(InputError, match=message):
        weaveusd.render(tmp_path / "scene.usda", **setting)
