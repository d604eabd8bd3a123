from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from pxr import Gf, Sdf, UsdShade

from tests.render.networks import card_stage
from tests.render.stages import (
    add_mesh,
    add_texture,
    bind,
    picture,
    preview_material,
    write_image,
)

# One color for every quadrant, row 0 at the top.
QUADRANTS = np.array((((0.9, 0.1, 0.1), (0.1, 0.9, 0.1)), ((0.1, 0.1, 0.9), (0.7, 0.7, 0.1))))


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return card_stage(tmp_path)


def textured(stage: Any, tmp_path: Path, pixels: Any = QUADRANTS, **inputs: Any) -> Any:
    """A card whose diffuse color is a picture of large texels; returns the texture node."""
    write_image(tmp_path / "map.exr", np.repeat(np.repeat(pixels, 16, 0), 16, 1))
    material, shader = preview_material(stage, ior=1.0)
    bind(add_mesh(stage), material)
    return add_texture(stage, shader, "diffuseColor", "./map.exr", **inputs)


def quadrants(stage: Any) -> tuple[Any, list[str]]:
    """The color in the middle of each quadrant of the picture."""
    image, losses = picture(stage, 16, 64)
    middle = image.reshape(2, 8, 2, 8, 3)[:, 2:6, :, 2:6].mean(axis=(1, 3))
    return middle, losses


def test_a_texture_is_the_right_way_up(mi: Any, stage: Any, tmp_path: Path) -> None:
    textured(stage, tmp_path)
    found, losses = quadrants(stage)
    np.testing.assert_allclose(found, QUADRANTS, atol=0.03)
    assert losses == []


def test_a_transform_scales_then_turns_then_shifts(mi: Any, stage: Any, tmp_path: Path) -> None:
    node = textured(stage, tmp_path, wrapS="repeat", wrapT="repeat")
    transform = UsdShade.Shader.Define(stage, "/World/Look/Transform")
    transform.CreateIdAttr("UsdTransform2d")
    reader = UsdShade.Shader(stage.GetPrimAtPath("/World/Look/Reader"))
    transform.CreateInput("in", Sdf.ValueTypeNames.Float2).ConnectToSource(
        reader.ConnectableAPI(), "result"
    )
    transform.CreateInput("rotation", Sdf.ValueTypeNames.Float).Set(90.0)
    transform.CreateInput("scale", Sdf.ValueTypeNames.Float2).Set(Gf.Vec2f(1, 2))
    transform.CreateInput("translation", Sdf.ValueTypeNames.Float2).Set(Gf.Vec2f(0.5, 0))
    transform.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    node.GetInput("st").ConnectToSource(transform.ConnectableAPI(), "result")

    found, _ = quadrants(stage)
    for row in range(2):
        for column in range(2):
            s, t = 0.25 + 0.5 * column, 0.75 - 0.5 * row
            u, v = -2 * t + 0.5, s  # scaled, turned by +90 degrees, shifted
            expected = QUADRANTS[int((1 - v % 1) * 2), int(u % 1 * 2)]
            edge = min(abs(2 * u - round(2 * u)), abs(2 * v - round(2 * v)))
            if edge > 0.2:
                np.testing.assert_allclose(found[row, column], expected, atol=0.05)


@pytest.mark.parametrize(
    ("kind", "space", "decoded"),
    [
        (oiio.UINT8, "auto", True),
        (oiio.UINT8, "raw", False),
        (oiio.UINT8, "sRGB", True),
        (oiio.UINT16, "auto", False),
        (oiio.UINT16, "sRGB", True),
    ],
)
def test_color_is_decoded_as_usd_says(
    mi: Any, stage: Any, tmp_path: Path, kind: Any, space: str, decoded: bool
) -> None:
    write_image(tmp_path / "gray.png", np.full((4, 4, 3), 0.5), kind)
    material, shader = preview_material(stage, ior=1.0)
    bind(add_mesh(stage), material)
    add_texture(stage, shader, "diffuseColor", "./gray.png", sourceColorSpace=space)
    expected = ((0.5 + 0.055) / 1.055) ** 2.4 if decoded else 0.5
    assert quadrants(stage)[0].mean() == pytest.approx(expected, rel=0.02)


def test_scale_and_bias_are_applied(mi: Any, stage: Any, tmp_path: Path) -> None:
    textured(stage, tmp_path, scale=(0.5, 0.5, 0.5, 1.0), bias=(0.1, 0.1, 0.1, 0.0))
    np.testing.assert_allclose(quadrants(stage)[0], QUADRANTS * 0.5 + 0.1, atol=0.03)


