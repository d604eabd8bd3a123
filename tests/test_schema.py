"""The committed schema is the one that the contract gives, and USD knows it as such."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Sdf, Sdr, Usd, UsdShade

from weaveusd import stage as stages
from weaveusd.contract import (
    CLOTH_API,
    CLOTH_ATTRIBUTES,
    CLOTH_SHADER_ID,
    SHADER_FILES,
    SHADER_UV_SCALE,
    SHADER_VARNAME,
    SHADER_YARN_ARRAYS,
    YARN_API,
    YARN_ATTRIBUTES,
    moment_inputs,
)
from weaveusd.export.attributes import cloth_values, yarn_values
from weaveusd.making import make_material, read_draft
from weaveusd.patch import Patch
from weaveusd.yarn.recipe import preset_names, read_preset

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = ROOT / "scripts" / "generate_schema.py"


@pytest.fixture(scope="module")
def stage() -> Usd.Stage:
    stages.require()
    return Usd.Stage.CreateInMemory()


@pytest.fixture(scope="module")
def prim(stage) -> Usd.Prim:
    prim = UsdShade.Material.Define(stage, "/Material").GetPrim()
    prim.ApplyAPI(CLOTH_API)
    prim.ApplyAPI(YARN_API, "warp")
    return prim


def generate(*arguments: str, script: Path = SCRIPT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, str(script), *arguments], capture_output=True, text=True, check=False
    )


def test_the_committed_files_are_up_to_date():
    done = generate("--check")
    assert done.returncode == 0, done.stderr


def test_stale_files_are_named_and_fail_the_check(tmp_path):
    (tmp_path / "scripts").mkdir()
    script = tmp_path / "scripts" / "generate_schema.py"
    script.write_text(SCRIPT.read_text())
    assert generate(script=script).returncode == 0
    assert generate("--check", script=script).returncode == 0
    stale = tmp_path / "schemas/weaveCloth/generatedSchema.usda"
    stale.write_text(stale.read_text() + "# edited\n")
    done = generate("--check", script=script)
    assert done.returncode == 1
    assert done.stderr.splitlines() == [f"{stale}: out of date; run scripts/generate_schema.py"]


def test_usd_knows_every_attribute_with_type_doc_limits_and_tokens(prim):
    expected = {f"weave:{a.name}": a for a in CLOTH_ATTRIBUTES}
    expected |= {f"weave:yarn:warp:{a.name}": a for a in YARN_ATTRIBUTES}
    assert {n for n in prim.GetPropertyNames() if n.startswith("weave:")} == set(expected)
    for name, attribute in expected.items():
        got = prim.GetAttribute(name)
        assert str(got.GetTypeName()) == attribute.type
        assert attribute.meaning[1:] in got.GetDocumentation()
        if attribute.unit not in ("", "1"):
            assert f"Unit: {attribute.unit}." in got.GetDocumentation()
        schema = "Yarn" if attribute in YARN_ATTRIBUTES else "Cloth"
        assert attribute.group
        assert got.GetDisplayGroup() == f"{schema}:{attribute.group}"
        assert tuple(got.GetMetadata("allowedTokens") or ()) == attribute.tokens
        for limits, found in (
            (attribute.hard, got.GetHardLimits()),
            (attribute.soft, got.GetSoftLimits()),
        ):
            for limit, value in zip(limits, (found.GetMinimum(), found.GetMaximum()), strict=True):
                if limit is None:
                    assert value is None
                else:
                    values = value if attribute.type == "color3f" else [value]
                    assert all(v == limit for v in values)


def test_every_attribute_has_a_name_to_show_that_no_other_has(prim):
    def shown(*names: str) -> list[str]:
        return [prim.GetAttribute(name).GetDisplayName() for name in names]

    for prefix, attributes in (("weave", CLOTH_ATTRIBUTES), ("weave:yarn:warp", YARN_ATTRIBUTES)):
        labels = shown(*(f"{prefix}:{a.name}" for a in attributes))
        assert all(labels)
        assert len(set(labels)) == len(labels)
    assert shown("weave:longestFloat", "weave:endsPerCm") == ["Longest Float", "Ends per cm"]
    assert shown("weave:yarn:warp:eta", "weave:yarn:warp:width") == ["IOR", "Width"]


def test_usual_values_lie_within_the_hard_limits():
    for attribute in (*CLOTH_ATTRIBUTES, *YARN_ATTRIBUTES):
        (low, high), (least, most) = attribute.soft, attribute.hard
        if (low, high) != (None, None):
            assert low < high
            assert least is None or least <= low
            assert most is None or high <= most


@pytest.mark.parametrize(
    "preset",
    [name if name in ("chiffon", "denim") else pytest.param(name, marks=pytest.mark.slow)
     for name in preset_names()],
)  # fmt: skip
def test_the_values_of_a_preset_are_usual(preset):
    draft = read_draft(ROOT / "examples" / "drafts" / "twill_2_2.wif")
    material = make_material(draft, read_preset(preset), "cloth", patch=Patch(16))
    stated = [(CLOTH_ATTRIBUTES, cloth_values(material, 1.0))]
    stated += [(YARN_ATTRIBUTES, values) for values in yarn_values(material).values()]
    for attributes, values in stated:
        for attribute in attributes:
            low, high = attribute.soft
            assert low is None or low <= values[attribute.name], attribute.name
            assert high is None or values[attribute.name] <= high, attribute.name


def test_both_schemas_are_for_materials_and_have_no_code(prim):
    registry = Usd.SchemaRegistry()
    assert registry.GetAPISchemaCanOnlyApplyToTypeNames(CLOTH_API) == ["Material"]
    assert registry.GetAPISchemaCanOnlyApplyToTypeNames(YARN_API) == ["Material"]
    info = json.loads((stages.schema_dir() / "weaveCloth" / "plugInfo.json").read_text())
    assert info["Plugins"][0]["Type"] == "resource"
    assert "@" not in json.dumps(info)


def test_sdr_learns_the_exact_shader_with_its_types():
    stages.teach_sdr()
    node = Sdr.Registry().GetShaderNodeByIdentifier(CLOTH_SHADER_ID)
    types = {name: node.GetShaderInput(name).GetTypeAsSdfType().GetSdfType()
             for name in node.GetShaderInputNames()}  # fmt: skip
    names = Sdf.ValueTypeNames
    expected = dict.fromkeys(SHADER_FILES, names.Asset)
    expected |= dict.fromkeys(SHADER_YARN_ARRAYS, names.FloatArray)
    expected |= {SHADER_UV_SCALE: names.Float2, SHADER_VARNAME: names.String}
    expected |= {name: names.Find(kind) for name, kind in moment_inputs().items()}
    assert types == expected
    assert list(node.GetShaderOutputNames()) == ["surface"]
