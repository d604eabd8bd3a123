"""Recipes published together are variants of one asset that share what is equal."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdShade, UsdUtils

import weaveusd
from tests.export.cloths import cloth, texels, texture_files
from weaveusd.contract import COLORWAYS, LOBE_MAPS, lobe_file
from weaveusd.draft.wif import load_wif, parse_wif
from weaveusd.draft.write import write_wif
from weaveusd.errors import InputError
from weaveusd.export.asset import write_asset
from weaveusd.stage import open_stage
from weaveusd.validate.model import Status
from weaveusd.validate.run import validate

ROOT = Path(__file__).resolve().parents[2]
TWILL = ROOT / "examples" / "drafts" / "twill_2_2.wif"


def load(path):
    return parse_wif(load_wif(path), str(path))


def recolored(blue: float = 0.7):
    material = cloth()

    def band(first, last):
        rows = texels(first, last, material.textures.width, material.textures.height)
        rows["base_color"][..., 2] = blue
        return rows

    return replace(material, textures=replace(material.textures, band=band))


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("asset")
    material = cloth()
    write_asset(material, path, colorways={"natural": material, "blue": recolored()})
    return path


def file_of(stage: Usd.Stage, name: str) -> str:
    material = UsdShade.Material(stage.GetPrimAtPath("/plain/Material"))
    shader = material.ComputeSurfaceSource("mitsuba")[0]
    return str(shader.GetInput(name).Get().path)


def test_a_colorway_has_its_own_look_and_only_the_textures_that_differ(folder):
    own = {path.name for path in (folder / "textures" / "blue").iterdir()}
    assert own == {
        "base_color.exr", "base_color.png", "warp_albedo.exr", "weft_albedo.exr"
    }  # fmt: skip
    files = {path.name for path in folder.iterdir() if path.is_file()}
    assert files == {
        "README.md", "draft.wif", "plain.usda",
        "look.usda", "material.mtlx", "recipe.toml",
        "look.blue.usda", "material.blue.mtlx", "recipe.blue.toml",
    }  # fmt: skip
    assert {p.name for p in (folder / "textures").iterdir() if p.is_file()} == texture_files()


def test_the_variant_chooses_the_look_and_shares_its_structure(folder):
    stage = open_stage(folder / "plain.usda")
    variants = stage.GetDefaultPrim().GetVariantSet(COLORWAYS)
    assert variants.GetVariantNames() == ["blue", "natural"]
    assert variants.GetVariantSelection() == "natural"
    assert file_of(stage, "base_color_file") == "./textures/base_color.exr"
    variants.SetVariantSelection("blue")
    assert file_of(stage, "base_color_file") == "./textures/blue/base_color.exr"
    assert file_of(stage, "normal_file") == "./textures/normal.exr"
    listed = stage.GetPrimAtPath("/plain/Material").GetAttribute("weave:textures").Get()
    assert "./textures/blue/base_color.png" in [asset.path for asset in listed]


def test_a_stage_that_references_the_asset_selects_the_colorway(folder, tmp_path):
    layer = Sdf.Layer.CreateNew(str(tmp_path / "shot.usda"))
    prim = Sdf.PrimSpec(layer, "Cloth", Sdf.SpecifierDef, "Scope")
    prim.referenceList.prependedItems = [Sdf.Reference(str(folder / "plain.usda"))]
    prim.variantSelections[COLORWAYS] = "blue"
    layer.Save()
    stage = open_stage(tmp_path / "shot.usda")
    surface = stage.GetPrimAtPath("/Cloth/Material/MitsubaSurface")
    assert surface.GetAttribute("inputs:base_color_file").Get().path.startswith("./textures/blue/")


def test_every_file_of_every_colorway_resolves_inside_the_asset(folder):
    layers, assets, unresolved = UsdUtils.ComputeAllDependencies(str(folder / "plain.usda"))
    assert not unresolved
    assert {Path(layer.realPath).name for layer in layers} == {
        "plain.usda", "look.usda", "look.blue.usda",
    }  # fmt: skip
    assert all(Path(a).is_relative_to(folder) for a in assets)


def test_equal_colorways_cost_a_look_and_no_texture(tmp_path):
    material = cloth()
    write_asset(material, tmp_path, colorways={"one": material, "two": cloth()})
    assert not (tmp_path / "textures" / "two").exists()
    stage = open_stage(tmp_path / "plain.usda")
    stage.GetDefaultPrim().GetVariantSet(COLORWAYS).SetVariantSelection("two")
    assert file_of(stage, "base_color_file") == "./textures/base_color.exr"


@pytest.mark.parametrize("names", [("natural", "../up"), ("natural", "a b"), ("", "blue")])
def test_a_colorway_of_another_name_or_cloth_is_a_slip(tmp_path, names):
    material = cloth()
    looks = dict(zip(names, (material, recolored()), strict=True))
    if "" in looks:
        looks = {"first": recolored(), "second": material}
    with pytest.raises(ValueError, match=r"safe|expected"):
        write_asset(material, tmp_path, colorways=looks)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def published(tmp_path_factory):
    root = tmp_path_factory.mktemp("root")
    return weaveusd.publish(
        TWILL, preset="linen", colorways={"warm": "wool", "cool": "cotton"}, root=root,
        resolution=96, name="trio",
    )  # fmt: skip


def test_recipes_of_other_setts_are_published_together_and_judged_each(published):
    assert published.findings == []
    assert {c["colorway"] for c in published.colors_out_of_reach} <= {"linen", "warm", "cool"}
    stage = open_stage(published.asset.entry)
    variants = stage.GetDefaultPrim().GetVariantSet(COLORWAYS)
    seen = set()
    for name in ("linen", "warm", "cool"):
        variants.SetVariantSelection(name)
        prim = stage.GetPrimAtPath("/trio/Material")
        seen.add(prim.GetAttribute("weave:recipe").Get())
        file = prim.GetAttribute("weave:recipeFile").Get()
        assert f'name = "{prim.GetAttribute("weave:recipe").Get()}"' in (
            Path(file.resolvedPath).read_text()
        )
    assert seen == {"linen", "wool", "cotton"}


def recipe_file(path: Path, **stated: float) -> Path:
    preset = Path(weaveusd.__file__).parent / "yarn" / "presets" / "linen.toml"
    lines = [f"{key} = {value}" for key, value in stated.items()]
    path.write_text("\n".join([*lines, preset.read_text(encoding="utf-8")]), encoding="utf-8")
    return path


def test_the_draft_is_read_once_and_what_colorways_share_is_warned_of_once(tmp_path, monkeypatch):
    reads = []
    monkeypatch.setattr(
        "weaveusd.draft.wif.load_wif", lambda path: reads.append(path) or load_wif(path)
    )
    draft = load(TWILL)
    rose = tmp_path / "rose.wif"
    rose.write_bytes(write_wif(replace(draft, palette=1 - draft.palette)))
    other = recipe_file(tmp_path / "other.toml", weight_g_m2=900)
    done = weaveusd.publish(
        TWILL, recipe=recipe_file(tmp_path / "first.toml", weight_g_m2=800), root=tmp_path / "r",
        colorways={"rose": rose, "one": other, "two": other}, resolution=32,
    )  # fmt: skip
    assert reads == [TWILL, rose]
    first, second = (f["message"] for f in done.findings if f["check"] == "recipe/kept")
    assert first.startswith("recipe linen: stated 800 g/m²")
    assert second.startswith("in the colorway one, two: recipe linen: stated 900 g/m²")


def test_another_palette_repaints_the_draft_and_keeps_its_structure(tmp_path):
    draft = load(TWILL)
    rose = tmp_path / "rose.wif"
    rose.write_bytes(write_wif(replace(draft, palette=1 - draft.palette, title="Rose")))
    done = weaveusd.publish(
        TWILL, preset="linen", colorways={"rose": rose}, root=tmp_path / "r", resolution=96
    )
    assert done.findings == []
    folder = done.asset.folder
    own = {path.name for path in (folder / "textures" / "rose").iterdir()}
    assert {"base_color.exr", "base_color.png"} <= own
    colored = {"base_color.exr", "base_color.png", "warp_albedo.exr", "weft_albedo.exr"}
    assert own <= {*colored, "roughness.png", "rotation.png", *map(lobe_file, LOBE_MAPS)}
    repainted = load(folder / "draft.rose.wif")
    np.testing.assert_allclose(repainted.palette, 1 - draft.palette, atol=1e-4)
    assert repainted.title == draft.title
    np.testing.assert_array_equal(repainted.drawdown(), draft.drawdown())
    assert (folder / "recipe.rose.toml").read_bytes() == (folder / "recipe.toml").read_bytes()
    stage = open_stage(done.asset.entry)
    stage.GetDefaultPrim().GetVariantSet(COLORWAYS).SetVariantSelection("rose")
    material = stage.GetDefaultPrim().GetChild("Material")
    assert material.GetAttribute("weave:draft").Get().path == "./draft.rose.wif"


def test_a_palette_with_too_few_colors_is_refused(tmp_path):
    draft = load(TWILL)
    poor = tmp_path / "poor.wif"
    poor.write_bytes(
        write_wif(
            replace(
                draft, palette=draft.palette[:1], warp_color=0 * draft.warp_color,
                weft_color=0 * draft.weft_color,
            )
        )
    )  # fmt: skip
    with pytest.raises(InputError, match=r"poor.wif: has 1 colors, expected at least the \d"):
        weaveusd.publish(TWILL, preset="linen", colorways={"p": poor}, root=tmp_path / "r")


def command(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "weaveusd", "publish", str(TWILL), *map(str, arguments)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.parametrize("options", [["x"], ["=wool"], ["x="], ["x=wool", "x=linen"]])
def test_a_colorway_option_without_name_or_recipe_is_a_mistake_in_the_arguments(options, tmp_path):
    named = [part for option in options for part in ("--colorway", option)]
    done = command("--preset", "linen", "--root", tmp_path / "r", *named)
    assert done.returncode == 2
    assert "--colorway" in done.stderr
    assert not (tmp_path / "r").exists()


def test_the_command_publishes_colorways_and_says_how_far_each_network_is_off(tmp_path):
    done = command(
        "--preset", "linen", "--root", tmp_path, "--colorway", "dark=denim", "--resolution", 64,
        "--name", "pair",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert re.search(r"^  networks  mitsuba, openpbr \d+% off, ", done.stdout, re.MULTILINE)
    assert re.search(r"^  note  dark: weft_2 is .* fibres reach ", done.stdout, re.MULTILINE)
    stage = open_stage(tmp_path / "pair" / "v001" / "pair.usda")
    names = stage.GetDefaultPrim().GetVariantSet(COLORWAYS).GetVariantNames()
    assert names == ["dark", "linen"]


def test_a_fault_in_a_colorway_is_found_and_named(published, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(published.asset.folder, copy)
    (copy / "manifest.json").unlink()
    look = copy / "look.warm.usda"
    look.write_text(look.read_text().replace("weave:thickness = ", "weave:thickness = -"))
    report = validate(copy / "trio.usda")
    wrong = [f for f in report.findings if f.status > Status.SKIP]
    assert wrong
    assert all(f.message.startswith("in the colorway warm: ") for f in wrong)


def test_a_missing_texture_of_a_colorway_is_found(published, tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(published.asset.folder, copy)
    (copy / "manifest.json").unlink()
    (copy / "textures" / "cool" / "yarn_id.png").unlink()
    assert not validate(copy / "trio.usda").passed


@pytest.mark.parametrize(
    ("colorways", "said"),
    [
        ({"linen": "wool"}, "default recipe has that name"),
        ({"../x": "wool"}, "expected a name such as 'x'"),
        ({"x": "no_such_preset"}, "no preset"),
        ({"x": "missing.toml"}, "missing.toml"),
        ({f"c{i}": "wool" for i in range(64)}, "at most 64"),
    ],
)
def test_a_wrong_colorway_is_refused_before_anything_is_made(tmp_path, colorways, said):
    with pytest.raises(InputError, match=said):
        weaveusd.publish(TWILL, preset="linen", colorways=colorways, root=tmp_path / "r")
    assert not (tmp_path / "r").exists()
