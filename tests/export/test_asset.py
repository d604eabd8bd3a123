"""A written asset says everything, in files that can be moved, the same every time."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from pxr import Sdf, Sdr, Usd, UsdGeom, UsdShade, UsdUtils, UsdValidation

from tests.export.cloths import FIT, FITS, cloth, texture_files, yarn
from weaveusd import stage as stages
from weaveusd.contract import (
    CLOTH_API,
    CLOTH_ATTRIBUTES,
    CLOTH_SHADER_ID,
    KINDS,
    MTLX_SURFACES,
    MTLX_VARIANTS,
    SHADER_FILES,
    SHADER_YARN_ARRAYS,
    YARN_API,
    YARN_ATTRIBUTES,
    kinds_input,
    moment_input,
    section_input,
)
from weaveusd.export.asset import write_asset
from weaveusd.export.moments import system_maps
from weaveusd.shading.material import ClothMaterial, StandardFit

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("asset")
    write_asset(cloth(), path)
    return path


@pytest.fixture(scope="module")
def stage(folder) -> Usd.Stage:
    return stages.open_stage(folder / "plain.usda")


@pytest.fixture(scope="module")
def material(stage) -> UsdShade.Material:
    return UsdShade.Material(stage.GetPrimAtPath("/plain/Material"))


def listing(folder: Path) -> dict[str, bytes]:
    files = [p for p in folder.rglob("*") if p.is_file()]
    return {str(p.relative_to(folder)): p.read_bytes() for p in files}


def surface(material: UsdShade.Material, context: str = "") -> UsdShade.Shader:
    return material.ComputeSurfaceSource(context)[0]


def upstream(shader: UsdShade.Shader, name: str) -> UsdShade.Shader:
    """Return the shader that feeds the input `name`."""
    source = shader.GetInput(name).GetConnectedSources()[0][0]
    return UsdShade.Shader(source.source.GetPrim())


def asset_paths(layer: Sdf.Layer) -> list[str]:
    found = list(layer.externalReferences)

    def visit(path: Sdf.Path) -> None:
        if path.IsPropertyPath():
            value = layer.GetAttributeAtPath(path).default
            if isinstance(value, Sdf.AssetPath):
                found.append(value.path)

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return found


def test_the_folder_holds_the_files_of_the_contract(folder):
    assert sorted(listing(folder)) == sorted(
        ["README.md", "draft.wif", "look.usda", "material.mtlx", "plain.usda", "recipe.toml"]
        + [f"textures/{file}" for file in texture_files()]
    )


def test_the_entry_layer_names_the_asset_and_references_the_look(stage):
    root = stage.GetDefaultPrim()
    assert (root.GetName(), root.GetTypeName()) == ("plain", "Scope")
    assert root.GetAssetInfoByKey("name") == "plain"
    assert root.GetAssetInfoByKey("identifier").path == "./plain.usda"
    assert [c.GetName() for c in root.GetChildren()] == ["Material"]
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert Sdf.Layer.FindOrOpen(stage.GetRootLayer().identifier).externalReferences == [
        "./look.usda"
    ]


def test_every_attribute_of_the_contract_is_authored_with_its_type(material):
    prim = material.GetPrim()
    assert prim.GetAppliedSchemas()[:3] == [CLOTH_API, f"{YARN_API}:warp", f"{YARN_API}:weft"]
    expected = {f"weave:{a.name}": a for a in CLOTH_ATTRIBUTES}
    for name in ("warp", "weft"):
        expected |= {f"weave:yarn:{name}:{a.name}": a for a in YARN_ATTRIBUTES}
    authored = {a.GetName() for a in prim.GetAuthoredAttributes()}
    assert set(expected) == {name for name in authored if name.startswith("weave:")}
    for name, attribute in expected.items():
        got = prim.GetAttribute(name)
        assert got.HasAuthoredValue(), name
        assert str(got.GetTypeName()) == attribute.type, name
        assert not got.IsCustom(), name
        if attribute.tokens:
            assert got.Get() in attribute.tokens
        low, high = attribute.hard
        if attribute.type in ("int", "double"):
            assert low is None or got.Get() >= low, name
            assert high is None or got.Get() <= high, name


def test_numbers_are_as_tidy_as_a_person_would_write_them(material):
    prim = material.GetPrim()
    assert prim.GetAttribute("weave:endsPerCm").Get() == 25.0
    assert prim.GetAttribute("weave:repeatWidth").Get() == 0.8
    text = "".join(layer.ExportToString() for layer in prim.GetStage().GetUsedLayers())
    assert "weave:endsPerCm" in text
    assert not re.search(r"\d\.\d*(0{6}|9{6})\d", text)


def test_a_reader_without_our_plugin_sees_all_values(folder):
    program = (
        "import sys; from pxr import Usd\n"
        "stage = Usd.Stage.Open(sys.argv[1])\n"
        "prim = stage.GetPrimAtPath('/plain/Material')\n"
        "print(prim.GetAttribute('weave:longestFloat').Get(),"
        " prim.GetAttribute('weave:yarn:weft:tex').Get(),"
        " *prim.GetAttribute('weave:yarns').Get())\n"
    )
    environment = {k: v for k, v in os.environ.items() if k != "PXR_PLUGINPATH_NAME"}
    done = subprocess.run(
        [sys.executable, "-c", program, str(folder / "plain.usda")],
        capture_output=True, text=True, check=True, env=environment,
    )  # fmt: skip
    assert done.stdout.split() == ["1", "66.0", "warp", "weft"]


def test_writing_leaves_usd_free_to_register_our_schema(tmp_path):
    program = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from pathlib import Path\n"
        "from tests.export.cloths import cloth\n"
        "from weaveusd.export.asset import write_asset\n"
        "entry = write_asset(cloth(), Path(sys.argv[2]))\n"
        "from weaveusd.stage import open_stage\n"
        "stage = open_stage(entry)\n"
        "assert stage.GetPrimAtPath('/plain/Material').HasAPI('WeaveClothAPI')\n"
    )
    subprocess.run([sys.executable, "-c", program, str(ROOT), str(tmp_path)], check=True)


def test_everything_resolves_after_a_move_and_from_another_folder(tmp_path, monkeypatch):
    (tmp_path / "made").mkdir()
    write_asset(cloth(), tmp_path / "made")
    (tmp_path / "elsewhere").mkdir()
    moved = Path(shutil.move(tmp_path / "made", tmp_path / "elsewhere" / "kept"))
    monkeypatch.chdir("/")
    layers, assets, unresolved = UsdUtils.ComputeAllDependencies(str(moved / "plain.usda"))
    assert not unresolved
    assert {Path(layer.realPath) for layer in layers} == {moved / "plain.usda", moved / "look.usda"}
    assert len(assets) == len(listing(moved)) - len(
        ["plain.usda", "look.usda", "material.mtlx", "README.md"]
    )
    assert all(Path(a).is_relative_to(moved) for a in assets)


def test_every_path_is_anchored_and_stays_inside(folder):
    paths = [
        path
        for name in ("plain.usda", "look.usda")
        for path in asset_paths(Sdf.Layer.FindOrOpen(str(folder / name)))
    ]
    assert len(paths) > 10
    for path in paths:
        assert path.startswith("./"), path
        assert ".." not in path
        assert (folder / path).is_file(), path
    for content in (folder / "plain.usda", folder / "look.usda", folder / "material.mtlx"):
        assert str(folder) not in content.read_text()


def test_the_same_cloth_gives_the_same_bytes(folder, tmp_path):
    for salt in ("1", "2"):
        target = tmp_path / salt
        target.mkdir()
        program = (
            "import sys; sys.path.insert(0, sys.argv[1])\n"
            "from pathlib import Path\n"
            "from tests.export.cloths import cloth\n"
            "from weaveusd.export.asset import write_asset\n"
            "write_asset(cloth(), Path(sys.argv[2]))\n"
        )
        subprocess.run(
            [sys.executable, "-c", program, str(ROOT), str(target)],
            check=True, env={**os.environ, "PYTHONHASHSEED": salt},
        )  # fmt: skip
        assert listing(target) == listing(folder)


def test_usd_finds_nothing_to_complain_about(stage):
    stages.teach_sdr()
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert [e.GetMessage() for e in errors] == []


def test_every_shader_has_inputs_and_types_that_its_definition_knows(stage, material):
    stages.teach_sdr()
    shaders = [UsdShade.Shader(p) for p in stage.Traverse() if p.IsA(UsdShade.Shader)]
    assert len(shaders) > 10
    for shader in shaders:
        node = Sdr.Registry().GetShaderNodeByIdentifier(shader.GetShaderId())
        assert node, shader.GetShaderId()
        for put in shader.GetInputs():
            known = node.GetShaderInput(put.GetBaseName())
            assert known, put.GetFullName()
            assert known.GetTypeAsSdfType().GetSdfType() == put.GetTypeName(), put.GetFullName()
        for out in shader.GetOutputs():
            assert out.GetBaseName() in node.GetShaderOutputNames()


@pytest.mark.parametrize("context", ["", "mtlx", "mitsuba"])
def test_each_network_takes_coordinates_times_the_one_public_input(stage, material, context):
    scale = material.GetInput("uv_scale")
    assert tuple(scale.Get()) == (1250.0, 1000.0)
    assert "metres" in scale.GetAttr().GetDocumentation()
    name = {"": "PreviewRepeats", "mtlx": "MtlxRepeats", "mitsuba": "MitsubaSurface"}[context]
    shader = UsdShade.Shader(material.GetPrim().GetChild(name))
    key = {"": "scale", "mtlx": "in2", "mitsuba": "uv_scale"}[context]
    assert shader.GetInput(key).GetValueProducingAttributes()[0] == scale.GetAttr()
    assert surface(material, context)
    textures = [
        UsdShade.Shader(p)
        for p in material.GetPrim().GetChildren()
        if "image" in str(UsdShade.Shader(p).GetShaderId()).lower()
        or UsdShade.Shader(p).GetShaderId() == "UsdUVTexture"
    ]
    for texture in textures:
        feed = upstream(texture, "st" if texture.GetInput("st") else "texcoord")
        assert feed.GetPrim().GetName() in ("PreviewRepeats", "MtlxRepeats")


def test_the_primvar_can_be_renamed_in_one_place(material):
    varname = material.GetInput("varname")
    assert varname.Get() == "st"
    for name, key in [
        ("PreviewCoordinates", "varname"),
        ("MtlxCoordinates", "geomprop"),
        ("MitsubaSurface", "varname"),
    ]:
        shader = UsdShade.Shader(material.GetPrim().GetChild(name))
        assert shader.GetInput(key).GetValueProducingAttributes()[0] == varname.GetAttr()


def test_the_preview_decodes_its_textures(material):
    shader = surface(material)
    assert shader.GetShaderId() == "UsdPreviewSurface"
    color, normal = upstream(shader, "diffuseColor"), upstream(shader, "normal")
    assert color.GetInput("sourceColorSpace").Get() == "sRGB"
    assert normal.GetInput("sourceColorSpace").Get() == "raw"
    assert tuple(normal.GetInput("scale").Get()) == (2, 2, 2, 1)
    assert tuple(normal.GetInput("bias").Get()) == (-1, -1, -1, 0)
    assert upstream(shader, "opacity").GetInput("sourceColorSpace").Get() == "raw"


def test_openpbr_stretches_its_highlight_across_the_fibre(material):
    shader = surface(material, "mtlx")
    assert shader.GetShaderId() == "ND_open_pbr_surface_surfaceshader"
    across = upstream(shader, "geometry_tangent")
    plane_x, plane_y = (upstream(upstream(across, name), "in1") for name in ("in1", "in2"))
    normal = upstream(plane_x, "in2")
    assert upstream(normal, "in").GetInput("file").Get().path == "./textures/normal.png"
    assert upstream(plane_x, "in1").GetPath() == plane_y.GetPath()
    for part, function in (("in1", "ND_cos_float"), ("in2", "ND_sin_float")):
        turned = upstream(upstream(across, part), "in2")
        assert turned.GetShaderId() == function
        angle = upstream(turned, "in")
        assert angle.GetInput("in2").Get() == 0.5
        rotation = upstream(upstream(upstream(angle, "in1"), "inx"), "in")
        assert rotation.GetInput("file").Get().path == "./textures/rotation.exr"
    color = upstream(shader, "base_color").GetInput("file")
    assert color.GetAttr().GetColorSpace() == "srgb_texture"
    assert material.GetPrim().GetAttribute("config:mtlx:version").Get() == "1.39"


def test_standard_surface_is_a_variant_of_the_same_output(folder):
    stage = stages.open_stage(folder / "plain.usda")
    material = UsdShade.Material(stage.GetPrimAtPath("/plain/Material"))
    variants = material.GetPrim().GetVariantSet(MTLX_SURFACES)
    assert variants.GetVariantNames() == sorted(MTLX_VARIANTS)
    assert variants.GetVariantSelection() == "openPbr"
    openpbr = surface(material, "mtlx")
    variants.SetVariantSelection("standardSurface")
    standard = surface(material, "mtlx")
    assert standard.GetShaderId() == "ND_standard_surface_surfaceshader"
    assert (
        upstream(standard, "tangent").GetPath() == upstream(openpbr, "geometry_tangent").GetPath()
    )
    assert upstream(standard, "base_color").GetPath() == upstream(openpbr, "base_color").GetPath()
    assert standard.GetInput("specular_anisotropy").Get() == pytest.approx(0.75)
    assert surface(material).GetShaderId() == "UsdPreviewSurface"


def test_the_weight_of_the_base_reaches_every_standard_network(tmp_path):
    material = cloth()
    fits = replace(
        FITS, together=replace(FIT, base=0.5), yarns=(replace(FIT, base=0.6),) * 2,
        isotropic=replace(FITS.isotropic, base=0.7),
    )  # fmt: skip
    write_asset(replace(material, fits=fits), tmp_path)
    stage = stages.open_stage(tmp_path / "plain.usda")
    prim = stage.GetPrimAtPath("/plain/Material")

    def value(shader, name):
        return prim.GetChild(shader).GetAttribute(f"inputs:{name}").Get()

    assert value("MtlxStandard", "base") == pytest.approx(0.5)
    assert value("MtlxSurface", "base_weight") == pytest.approx(0.6)
    assert tuple(value("PreviewBaseColor", "scale")) == pytest.approx((0.7, 0.7, 0.7, 1))


def test_the_recipe_lies_beside_the_draft_byte_for_byte(tmp_path):
    material = cloth()
    recipe = "name = 'ünïcode'\r\n# kept\n".encode()
    provenance = replace(material.provenance, recipe_toml=recipe)
    write_asset(replace(material, provenance=provenance), tmp_path)
    assert (tmp_path / "recipe.toml").read_bytes() == recipe
    stage = stages.open_stage(tmp_path / "plain.usda")
    file = stage.GetPrimAtPath("/plain/Material").GetAttribute("weave:recipeFile").Get()
    assert Path(file.resolvedPath) == tmp_path / "recipe.toml"


def test_the_exact_shader_names_its_textures_and_the_optics_of_each_yarn(material):
    shader = surface(material, "mitsuba")
    assert shader.GetShaderId() == CLOTH_SHADER_ID
    for name, file in SHADER_FILES.items():
        assert shader.GetInput(name).Get().path == f"./textures/{file}"
    for name in SHADER_YARN_ARRAYS:
        assert len(shader.GetInput(name).Get()) == 2
    assert list(shader.GetInput("normalization").Get()) == pytest.approx([1.8608, 1.75])


def test_the_exact_shader_names_the_moment_maps_their_sections_and_the_kinds_of_yarn(
    material, folder
):
    shader = surface(material, "mitsuba")
    found = []
    for maps in system_maps(cloth().weave):
        for name, file in zip(maps.names, maps.files, strict=True):
            found.append(shader.GetInput(moment_input(maps.system, name)).Get().path)
            assert found[-1] == f"./textures/{file}"
            assert (folder / found[-1]).is_file()
        section = shader.GetInput(section_input(maps.system)).Get()
        assert tuple(section) == (maps.flatness, maps.curvature)
        assert tuple(shader.GetInput(kinds_input(maps.system)).Get()) == maps.kinds
        assert not shader.GetInput(moment_input(maps.system, KINDS))
    listed = material.GetPrim().GetAttribute("weave:momentMaps").Get()
    assert [asset.path for asset in listed] == found


@pytest.mark.parametrize(
    "title", ['"""', "a\nb", "@x@", "\u202e rtl", "x" * 5000, "\ud800", "nul\0", "'''\"\"\""]
)
def test_a_hostile_title_stays_a_string(tmp_path, title):
    write_asset(cloth(title=title), tmp_path)
    stage = stages.open_stage(tmp_path / "plain.usda")
    assert [p.GetName() for p in stage.GetPseudoRoot().GetChildren()] == ["plain"]
    written = stage.GetPrimAtPath("/plain/Material").GetAttribute("weave:draftTitle").Get()
    assert "\n" not in written
    assert len(written) <= 1000


