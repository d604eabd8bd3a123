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
        low, high = attribute.hard
        hard = got.GetHardLimits()
        for limit, found in ((low, hard.GetMinimum()), (high, hard.GetMaximum())):
            if limit is None:
                assert found is None
            else:
                values = found if attribute.type == "color3f" else [found]
                assert all(value == limit for value in values)


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
