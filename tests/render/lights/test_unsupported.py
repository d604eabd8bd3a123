from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdLux

from tests.render.lights.lamps import CARD, card, irradiance
from tests.render.stages import add_dome, add_mesh


def said(stage: Any) -> list[str]:
    return irradiance(stage, 1)[1]


def test_a_stage_without_light_gets_a_white_dome_and_a_loss(mi: Any, tmp_path: Path) -> None:
    found, losses = irradiance(card(tmp_path), 256)
    assert found == pytest.approx(np.pi, rel=0.02)
    assert losses == ["/: stage has no light: a white dome lights it (approximated)"]


def test_a_light_of_another_renderer_is_refused_by_name(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    add_dome(stage)
    light = stage.DefinePrim("/World/Foreign", "PluginLight")
    light.GetAttribute("info:id").Set("PxrEnvDayLight")
    assert said(stage) == [
        "/World/Foreign: PluginLight PxrEnvDayLight is another renderer's (dropped)"
    ]


def test_a_light_without_a_type_is_a_loss(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    add_dome(stage)
    UsdLux.LightAPI.Apply(stage.DefinePrim("/World/Null", "Xform"))
    assert said(stage) == ["/World/Null: Xform is not supported (dropped)"]


def test_light_filters_are_named(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    dome = add_dome(stage)
    UsdLux.LightFilter.Define(stage, "/World/Barn")
    dome.CreateFiltersRel().AddTarget("/World/Barn")
    assert said(stage) == ["/World/Dome: light filter /World/Barn (dropped)"]


@pytest.mark.parametrize("link", ["light", "shadow"])
def test_a_link_that_leaves_out_a_shape_is_a_loss_that_names_it(
    mi: Any, tmp_path: Path, link: str
) -> None:
    stage = card(tmp_path)
    dome = add_dome(stage)
    for name in ("A", "B"):
        add_mesh(stage, f"/World/Left/{name}")
    light = UsdLux.LightAPI(dome)
    made = {"light": light.GetLightLinkCollectionAPI, "shadow": light.GetShadowLinkCollectionAPI}
    made[link]().ExcludePath("/World/Left")
    verb = "is lit" if link == "light" else "casts a shadow"
    text = f"{link} link: /World/Left/A and 1 more {verb} although it is left out"
    assert said(stage) == [f"/World/Dome: {text} (dropped)"]


def test_a_link_that_includes_every_shape_is_carried(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    link = UsdLux.LightAPI(add_dome(stage)).GetLightLinkCollectionAPI()
    link.CreateIncludeRootAttr(False)
    link.IncludePath("/World")
    assert said(stage) == []
    link.GetIncludesRel().SetTargets(["/World/Dome"])
    assert said(stage) == [
        f"/World/Dome: light link: {CARD} is lit although it is left out (dropped)"
    ]


def test_a_link_by_expression_is_understood(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    link = UsdLux.LightAPI(add_dome(stage)).GetLightLinkCollectionAPI()
    link.CreateIncludeRootAttr(False)
    link.CreateMembershipExpressionAttr(Sdf.PathExpression("//Card"))
    assert said(stage) == []
    link.GetMembershipExpressionAttr().Set(Sdf.PathExpression("//Other"))
    assert said(stage) == [
        f"/World/Dome: light link: {CARD} is lit although it is left out (dropped)"
    ]


def test_shadow_settings_that_change_a_picture_are_named(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    shadow = UsdLux.ShadowAPI.Apply(add_dome(stage).GetPrim())
    shadow.CreateShadowEnableAttr(True)
    assert said(stage) == []
    shadow.CreateShadowEnableAttr(False)
    shadow.CreateShadowColorAttr(Gf.Vec3f(0, 0, 1))
    shadow.CreateShadowDistanceAttr(10.0)
    assert said(stage) == [
        "/World/Dome: shadow:color, shadow:distance, shadow:enable: "
        "its shadows are as the geometry casts them (dropped)"
    ]


def test_a_light_flattened_by_its_transform_is_dropped(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    add_dome(stage)
    light = UsdLux.RectLight.Define(stage, "/World/Flat")
    light.AddScaleOp().Set(Gf.Vec3f(1, 0, 1))
    assert said(stage) == ["/World/Flat: light is flattened by its transform (dropped)"]


def test_a_shader_of_another_renderer_is_shown_as_the_light_that_it_replaces(
    mi: Any, tmp_path: Path
) -> None:
    stage = card(tmp_path)
    prim = add_dome(stage).GetPrim()
    prim.GetAttribute("light:shaderId").Set("DomeLight")
    assert said(stage) == []
    prim.GetAttribute("light:shaderId").Set("PxrEnvDayLight")
    assert said(stage) == [
        "/World/Dome: shader PxrEnvDayLight is shown as DomeLight (approximated)"
    ]