def test_hostile_yarn_names_become_distinct_instances(tmp_path):
    material = cloth()
    yarns = (yarn("tex", "warp"), yarn("../x y", "weft"))
    weave = replace(material.weave, yarns=yarns)
    write_asset(replace(material, weave=weave), tmp_path)
    stage = stages.open_stage(tmp_path / "plain.usda")
    prim = stage.GetPrimAtPath("/plain/Material")
    assert list(prim.GetAttribute("weave:yarns").Get()) == ["tex_yarn", "x_y"]
    assert prim.HasAPI(YARN_API, "tex_yarn")
    assert prim.GetAttribute("weave:yarn:x_y:id").Get() == 2


def broken_cloths() -> list[ClothMaterial]:
    material = cloth()
    return [
        replace(material, name="a b"),
        replace(material, name="look"),
        replace(material, normalization=(1.0,)),
        replace(material, fits=replace(FITS, together=StandardFit(0.8, 0.2, 0.04))),
        replace(material, fits=replace(FITS, isotropic=StandardFit(0.0, 0.2, 0.04))),
        replace(material, fits=replace(FITS, yarns=(FIT, StandardFit(0.1, 0.2, 1.0)))),
        replace(material, fits=replace(FITS, yarns=(FIT,))),
    ]


@pytest.mark.parametrize("material", broken_cloths())
def test_a_broken_cloth_leaves_the_folder_empty(tmp_path, material):
    with pytest.raises(ValueError, match=r"expected|safe"):
        write_asset(material, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_empty_is_refused(tmp_path):
    (tmp_path / "mine").touch()
    with pytest.raises(ValueError, match="empty"):
        write_asset(cloth(), tmp_path)
