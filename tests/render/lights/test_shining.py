from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdLux

from tests.render.lights.lamps import card, irradiance, polygon, received, shaped
from tests.render.stages import (
    add_camera,
    add_mesh,
    add_texture,
    bind,
    picture,
    preview_material,
    write_image,
)

# Counter-clockwise seen from below: it faces the card.
PANEL = ((-1, -1, 2), (-1, 1, 2), (1, 1, 2), (1, -1, 2))
GIVEN = polygon(PANEL)


def panel(stage: Any, mode: str | None = None, points: Any = PANEL) -> Any:
    """A square over the card, a light by MeshLightAPI; the mesh and its light."""
    mesh = add_mesh(stage, "/World/Panel", points=points)
    light = UsdLux.MeshLightAPI.Apply(mesh.GetPrim())
    light = UsdLux.LightAPI(mesh.GetPrim())
    if mode:
        light.CreateMaterialSyncModeAttr(mode)
    return mesh, light


@pytest.mark.parametrize("normalize", [False, True])
def test_a_mesh_light_gives_what_lamberts_polygon_formula_says(
    mi: Any, tmp_path: Path, normalize: bool
) -> None:
    stage = card(tmp_path)
    _, light = panel(stage)
    light.CreateIntensityAttr(3.0)
    light.CreateNormalizeAttr(normalize)
    found, losses = irradiance(stage, 4096)
    assert found == pytest.approx(3 * GIVEN / (4 if normalize else 1), rel=0.01)
    assert losses == []


def test_a_scaled_mesh_light_is_divided_by_the_area_it_has_in_the_world(
    mi: Any, tmp_path: Path
) -> None:
    stage = card(tmp_path)
    mesh, light = panel(stage, points=tuple((x / 2, y / 2, z) for x, y, z in PANEL))
    mesh.AddScaleOp().Set(Gf.Vec3f(2, 2, 1))
    light.CreateNormalizeAttr(True)
    assert irradiance(stage, 4096)[0] == pytest.approx(GIVEN / 4, rel=0.01)