def test_one_channel_feeds_opacity(mi: Any, stage: Any, tmp_path: Path) -> None:
    mask = np.zeros((2, 2, 3))
    mask[0, 1, 1] = 1.0
    write_image(tmp_path / "mask.exr", np.repeat(np.repeat(mask, 16, 0), 16, 1))
    material, shader = preview_material(stage, ior=1.0, diffuseColor=(0.0, 0.0, 0.0))
    bind(add_mesh(stage), material)
    add_texture(stage, shader, "opacity", "./mask.exr", "g", wrapS="clamp", wrapT="clamp")
    found, _ = quadrants(stage)
    np.testing.assert_allclose(found[..., 0], ((1, 0), (1, 1)), atol=0.02)


def test_a_cut_out_is_all_or_nothing(mi: Any, stage: Any) -> None:
    material, shader = preview_material(stage, ior=1.0, diffuseColor=(0.0, 0.0, 0.0))
    bind(add_mesh(stage), material)
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(0.4)
    assert quadrants(stage)[0].mean() == pytest.approx(0.6, abs=0.05)
    for threshold, shown in ((0.3, 0.0), (0.5, 1.0)):
        shader.CreateInput("opacityThreshold", Sdf.ValueTypeNames.Float).Set(threshold)
        assert quadrants(stage)[0].mean() == pytest.approx(shown, abs=0.01)


def test_a_normal_map_leans_the_surface(mi: Any, stage: Any, tmp_path: Path) -> None:
    # A distant light from +x makes a card brighter whose normals lean to +x, stored as 0…1.
    from pxr import UsdLux

    stage.RemovePrim("/World/Dome")
    sun = UsdLux.DistantLight.Define(stage, "/World/Sun")
    sun.AddRotateYOp().Set(60.0)
    sun.CreateAngleAttr(0.0)
    sun.CreateIntensityAttr(1.0)
    material, shader = preview_material(stage, ior=1.0, diffuseColor=(0.5, 0.5, 0.5))
    bind(add_mesh(stage), material)
    flat = quadrants(stage)[0].mean()
    assert flat == pytest.approx(0.5 / np.pi * 0.5, rel=0.01)
    encoded = np.tile((np.array((0.6, 0.0, 0.8)) + 1) / 2, (4, 4, 1))
    write_image(tmp_path / "normal.exr", encoded)
    add_texture(
        stage, shader, "normal", "./normal.exr",
        scale=(2.0, 2.0, 2.0, 1.0), bias=(-1.0, -1.0, -1.0, 0.0),
    )  # fmt: skip
    leaning = quadrants(stage)[0].mean()
    cosine = 0.6 * np.sin(np.radians(60)) + 0.8 * 0.5
    assert leaning == pytest.approx(0.5 / np.pi * cosine, rel=0.01)


def test_a_shining_material_lights_the_stage(mi: Any, stage: Any) -> None:
    stage.RemovePrim("/World/Dome")
    material, _ = preview_material(stage, emissiveColor=(0.5, 2.0, 0.25))
    bind(add_mesh(stage), material)
    found, losses = quadrants(stage)
    assert found[0, 0] == pytest.approx([0.5, 2.0, 0.25], rel=0.1)
    assert losses == []


def test_metal_reflects_its_color_and_a_dielectric_does_not(mi: Any, stage: Any) -> None:
    material, shader = preview_material(
        stage, diffuseColor=(0.9, 0.5, 0.1), metallic=1.0, roughness=0.2
    )
    bind(add_mesh(stage), material)
    assert quadrants(stage)[0].mean(axis=(0, 1)) == pytest.approx([0.9, 0.5, 0.1], rel=0.1)
    shader.GetInput("metallic").Set(0.0)
    shader.GetInput("diffuseColor").Set(Gf.Vec3f(0, 0, 0))
    dark = quadrants(stage)[0].mean(axis=(0, 1))
    assert dark.max() < 0.1
    assert np.ptp(dark) < 0.01


def test_a_missing_texture_is_a_loss_that_names_it(mi: Any, stage: Any, tmp_path: Path) -> None:
    textured(stage, tmp_path).GetInput("file").Set("./gone.exr")
    _, losses = quadrants(stage)
    assert losses == [
        "/World/Look/diffuseColorTexture: inputs:file: ./gone.exr is not found: "
        "the texture's fallback is shown (dropped)"
    ]


def test_what_a_surface_cannot_show_is_reported(mi: Any, stage: Any) -> None:
    material, _ = preview_material(stage, displacement=0.5, ior=0.5)
    bind(add_mesh(stage), material)
    _, losses = quadrants(stage)
    assert losses == [
        "/World/Look/Surface: displacement (dropped)",
        "/World/Look/Surface: ior below 1 is taken as 1 (approximated)",
    ]


def test_a_surface_of_another_kind_is_reported(mi: Any, stage: Any) -> None:
    material, shader = preview_material(stage)
    shader.CreateIdAttr("ND_toon_surfaceshader")
    bind(add_mesh(stage), material)
    image, losses = quadrants(stage)
    assert losses == ["/World/Look/Surface: surface shader ND_toon_surfaceshader (dropped)"]
    assert image.mean() == pytest.approx(0.18, rel=0.02)
