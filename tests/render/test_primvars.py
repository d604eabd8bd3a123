"""Primvars that networks read: more coordinates, colors, and what a shape lacks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, UsdGeom

from tests.render.networks import QUADRANTS, card_stage, large_texels, node, quadrants
from tests.render.stages import add_mesh, bind, preview_material, write_image


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return card_stage(tmp_path)


def test_two_sets_of_coordinates_serve_one_material(mi: Any, stage: Any, tmp_path: Path) -> None:
    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    material, shader = preview_material(stage, ior=1.0)
    mesh = add_mesh(stage)
    bind(mesh, material)
    other = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "turned", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    other.Set([(1, 1), (0, 1), (0, 0), (1, 0)])
    for name, primvar, feeding in (("A", "st", "diffuseColor"), ("B", "turned", "emissiveColor")):
        reader = node(
            stage, f"Reader{name}", "UsdPrimvarReader_float2", "result",
            varname=("string", primvar),
        )  # fmt: skip
        texture = node(
            stage, f"Texture{name}", "UsdUVTexture", "rgb", file=("asset", "./map.exr"),
            st=("float2", reader),
        )  # fmt: skip
        shader.CreateInput(feeding, Sdf.ValueTypeNames.Color3f).ConnectToSource(texture)
    found, losses = quadrants(stage)
    assert losses == []
    np.testing.assert_allclose(found, QUADRANTS + QUADRANTS[::-1, ::-1], atol=0.06)


def test_a_primvar_is_a_color_and_without_it_there_is_the_fallback(mi: Any, stage: Any) -> None:
    material, shader = preview_material(stage, ior=1.0)
    mesh = add_mesh(stage)
    bind(mesh, material)
    reader = node(
        stage, "Reader", "UsdPrimvarReader_float3", "result", varname=("string", "paint"),
        fallback=("float3", (0.2, 0.3, 0.4)),
    )  # fmt: skip
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(reader)
    assert quadrants(stage)[0].mean(axis=(0, 1)) == pytest.approx((0.2, 0.3, 0.4), rel=0.03)
    paint = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "paint", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex
    )
    paint.Set([(0.1, 0.5, 0.2), (0.9, 0.5, 0.2), (0.9, 0.5, 0.2), (0.1, 0.5, 0.2)])
    found, losses = quadrants(stage)
    assert losses == []
    # Interpolated along x: a quarter and three quarters of the way.
    np.testing.assert_allclose(found[:, 0, 0], 0.3, atol=0.03)
    np.testing.assert_allclose(found[:, 1, 0], 0.7, atol=0.03)
    np.testing.assert_allclose(found[..., 1], 0.5, atol=0.02)
