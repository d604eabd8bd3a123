from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from pxr import Sdr, Usd

from weaveusd import contract, stage
from weaveusd.errors import StageError


@pytest.fixture
def good(tmp_path: Path) -> Path:
    path = tmp_path / "good.usda"
    path.write_text('#usda 1.0\n(\n    defaultPrim = "A"\n)\n\ndef Scope "A"\n{\n}\n')
    return path


def test_an_opened_stage_knows_our_schema(good: Path) -> None:
    opened = stage.open_stage(good)
    assert opened.GetDefaultPrim().GetName() == "A"
    definition = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(contract.CLOTH_API)
    assert f"weave:{contract.CLOTH_ATTRIBUTES[0].name}" in definition.GetPropertyNames()


def test_a_stage_outlives_a_change_of_working_directory(
    good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    opened = stage.open_stage("good.usda")
    monkeypatch.chdir("/")
    opened.Reload()
    assert opened.GetDefaultPrim()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("absent.usda", None, "no such file"),
        ("scene.txt", b"#usda 1.0\n", "not a USD file, expected one of .usda"),
        ("broken.usda", b'#usda 1.0\n(\n  defaultPrim = = "x"\n)\n', ": 3:3: Expected"),
        ("noise.usda", bytes(range(256)), "not a valid usda layer"),
        ("noise.usdc", bytes(range(256)), "bootstrap section corrupt"),
        ("cut.usdc", b"PXR-USDC", "not a USD layer"),
        ("cut.usdz", b"PK\x03\x04", "not a USD layer"),
        ("empty.usda", b"", "not a USD layer"),
    ],
)
def test_what_is_no_stage_is_refused_in_one_line_and_nothing_printed(
    name: str,
    content: bytes | None,
    message: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(StageError) as caught:
        stage.open_stage(path)
    text = str(caught.value)
    assert text.startswith(f"{path}: ")
    assert message in text
    assert "\n" not in text
    assert text.count(str(tmp_path)) == 1
    assert capfd.readouterr() == ("", "")


def test_a_folder_is_no_stage(tmp_path: Path) -> None:
    (tmp_path / "folder.usda").mkdir()
    with pytest.raises(StageError, match="not a file"):
        stage.open_stage(tmp_path / "folder.usda")


def test_a_file_that_is_too_big_is_not_parsed(tmp_path: Path) -> None:
    path = tmp_path / "big.usda"
    with path.open("wb") as stream:
        stream.write(b"#usda 1.0\n")
        stream.truncate(stage.MAX_TEXT_BYTES + 1)
    with pytest.raises(StageError, match=f"expected at most {stage.MAX_TEXT_BYTES}"):
        stage.open_stage(path)


def test_a_reference_that_leads_nowhere_is_left_to_the_caller_in_silence(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "torn.usda"
    path.write_text('#usda 1.0\ndef Scope "A" (references = @./absent.usda@)\n{\n}\n')
    assert len(stage.open_stage(path).GetCompositionErrors()) == 1
    assert capfd.readouterr() == ("", "")


def test_materialx_nodes_and_our_own_are_known_after_teaching() -> None:
    stage.teach_sdr()
    node = Sdr.Registry().GetShaderNodeByIdentifier("ND_open_pbr_surface_surfaceshader")
    assert "geometry_tangent" in node.GetShaderInputNames()
    ours = Sdr.Registry().GetShaderNodeByIdentifier(contract.CLOTH_SHADER_ID)
    expected = {*contract.SHADER_FILES, *contract.SHADER_YARN_ARRAYS, *contract.moment_inputs()}
    assert set(ours.GetShaderInputNames()) == expected | {
        contract.SHADER_UV_SCALE,
        contract.SHADER_VARNAME,
    }


def python(code: str) -> str:
    environment = {k: v for k, v in os.environ.items() if k != "PXR_PLUGINPATH_NAME"}
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    return run.stdout


def test_registering_too_late_is_explained() -> None:
    said = python(
        "from pxr import Usd\n"
        "Usd.SchemaRegistry().FindConcretePrimDefinition('Mesh')\n"
        "from weaveusd import stage, errors\n"
        "try: stage.require()\n"
        "except errors.StageError as error: print(error)\n"
    )
    assert "before ours was registered" in said
    assert len(said.splitlines()) == 1


def test_registering_twice_is_registering_once() -> None:
    said = python("from weaveusd.stage import require\nrequire()\nrequire()\nprint('known')")
    assert said == "known\n"


def test_importing_weaveusd_loads_no_usd() -> None:
    said = python(
        "import sys, weaveusd, weaveusd.validate\n"
        "print([m for m in ('pxr', 'OpenImageIO', 'MaterialX', 'mitsuba') if m in sys.modules])"
    )
    assert said == "[]\n"
