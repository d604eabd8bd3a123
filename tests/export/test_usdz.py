"""A usdz is one layer with its pictures, opens from anywhere, and is the asset."""

from __future__ import annotations

import os
import shutil
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest
from pxr import Ar, Sdf, Usd, UsdGeom, UsdShade, UsdValidation

from tests.export.cloths import REPEAT_MM, cloth, texture_files
from tests.web.tools import browser, run_node
from weaveusd import stage as stages
from weaveusd.errors import WeaveusdError
from weaveusd.export import package as packages
from weaveusd.export.asset import write_asset
from weaveusd.export.doors import write_doors
from weaveusd.export.package import write_package
from weaveusd.export.panel import panel_size_mm
from weaveusd.export.usdz import write_usdz


@pytest.fixture(scope="module")
def asset(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("asset")
    write_asset(cloth(), path)
    return path


@pytest.fixture(scope="module")
def package(asset, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("elsewhere") / "plain.usdz"
    write_usdz(asset / "plain.usda", path, panel_size_mm(REPEAT_MM))
    return path


@pytest.fixture(scope="module")
def stage(package) -> Usd.Stage:
    return stages.open_stage(package)


def test_it_is_stored_aligned_and_the_layer_comes_first(package):
    found = Sdf.ZipFile.Open(str(package))
    names = found.GetFileNames()
    assert names[0] == "plain.usdc"
    assert names[1:] == sorted(names[1:])
    for name in names:
        info = found.GetFileInfo(name)
        assert info.dataOffset % 64 == 0, name
        assert info.compressionMethod == 0, name
        assert info.size == info.uncompressedSize
    with zipfile.ZipFile(package) as archive:
        assert archive.testzip() is None
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_every_texture_is_in_it_to_the_last_bit(asset, package):
    with zipfile.ZipFile(package) as archive:
        textures = {f"textures/{file}" for file in texture_files()}
        assert set(archive.namelist()) == textures | {"plain.usdc"}
        for name in textures:
            assert archive.read(name) == (asset / name).read_bytes(), name


def test_the_material_says_what_the_asset_says(asset, stage):
    source = stages.open_stage(asset / "plain.usda")
    made = source.GetPrimAtPath("/plain/Material")
    packed = stage.GetPrimAtPath("/plain/Material")
    assert packed.GetAppliedSchemas() == made.GetAppliedSchemas()
    left_out = set()
    for attribute in made.GetAuthoredAttributes():
        found = packed.GetAttribute(attribute.GetName())
        if not (found.HasAuthoredValue() or found.HasAuthoredConnections()):
            left_out.add(attribute.GetName())
        elif not str(attribute.GetTypeName()).startswith("asset"):
            assert found.Get() == attribute.Get()
    assert left_out == {"weave:draft", "weave:recipeFile"}
    for context in ("", "mtlx", "mitsuba"):
        surfaces = (UsdShade.Material(p).ComputeSurfaceSource(context)[0] for p in (made, packed))
        assert len({s.GetShaderId() for s in surfaces}) == 1


def test_every_path_leads_into_the_package(stage, package):
    seen = 0
    for prim in stage.TraverseAll():
        for attribute in prim.GetAuthoredAttributes():
            values = attribute.Get()
            for value in values if isinstance(values, Sdf.AssetPathArray) else [values]:
                if isinstance(value, Sdf.AssetPath):
                    seen += 1
                    assert value.path.startswith("./textures/")
                    outer, inner = Ar.SplitPackageRelativePathInner(value.resolvedPath)
                    assert (outer, inner) == (str(package), value.path[2:])
    assert seen > 20


def test_it_opens_after_a_move_and_from_another_folder(package, tmp_path, monkeypatch):
    moved = tmp_path / "renamed.usdz"
    shutil.copy(package, moved)
    monkeypatch.chdir("/")
    opened = stages.open_stage(moved)
    file = opened.GetAttributeAtPath("/plain/Material/PreviewBaseColor.inputs:file").Get()
    assert Ar.GetResolver().OpenAsset(Ar.ResolvedPath(file.resolvedPath)).GetSize() > 0


def test_a_panel_of_whole_repeats_wears_the_cloth_outside_the_default_prim(stage):
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/Panel"))
    assert stage.GetDefaultPrim().GetPath() == "/plain"
    low, high = mesh.GetExtentAttr().Get()
    for axis, repeat in enumerate(REPEAT_MM):
        size_mm = 1000 * (high[axis] - low[axis])
        assert size_mm == pytest.approx(100, abs=repeat / 2 + 1e-4)
        assert size_mm / repeat == pytest.approx(round(size_mm / repeat), abs=1e-3)
    st = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get()
    for point, coordinate in zip(mesh.GetPointsAttr().Get(), st, strict=True):
        assert coordinate[0] == pytest.approx(point[0] - low[0], abs=1e-7)
        assert coordinate[1] == pytest.approx(point[1] - low[1], abs=1e-7)
    bound, _ = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()
    assert bound.GetPath() == "/plain/Material"


def test_readers_that_follow_no_connection_to_the_material_find_the_values(stage):
    material = UsdShade.Material(stage.GetPrimAtPath("/plain/Material"))
    for attribute, public in [
        ("PreviewRepeats.inputs:scale", "uv_scale"),
        ("PreviewCoordinates.inputs:varname", "varname"),
        ("MitsubaSurface.inputs:uv_scale", "uv_scale"),
    ]:
        found = stage.GetAttributeAtPath(f"/plain/Material/{attribute}")
        assert found.Get() == material.GetInput(public).Get()
        assert UsdShade.Input(found).GetValueProducingAttributes()[0].GetPath() == (
            f"/plain/Material.inputs:{public}"
        )


def test_usd_finds_nothing_to_complain_about(stage):
    stages.teach_sdr()
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [e.GetMessage() for e in errors] == []


def test_the_same_asset_gives_the_same_bytes_whatever_its_dates_are(asset, package, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(asset, copy)
    for path in copy.rglob("*"):
        os.utime(path, (1e9, 1e9))
    write_usdz(copy / "plain.usda", tmp_path / "plain.usdz", panel_size_mm(REPEAT_MM))
    assert (tmp_path / "plain.usdz").read_bytes() == package.read_bytes()


def test_each_colorway_has_a_package_of_its_own(tmp_path):
    cloths = {"one": cloth(), "two": cloth(size=16)}
    write_asset(cloths["one"], tmp_path, colorways=cloths)
    write_doors(cloths["one"], tmp_path, ["usdz"], colorways=cloths)
    for name, width in (("plain.usdz", 32), ("plain.two.usdz", 16)):
        packed = stages.open_stage(tmp_path / name)
        found = packed.GetAttributeAtPath("/plain/Material.weave:textureWidth")
        assert found.Get() == width


def test_a_network_whose_source_is_a_file_stays_outside_with_its_output(asset, tmp_path):
    shutil.copytree(asset, tmp_path / "asset")
    entry = tmp_path / "asset" / "plain.usda"
    (tmp_path / "asset" / "cloth.glslfx").write_text("-- glslfx version 0.1\n")
    made = Usd.Stage.Open(str(tmp_path / "asset" / "look.usda"))
    shader = UsdShade.Shader.Define(made, "/plain/Material/Storm")
    shader.SetSourceAsset("./cloth.glslfx", "glslfx")
    material = UsdShade.Material(made.GetPrimAtPath("/plain/Material"))
    material.CreateSurfaceOutput("glslfx").ConnectToSource(
        shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    )
    made.Save()
    write_usdz(entry, tmp_path / "plain.usdz", (100, 100))
    packed = stages.open_stage(tmp_path / "plain.usdz")
    assert not packed.GetPrimAtPath("/plain/Material/Storm")
    assert not UsdShade.Material(packed.GetPrimAtPath("/plain/Material")).GetSurfaceOutput("glslfx")
    assert "cloth.glslfx" not in zipfile.ZipFile(tmp_path / "plain.usdz").namelist()


def test_more_than_zip_can_count_is_refused_before_anything_is_written(tmp_path, monkeypatch):
    (tmp_path / "picture.png").write_bytes(bytes(5000))
    monkeypatch.setattr(packages, "MAX_BYTES", 5000)
    with pytest.raises(WeaveusdError, match="expected at most 5000 in a usdz"):
        write_package(tmp_path / "a.usdz", [("picture.png", tmp_path / "picture.png")])
    assert not (tmp_path / "a.usdz").exists()


def test_a_missing_picture_is_named(asset, tmp_path):
    shutil.copytree(asset, tmp_path / "asset")
    (tmp_path / "asset" / "textures" / "normal.png").unlink()
    with pytest.raises(WeaveusdError, match=r"normal\.png: No such file"):
        write_usdz(tmp_path / "asset" / "plain.usda", tmp_path / "a.usdz", (100, 100))


def test_no_entry_needs_more_padding_than_an_extra_field_holds(tmp_path):
    files = []
    for length in range(1, 70):
        path = tmp_path / ("x" * length)
        path.write_bytes(struct.pack("B", length) * length)
        files.append((path.name, path))
    write_package(tmp_path / "all.usdz", files)
    found = Sdf.ZipFile.Open(str(tmp_path / "all.usdz"))
    assert all(found.GetFileInfo(name).dataOffset % 64 == 0 for name, _ in files)
    with zipfile.ZipFile(tmp_path / "all.usdz") as archive:
        assert all(archive.read(path.name) == path.read_bytes() for _, path in files)


def test_three_js_shows_it_the_right_way_up_with_its_textures(package):
    shown = run_node("page.mjs", browser(), "panel.mjs", package)["result"]
    assert shown["meshes"] == 1
    assert shown["maps"]["map"]["width"] == shown["maps"]["normalMap"]["width"] == 32
    drawn = np.array(shown["pixels"]).reshape(64, 64, 4)[..., :3].astype(float)
    y, x = np.mgrid[:64, :64]
    assert np.corrcoef(x.ravel(), drawn[..., 0].ravel())[0, 1] > 0.8
    assert np.corrcoef(y.ravel(), drawn[..., 1].ravel())[0, 1] > 0.8