def test_a_mesh_light_shines_from_its_front_only(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    panel(stage, points=PANEL[::-1])
    assert irradiance(stage, 16)[0] == 0


def test_without_material_response_the_mesh_has_none(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    mesh, light = panel(stage, "noMaterialResponse")
    material, _ = preview_material(
        stage, diffuseColor=(1.0, 1.0, 1.0), emissiveColor=(9.0, 9.0, 9.0)
    )
    bind(mesh, material)
    light.CreateColorAttr(Gf.Vec3f(1, 0.5, 0.25))
    found, losses = received(stage, 4096)
    assert found == pytest.approx(GIVEN * np.array((1, 0.5, 0.25)), rel=0.01)
    assert losses == []


def test_a_glow_tints_its_light(mi: Any, tmp_path: Path) -> None:
    """Radiance is glow · color · intensity."""
    stage = card(tmp_path)
    mesh, light = panel(stage, "materialGlowTintsLight")
    material, _ = preview_material(
        stage, ior=1.0, diffuseColor=(0.0,) * 3, emissiveColor=(0.5, 1.0, 2.0)
    )
    bind(mesh, material)
    light.CreateColorAttr(Gf.Vec3f(1, 0.5, 0.25))
    light.CreateIntensityAttr(4.0)
    found, losses = received(stage, 4096)
    assert found == pytest.approx(4 * GIVEN * np.array((0.5, 0.5, 0.5)), rel=0.01)
    assert losses == [
        "/World/Panel: seen directly, its glow is as bright as its light (approximated)"
    ]


def test_a_glow_with_a_picture_gives_the_polygon_of_its_lit_half(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    mesh, light = panel(stage)
    pixels = np.zeros((64, 64, 3), np.float32)
    pixels[32:] = 0.5  # t below 1/2
    write_image(tmp_path / "half.exr", pixels)
    material, shader = preview_material(stage, ior=1.0, diffuseColor=(0.0,) * 3)
    add_texture(stage, shader, "emissiveColor", "./half.exr")
    bind(mesh, material)
    light.CreateIntensityAttr(4.0)
    # st is (0, 0), (1, 0), (1, 1), (0, 1) at the corners of PANEL: t grows with x.
    lit = polygon([(-1, -1, 2), (0, -1, 2), (0, 1, 2), (-1, 1, 2)])
    assert irradiance(stage, 16384)[0] == pytest.approx(4 * 0.5 * lit, rel=0.015)


def test_an_independent_light_has_the_color_of_its_own(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    mesh, light = panel(stage, "independent")
    material, _ = preview_material(
        stage, ior=1.0, diffuseColor=(0.0,) * 3, emissiveColor=(0.0, 0.0, 9.0)
    )
    bind(mesh, material)
    light.CreateColorAttr(Gf.Vec3f(1, 0.5, 0))
    found, losses = received(stage, 4096)
    assert found == pytest.approx(GIVEN * np.array((1, 0.5, 0)), rel=0.01, abs=1e-6)
    assert losses == [
        "/World/Panel: seen directly, it shows its light and not its glow (approximated)"
    ]


def test_a_mesh_light_can_be_shaped(mi: Any, tmp_path: Path) -> None:
    """Its cone lies along the local -Z of the mesh: nothing reaches a card outside of it."""
    stage = card(tmp_path)
    mesh, _ = panel(stage)
    shaped(mesh, cone_angle=89.0)
    assert irradiance(stage, 4096)[0] == pytest.approx(GIVEN, rel=0.01)
    mesh.GetPrim().GetAttribute("inputs:shaping:cone:angle").Set(10.0)
    inside = np.pi * np.sin(np.radians(10)) ** 2
    assert irradiance(stage, 65536)[0] == pytest.approx(inside, rel=0.02)


def test_a_geometry_light_makes_the_shape_it_names_shine(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    add_mesh(stage, "/World/Panel", points=PANEL)
    light = UsdLux.GeometryLight.Define(stage, "/World/Light")
    light.CreateGeometryRel().AddTarget("/World/Panel")
    light.CreateIntensityAttr(2.0)
    found, losses = irradiance(stage, 4096)
    assert found == pytest.approx(2 * GIVEN, rel=0.01)
    assert losses == []
    light.MakeInvisible()
    assert "/: stage has no light: a white dome lights it (approximated)" in irradiance(stage, 1)[1]


def test_a_geometry_light_that_names_no_shape_is_a_loss(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    UsdLux.GeometryLight.Define(stage, "/World/Alone")
    light = UsdLux.GeometryLight.Define(stage, "/World/Light")
    light.CreateGeometryRel().AddTarget("/World/Nothing")
    losses = irradiance(stage, 1)[1]
    assert "/World/Alone: names no geometry (dropped)" in losses
    assert "/World/Light: names /World/Nothing, expected a shape (dropped)" in losses


@pytest.mark.parametrize("normalize", [False, True])
def test_a_sphere_of_geometry_shines_like_a_sphere_light(
    mi: Any, tmp_path: Path, normalize: bool
) -> None:
    stage = card(tmp_path)
    sphere = UsdGeom.Sphere.Define(stage, "/World/Ball")
    sphere.CreateRadiusAttr(0.5)
    sphere.AddTranslateOp().Set((0, 0, 4))
    UsdLux.LightAPI.Apply(sphere.GetPrim()).CreateNormalizeAttr(normalize)
    found, losses = irradiance(stage, 4096)
    assert found == pytest.approx(np.pi * (0.5 / 4) ** 2 / (np.pi if normalize else 1), rel=0.01)
    assert losses == []


def test_the_light_of_a_volume_is_refused_by_name(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    volume = stage.DefinePrim("/World/Cloud", "Volume")
    volume.ApplyAPI("VolumeLightAPI")
    losses = irradiance(stage, 1)[1]
    assert any(loss.startswith("/World/Cloud: ") and "Volume" in loss for loss in losses)


@pytest.mark.parametrize("mode", [None, "noMaterialResponse"])
def test_a_mesh_light_is_seen_as_it_shines(mi: Any, tmp_path: Path, mode: str | None) -> None:
    stage = card(tmp_path)
    _, light = panel(stage, mode, points=((-1, -1, 0.5), (1, -1, 0.5), (1, 1, 0.5), (-1, 1, 0.5)))
    light.CreateIntensityAttr(3.0)
    camera = add_camera(stage, distance=10, path="/World/Far")
    assert camera
    image, _ = picture(stage, 3, 4, camera="/World/Far")
    assert image[1, 1] == pytest.approx([3, 3, 3], rel=0.1)
