"""The command line keeps its promises to a pipeline: status, one object, nothing else."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from weaveusd._version import __version__

ROOT = Path(__file__).parents[1]
TWILL = ROOT / "examples" / "drafts" / "twill_2_2.wif"


def publish(run, root, *more, draft=TWILL):
    return run("publish", draft, "--preset", "linen", "--root", root, "--resolution", 64,
               "--json", *more)  # fmt: skip


def tree(folder: Path) -> dict[str, bytes]:
    files = (p for p in sorted(folder.rglob("*")) if p.is_file())
    return {str(p.relative_to(folder)): p.read_bytes() for p in files}


def test_publish_answers_with_one_object_and_every_key(run, tmp_path):
    status, out, err = publish(run, tmp_path)
    assert status == 0
    assert err == ""
    result = json.loads(out)
    assert result["status"] == "published"
    assert result["asset"] == "twill_2_2_linen"
    assert result["version"] == "v001"
    assert Path(result["entry"]).is_file()
    assert result["material"] == "/twill_2_2_linen/Material"
    assert result["seconds"] > 0
    assert result["findings"] == []
    for file in result["files"]:
        assert (tmp_path / result["asset"] / "v001" / file["path"]).stat().st_size == file["bytes"]
        assert re.fullmatch("[0-9a-f]{64}", file["sha256"])


def test_publishing_twice_is_unchanged_and_the_same_bytes(run, tmp_path):
    publish(run, tmp_path / "a")
    before = tree(tmp_path / "a")
    status, out, _ = publish(run, tmp_path / "a")
    assert (status, json.loads(out)["status"]) == (0, "unchanged")
    assert tree(tmp_path / "a") == before
    publish(run, tmp_path / "b")
    assert tree(tmp_path / "b") == before


def test_other_content_is_the_next_version_and_never_an_old_one(run, tmp_path):
    publish(run, tmp_path)
    before = tree(tmp_path)
    status, out, err = publish(run, tmp_path, "--seed", 1, "--version", "v001")
    assert status == 5
    assert json.loads(out)["status"] == "failed"
    assert err.count("\n") == 1
    assert tree(tmp_path) == before
    status, out, _ = publish(run, tmp_path, "--seed", 1)
    assert (status, json.loads(out)["version"]) == (0, "v002")


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["publish", "nowhere.wif", "--preset", "linen", "--root", "."], 3, "nowhere.wif"),
        (["publish", TWILL, "--preset", "steel", "--root", "."], 3, "no preset 'steel'"),
        (["publish", TWILL, "--recipe", "nowhere.toml", "--root", "."], 3, "nowhere.toml"),
        (["publish", TWILL, "--root", "."], 2, "exactly one"),
        (["publish", TWILL, "--preset", "linen"], 2, "--root"),
        (["publish", TWILL, "--preset", "linen", "--root", ".", "--resolution", "1"], 3, "8 to"),
        (["publish", TWILL, "--preset", "linen", "--root", ".", "--seed", "-1"], 3, "seed"),
        (["publish", TWILL, "--preset", "linen", "--root", ".", "--version", "latest"], 3, "next"),
        (["publish", TWILL, "--preset", "linen", "--root", ".", "--repeats", "2"], 2, "4x3"),
        (["publish", TWILL, "--preset", "linen", "--root", ".", "--repeats", "9999x9"], 3, "4096"),
        (
            [
                "publish",
                TWILL,
                "--preset",
                "linen",
                "--root",
                ".",
                "--repeats",
                "2x2",
                "--patch-mm",
                "9x9",
            ],
            3,
            "not both",
        ),
        (
            ["publish", TWILL, "--preset", "linen", "--root", ".", "--texels-per-mm", "9999"],
            3,
            "texels of a patch",
        ),
        (["validate", "nowhere.usda"], 3, "nowhere.usda"),
        (["render", "nowhere.usda", "--output", "x.png"], 3, "nowhere.usda"),
        (["inspect", "nowhere.wif"], 3, "nowhere.wif"),
        (["presets", "steel"], 3, "no preset"),
        (["weave"], 2, "weave"),
    ],
)
def test_a_mistake_is_one_line_and_its_own_status(
    run, tmp_path, monkeypatch, arguments, status, message
):
    monkeypatch.chdir(tmp_path)
    found, out, err = run(*arguments)
    assert found == status
    assert out == ""
    assert message in err
    assert err.count("\n") == 1
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []


def test_debug_shows_where(run):
    _, _, err = run("presets", "steel", "--debug")
    assert "Traceback" in err


def test_a_slip_of_ours_is_an_internal_error(run, monkeypatch):
    monkeypatch.setattr("weaveusd.pipeline.presets", lambda name: 1 / 0)
    status, _, err = run("presets")
    assert status == 1
    assert err.startswith("weaveusd: internal error: ZeroDivisionError")


def test_what_fails_its_checks_is_not_published(run, tmp_path, monkeypatch):
    def upside_down(material, folder, **settings):
        entry = write_asset(material, folder, **settings)
        (folder / "textures" / "normal.exr").unlink()
        shutil.copy(folder / "textures" / "tangent.exr", folder / "textures" / "normal.exr")
        return entry

    from weaveusd.export.asset import write_asset

    monkeypatch.setattr("weaveusd.export.asset.write_asset", upside_down)
    status, out, err = publish(run, tmp_path / "root")
    assert status == 4
    assert err.count("\n") == 1
    result = json.loads(out)
    assert result["status"] == "failed"
    assert any(f["status"] == "FAIL" for f in result["findings"])
    assert not any(p.is_file() for p in (tmp_path / "root").rglob("*.usda"))


def test_validate_says_four_when_a_file_was_changed(run, tmp_path):
    _, out, _ = publish(run, tmp_path)
    entry = Path(json.loads(out)["entry"])
    assert run("validate", entry)[0] == 0
    (entry.parent / "draft.wif").write_text("[WIF]\n")
    status, out, _ = run("validate", entry, "--json")
    assert status == 4
    report = json.loads(out)
    assert not report["passed"]


def test_a_recipe_of_ones_own_is_published(run, tmp_path):
    recipe = tmp_path / "mine.toml"
    preset = ROOT / "weaveusd" / "yarn" / "presets" / "linen.toml"
    recipe.write_text(preset.read_text().replace('name = "linen"\ntitle', 'name = "mine"\ntitle'))
    status, out, _ = run("publish", TWILL, "--recipe", recipe, "--root", tmp_path / "root",
                         "--resolution", 64, "--json")  # fmt: skip
    assert (status, json.loads(out)["asset"]) == (0, "twill_2_2_mine")


def test_the_color_space_is_chosen_and_no_other_is_known(run, tmp_path):
    for space in ("acescg", "lin_rec709"):
        status, out, _ = publish(run, tmp_path / space, "--color-space", space)
        assert status == 0
        look = Path(json.loads(out)["entry"]).with_name("look.usda").read_text()
        assert f'weave:colorSpace = "{space}"' in look
    publish(run, tmp_path / "default")
    assert tree(tmp_path / "default") == tree(tmp_path / "lin_rec709")
    status, _, err = publish(run, tmp_path, "--color-space", "rec2020")
    assert status == 2
    assert "'rec2020' is not one of 'lin_rec709', 'acescg'" in err


def test_presets_are_listed_with_their_source(run):
    status, out, _ = run("presets", "--json")
    assert status == 0
    listed = json.loads(out)
    assert {"cotton", "linen", "wool", "silk", "polyester"} <= {p["name"] for p in listed}
    assert all(p["title"] and p["kind"] and p["source"] for p in listed)


def test_one_preset_shows_its_numbers_and_their_source(run):
    status, out, _ = run("presets", "silk")
    assert status == 0
    for said in ("Sadeghi et al. 2013", "84 ", "39 picks", "gamma_s", "5°", "estimated"):
        assert said in out


def test_a_terminal_sees_a_swatch_beside_each_preset(run, monkeypatch):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    status, out, _ = run("presets")
    assert status == 0
    assert out.count("▀") >= 19 * 16 * 4
    assert "houndstooth" in out


def test_env_is_what_a_shell_can_evaluate(run):
    _, out, _ = run("env")
    found = subprocess.run(
        ["sh", "-c", out + 'printf %s "$PXR_PLUGINPATH_NAME"'],
        capture_output=True, text=True, check=True, env={},
    ).stdout  # fmt: skip
    folders = found.split(os.pathsep)
    assert len(folders) == 2
    assert all((Path(folder) / "plugInfo.json").is_file() for folder in folders)


def test_the_version_is_told(run):
    assert run("--version") == (0, f"weaveusd {__version__}\n", "")


@pytest.mark.parametrize(
    "command", [["-c", "import weaveusd"], ["-m", "weaveusd", "--help"]], ids=["import", "help"]
)
def test_nothing_heavy_is_imported_before_it_is_needed(command):
    heavy = ("numpy", "numba", "pxr", "mitsuba", "drjit", "MaterialX", "OpenImageIO", "rich")
    found = subprocess.run(
        [sys.executable, "-X", "importtime", *command], capture_output=True, text=True, check=True
    ).stderr
    imported = {line.rsplit("|", 1)[-1].strip() for line in found.splitlines()}
    assert not imported & set(heavy)
