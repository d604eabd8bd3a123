from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdShade

import weaveusd
from tests.render.cloths import optics, plain_arrays
from tests.render.stages import cloth_material, new_stage, write_cloth
from weaveusd.errors import InputError, StageError
from weaveusd.render.scenes import dress, scene_names, scene_path, scenes_dir
from weaveusd.stage import open_stage

DRESSED = {"cornell_drape": "/World/Drape", "sky_sphere": "/World/Ball"}


@pytest.fixture
def asset(tmp_path: Path) -> Path:
    """The entry layer of a red cloth with four repeats a centimetre."""
    folder = tmp_path / "assets" / "red"
    arrays = plain_arrays(size=4)
    arrays["base_color"][...] = (0.8, 0.1, 0.1)
    write_cloth(folder / "textures", arrays)
    stage = new_stage(folder / "red.usda")
    UsdGeom.SetStageMetersPerUnit(stage, 0.001)
    stage.SetDefaultPrim(UsdGeom.Scope.Define(stage, "/red").GetPrim())
    cloth_material(stage, "/red/Material", optics("linen"), (400.0, 400.0))
    stage.Save()
    return folder / "red.usda"


def test_there_are_two_scenes_and_they_are_small() -> None:
    assert scene_names() == ["cornell_drape", "sky_sphere"]
    assert sum(p.stat().st_size for p in scenes_dir().iterdir() if p.is_file()) < 600_000
    with pytest.raises(InputError, match="no scene 'moon': expected one of cornell_drape, sky_"):
        scene_path("moon")


@pytest.mark.parametrize("name", list(DRESSED))
def test_a_scene_measures_its_cloth_in_metres(name: str) -> None:
    stage = open_stage(scene_path(name))
    unit = UsdGeom.GetStageMetersPerUnit(stage)
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(DRESSED[name]))
    points = np.array(mesh.GetPointsAttr().Get()) * unit
    st = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())
    quads = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
    # The ball is true to scale around the point that faces the camera, the drape everywhere.
    height = points[quads].mean(axis=1)[:, 2]
    near = height > 0.9 * points[:, 2].max() if name == "sky_sphere" else height > -np.inf
    a, b = quads[near][:, 0], quads[near][:, 1]
    in_space = np.linalg.norm(points[a] - points[b], axis=1)
    in_cloth = np.linalg.norm(st[a] - st[b], axis=1)
    real = in_cloth > 0
    stretch = in_space[real] / in_cloth[real]
    assert np.median(stretch) == pytest.approx(1, abs=0.03)
    assert np.quantile(np.abs(stretch - 1), 0.9) < 0.15


@pytest.mark.parametrize("name", list(DRESSED))
def test_a_scene_stays_on_its_own_feet(name: str) -> None:
    stage = open_stage(scene_path(name))
    for layer in stage.GetUsedLayers():
        for path in layer.GetExternalReferences():
            assert path.startswith("./")
    assert not stage.GetCompositionErrors()
    assert stage.GetPrimAtPath("/World/Cloth").GetTypeName() == "Scope"


@pytest.mark.parametrize("name", list(DRESSED))
def test_dressing_binds_the_cloth_and_keeps_the_units(
    tmp_path: Path, asset: Path, name: str
) -> None:
    output = dress(scene_path(name), asset, tmp_path / "dressed.usda")
    stage = Usd.Stage.Open(str(output))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert stage.GetDefaultPrim().GetPath() == "/World"
    material, _ = UsdShade.MaterialBindingAPI(
        stage.GetPrimAtPath(DRESSED[name])
    ).ComputeBoundMaterial()
    assert material.GetPath() == "/World/Cloth/Material"
    assert "@./assets/red/red.usda@" in output.read_text()


def test_scene_asset_and_layer_can_move_together(tmp_path: Path, asset: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    shutil.copytree(scenes_dir(), home / "scenes")
    shutil.move(str(asset.parent), str(home / "red"))
    dress(home / "scenes" / "sky_sphere.usda", home / "red" / "red.usda", home / "shot.usda")
    home.rename(tmp_path / "elsewhere")
    stage = Usd.Stage.Open(str(tmp_path / "elsewhere" / "shot.usda"))
    assert stage.GetPrimAtPath("/World/Cloth/Material")
    assert stage.GetPrimAtPath("/World/Ball")
    assert str(tmp_path) not in (tmp_path / "elsewhere" / "shot.usda").read_text()


@pytest.mark.parametrize("name", list(DRESSED))
def test_a_dressed_scene_shows_the_cloth(mi: Any, tmp_path: Path, asset: Path, name: str) -> None:
    output = dress(scene_path(name), asset, tmp_path / "dressed.usda")
    result = weaveusd.render(output, width=24, height=24, spp=32)
    assert result.losses == ()
    center = result.image[9:15, 9:15].mean(axis=(0, 1))
    assert center[0] > 1.5 * center[1]
    assert 0.05 < result.image.mean() < 1


def test_a_layer_that_cannot_be_made_leaves_nothing(tmp_path: Path, asset: Path) -> None:
    scene = scene_path("sky_sphere")
    bare = new_stage(tmp_path / "bare.usda")
    bare.Save()
    before = sorted(tmp_path.iterdir())
    for arguments, kind, message in (
        ((tmp_path / "bare.usda", asset, tmp_path / "out.usda"), StageError, "has no prim /World"),
        ((scene, tmp_path / "bare.usda", tmp_path / "out.usda"), StageError, "has no Material in"),
        ((scene, asset, tmp_path / "out.txt"), InputError, "ends in '.txt'"),
        ((scene, asset, tmp_path / "none" / "out.usda"), InputError, "none does not exist"),
        ((scene, asset, asset), InputError, "would replace its own input"),
    ):
        with pytest.raises(kind, match=message):
            dress(*arguments)
    assert sorted(tmp_path.iterdir()) == before
