from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdShade, UsdValidation

import weaveusd
from tests.render.cloths import optics, plain_arrays
from tests.render.stages import cloth_material, new_stage, write_cloth
from weaveusd import pipeline
from weaveusd.contract import CLOTH_SHADER_ID
from weaveusd.errors import InputError, StageError
from weaveusd.render.scenes import dress, scene_names, scene_path, scenes_dir
from weaveusd.stage import open_stage, teach_sdr

ROOT = Path(__file__).parents[2]
STAGES = ROOT / "examples" / "stages"
SCENES = (
    "cornell_drape", "pillow", "pillow_sky", "skirt", "skirt_sky", "sky_sphere", "sofa", "swatch",
)  # fmt: skip
CLOTH = "/World/Cloth/Material"


def cloth_meshes(stage: Any) -> list[Any]:
    """Return the meshes of a stage that are made of cloth."""
    found = []
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
            if material and str(material.GetPath()) == CLOTH:
                found.append(UsdGeom.Mesh(prim))
    assert found
    return found


def corners(mesh: Any) -> tuple[Any, Any, Any]:
    """Return points in metres and st of the corners (F, 4, …) of a mesh, and all its points."""
    points = np.array(mesh.GetPointsAttr().Get(), float) * 0.01
    quads = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
    st = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").ComputeFlattened(), float)
    return points[quads], st.reshape(-1, 4, 2), points


def length(vectors: Any) -> Any:
    return np.linalg.norm(vectors, axis=-1)


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


def test_there_are_eight_scenes_and_they_are_small() -> None:
    assert tuple(scene_names()) == SCENES
    files = [p for p in scenes_dir().iterdir() if p.suffix in (".usda", ".usdc", ".exr")]
    assert max(p.stat().st_size for p in files) < 1_500_000
    assert sum(p.stat().st_size for p in files) < 2_500_000
    with pytest.raises(InputError, match="no scene 'moon': expected one of cornell_drape, pillow"):
        scene_path("moon")


def test_every_file_of_a_scene_comes_with_the_package() -> None:
    listed = re.findall(
        r'"examples/stages/(\S+)" = "weaveusd/scenes/\1"', (ROOT / "pyproject.toml").read_text()
    )
    files = {p.name for p in STAGES.iterdir() if p.suffix in (".usda", ".usdc", ".exr")}
    assert set(listed) == files


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_measures_its_cloth_in_metres(name: str) -> None:
    stage = open_stage(scene_path(name))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    for mesh in cloth_meshes(stage):
        places, st, points = corners(mesh)
        if name == "sky_sphere":  # true to scale around the point that faces the camera
            near = places.mean(axis=1)[:, 2] > 0.9 * points[:, 2].max()
            places, st = places[near], st[near]
        for k in range(4):
            step = (k + 1) % 4
            stretch = length(places[:, step] - places[:, k]) / length(st[:, step] - st[:, k])
            assert np.median(stretch) == pytest.approx(1, abs=0.03)
            assert np.quantile(np.abs(stretch - 1), 0.9) < 0.15


@pytest.mark.parametrize("name", SCENES)
def test_the_face_of_a_cloth_is_outside_and_reads_from_left_to_right(name: str) -> None:
    """Points, st and normals are all right-handed: ∂p/∂s × ∂p/∂t is the normal."""
    stage = open_stage(scene_path(name))
    for mesh in cloth_meshes(stage):
        places, st, _ = corners(mesh)
        normals = np.array(mesh.GetNormalsAttr().Get(), float)
        quads = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4)
        one, two = places[:, 2] - places[:, 0], places[:, 3] - places[:, 1]
        facing = np.cross(one, two)
        a, b = st[:, 2] - st[:, 0], st[:, 3] - st[:, 1]
        assert (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).min() > 0
        assert length(normals) == pytest.approx(1, abs=1e-5)
        agreeing = np.sum(facing * normals[quads].mean(axis=1), axis=1) > 0
        assert agreeing.mean() > 0.995


@pytest.mark.parametrize("name", ["pillow", "sofa"])
def test_covers_are_outside_of_what_they_fill(name: str) -> None:
    stage = open_stage(scene_path(name))
    for mesh in cloth_meshes(stage):
        if mesh.GetPrim().GetName() != "Piping":
            (a, b, c, d), points = np.swapaxes(corners(mesh)[0], 0, 1), corners(mesh)[2]
            volume = (np.sum(a * np.cross(b, c)) + np.sum(a * np.cross(c, d))) / 6
            assert 0.1 < volume / np.prod(np.ptp(points, axis=0)) < 1


