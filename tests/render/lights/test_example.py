from __future__ import annotations

from pathlib import Path
from typing import Any

from pxr import Usd, UsdGeom, UsdLux

from tests.render.stages import picture

STAGE = Path(__file__).parents[3] / "examples" / "lights" / "lights.usda"
LAMPS = ("SoftCone", "TintedFocus", "Tube", "MeasuredPoint", "Panel", "WarmEllipsoid")


def test_every_lamp_of_the_example_lights_its_own_ball(mi: Any) -> None:
    """Alone, it is brightest in its sixth of the picture; together they lose nothing."""
    stage = Usd.Stage.Open(str(STAGE))
    assert picture(stage, (30, 12), 1)[1] == []
    alone = {name: UsdGeom.Imageable(stage.GetPrimAtPath(f"/World/{name}")) for name in LAMPS}
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/Sun")).MakeInvisible()
    for lamp in alone.values():
        lamp.MakeInvisible()
    for k, lamp in enumerate(alone.values()):
        lamp.MakeVisible()
        image, _ = picture(stage, (30, 12), 32)
        lamp.MakeInvisible()
        ground = image[7:].sum(axis=(0, 2))
        sixths = ground.reshape(6, 5).sum(axis=1)
        assert int(sixths.argmax()) == k


def test_the_example_holds_every_kind_of_light_that_has_a_place() -> None:
    stage = Usd.Stage.Open(str(STAGE))
    kinds = {p.GetTypeName() for p in stage.Traverse() if p.HasAPI(UsdLux.LightAPI)}
    assert kinds == {"DistantLight", "SphereLight", "DiskLight", "CylinderLight", "RectLight"}