@pytest.mark.parametrize("name", SCENES)
def test_nothing_of_a_scene_is_below_its_floor(name: str) -> None:
    stage = open_stage(scene_path(name))
    box = UsdGeom.BBoxCache(0, [UsdGeom.Tokens.default_]).ComputeWorldBound(
        stage.GetPrimAtPath("/World")
    )
    assert box.ComputeAlignedRange().GetMin()[1] > -0.1


@pytest.mark.parametrize("name", SCENES)
def test_no_validator_of_openusd_finds_a_fault(name: str) -> None:
    teach_sdr()
    stage = open_stage(scene_path(name))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [f"{e.GetName()}: {e.GetMessage()}" for e in errors] == []


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_stays_on_its_own_feet(name: str) -> None:
    stage = open_stage(scene_path(name))
    for layer in stage.GetUsedLayers():
        for path in layer.GetExternalReferences():
            assert not path or path.startswith("./")
    assert not stage.GetCompositionErrors()
    assert stage.GetPrimAtPath("/World/Cloth").GetTypeName() == "Scope"
    assert stage.GetPrimAtPath("/World/Camera").GetTypeName() == "Camera"
    first = next(p for p in stage.Traverse() if p.IsA(UsdGeom.Camera))
    assert first.GetName() == "Camera"


@pytest.mark.parametrize("name", SCENES)
def test_dressing_binds_the_cloth_and_keeps_the_units(
    tmp_path: Path, asset: Path, name: str
) -> None:
    output = dress(scene_path(name), asset, tmp_path / "dressed.usda")
    stage = Usd.Stage.Open(str(output))
    assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert stage.GetDefaultPrim().GetPath() == "/World"
    for mesh in cloth_meshes(stage):
        material, _ = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial()
        shader, _, _ = material.ComputeSurfaceSource("mitsuba")
        assert shader.GetIdAttr().Get() == CLOTH_SHADER_ID
    assert "@./assets/red/red.usda@" in output.read_text()


@pytest.mark.parametrize("preset", ["linen"])
def test_a_published_cloth_hides_the_gray_one_in_every_context(tmp_path: Path, preset: str) -> None:
    draft = ROOT / "examples" / "drafts" / "plain.wif"
    entry = weaveusd.publish(draft, preset=preset, root=tmp_path, resolution=64).asset.entry
    stage = Usd.Stage.Open(str(dress(scene_path("swatch"), entry, tmp_path / "dressed.usda")))
    material = UsdShade.Material(stage.GetPrimAtPath(CLOTH))
    for output in material.GetSurfaceOutputs():
        source = output.GetConnectedSources()[0][0].source.GetPath()
        assert source.name != "StandIn"
    assert len(material.GetSurfaceOutputs()) == 3


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


@pytest.mark.parametrize(
    "name",
    [
        n if n in ("pillow_sky", "swatch") else pytest.param(n, marks=pytest.mark.slow)
        for n in SCENES
    ],
)
def test_a_dressed_scene_shows_the_cloth(mi: Any, tmp_path: Path, asset: Path, name: str) -> None:
    output = dress(scene_path(name), asset, tmp_path / "dressed.usda")
    result = weaveusd.render(output, width=24, height=24, spp=32)
    assert result.losses == ()
    row = 16 if name.startswith("pillow") else 12
    center = result.image[row - 2 : row + 2, 10:14].mean(axis=(0, 1))
    assert center[0] > 1.5 * center[1]
    assert 0.05 < result.image.mean() < 1


@pytest.mark.slow
def test_the_scenes_are_what_their_script_makes(tmp_path: Path) -> None:
    script = [sys.executable, str(STAGES / "make_stages.py"), str(tmp_path)]
    subprocess.run(script, check=True, capture_output=True)
    made = sorted(p.name for p in tmp_path.iterdir())
    assert made == sorted(
        p.name for p in STAGES.iterdir() if p.suffix in (".usda", ".usdc", ".exr")
    )
    for name in made:
        if name.endswith(".exr"):
            one, two = (oiio.ImageBuf(str(f / name)).get_pixels() for f in (STAGES, tmp_path))
            assert np.allclose(one, two, rtol=2e-3)
        else:
            one, two = (Sdf.Layer.FindOrOpen(str(f / name)) for f in (STAGES, tmp_path))
            assert one.ExportToString() == two.ExportToString(), name


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


def test_a_scene_is_rendered_by_its_name(mi: Any, tmp_path: Path, asset: Path) -> None:
    by_name = pipeline.render(asset, tmp_path / "a.exr", scene="swatch", width=16, spp=8)
    dressed = dress(scene_path("swatch"), asset, tmp_path / "dressed.usda")
    assert np.array_equal(by_name.image, weaveusd.render(dressed, width=16, spp=8).image)
    with pytest.raises(InputError, match="no scene 'moon'"):
        pipeline.render(asset, tmp_path / "b.exr", scene="moon")
