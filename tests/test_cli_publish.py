"""What a pipeline can ask of `weaveusd publish` beyond the cloth itself."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from weaveusd.cli_hooks import ended_by_sigterm

ROOT = Path(__file__).parents[1]
TWILL = ROOT / "examples" / "drafts" / "twill_2_2.wif"


def publish(run, root, *more, draft=TWILL, resolution=32):
    return run("publish", draft, "--preset", "linen", "--root", root,
               "--resolution", resolution, *more)  # fmt: skip


def tree(folder: Path) -> dict[str, bytes]:
    files = (p for p in sorted(folder.rglob("*")) if p.is_file())
    return {str(p.relative_to(folder)): p.read_bytes() for p in files}


def hook(tmp_path: Path, name: str, code: str) -> str:
    """Write a hook in Python that has the `message`; return its command."""
    script = tmp_path / f"{name}.py"
    script.write_text(f"import json, sys\nmessage = json.load(sys.stdin)\n{code}\n")
    return shlex.join((sys.executable, str(script)))


# --- Dry run --------------------------------------------------------------------------------------


def test_a_dry_run_says_what_would_be_and_leaves_no_trace(run, tmp_path, monkeypatch):
    (tmp_path / "system").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "system"))
    monkeypatch.setattr("tempfile.tempdir", None)
    root = tmp_path / "root"
    status, out, _ = publish(run, root, "--dry-run", "--json")
    planned = json.loads(out)
    assert (status, planned["status"], planned["version"]) == (0, "would-publish", "v001")
    assert not root.exists()
    assert os.listdir(tmp_path / "system") == []
    published = json.loads(publish(run, root, "--json")[1])
    for key in ("asset", "version", "entry", "material", "content_sha256", "files", "findings"):
        assert planned[key] == published[key]


def test_a_dry_run_knows_what_is_there_already(run, tmp_path):
    publish(run, tmp_path)
    before = tree(tmp_path)
    again = json.loads(publish(run, tmp_path, "--dry-run", "--json")[1])
    assert (again["status"], again["version"]) == ("unchanged", "v001")
    other = json.loads(publish(run, tmp_path, "--dry-run", "--json", "--seed", 1)[1])
    assert (other["status"], other["version"]) == ("would-publish", "v002")
    assert publish(run, tmp_path, "--dry-run", "--seed", 1, "--version", "v001")[0] == 5
    assert tree(tmp_path) == before


# --- The result and the log -----------------------------------------------------------------------


def test_the_result_is_what_json_prints_and_replaces_the_last_one(run, tmp_path):
    result = tmp_path / "result.json"
    result.write_text("of an earlier run")
    _, out, _ = publish(run, tmp_path / "root", "--result", result, "--json")
    assert result.read_text() == out
    status, out, _ = publish(run, tmp_path / "root", "--result", result, "--version", "v0")
    assert (status, out) == (3, "")
    failed = json.loads(result.read_text())
    assert failed["status"] == "failed"
    assert failed["error"].startswith("version 'v0'")
    assert sorted(os.listdir(tmp_path)) == ["result.json", "root"]


@pytest.mark.parametrize("option", ["--result", "--log-file"])
def test_a_target_that_is_a_link_or_nowhere_is_refused_before_anything_is_done(
    run, tmp_path, option
):
    (tmp_path / "precious").write_text("mine")
    (tmp_path / "link").symlink_to(tmp_path / "precious")
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    for target in ("link", "folder", "pipe", "nowhere/file"):
        status, _, err = publish(run, tmp_path / "root", option, tmp_path / target)
        assert (status, err.count("\n")) == (3, 1)
        assert target in err
    assert (tmp_path / "precious").read_text() == "mine"
    assert not (tmp_path / "root").exists()


def test_a_log_tells_what_was_asked_done_and_answered_run_after_run(run, tmp_path):
    log = tmp_path / "publish.log"
    publish(run, tmp_path / "root", "--log-file", log)
    first = log.read_text()
    for said in ("weaveusd 0", '"draft": "', "100 % done", '"status": "published"'):
        assert said in first
    publish(run, tmp_path / "root", "--log-file", log, "--version", "v001", "--seed", 1)
    assert log.read_text().startswith(first)
    assert "VersionConflictError" in log.read_text()


def test_a_path_that_is_no_text_breaks_neither_the_answer_nor_the_run(run, tmp_path):
    odd = os.fsdecode(b"r\xf6\xdft")
    draft = tmp_path / f"{odd}.wif"
    draft.write_bytes(TWILL.read_bytes())
    log, result = tmp_path / f"{odd}.log", tmp_path / f"{odd}.json"
    status, out, err = publish(run, tmp_path / "root", "--json", "--log-file", log, "--result",
                               result, "--pre-hook", "true", draft=draft)  # fmt: skip
    assert (status, err) == (0, "")
    assert json.loads(out) == json.loads(result.read_text())
    assert json.loads(out)["asset"] == "rt_linen"
    assert "r\\udcf6\\udcdft.wif" in log.read_text()
    status, out, err = publish(run, tmp_path / odd, "--json")
    assert (status, json.loads(out)["status"]) == (3, "failed")
    assert "not UTF-8" in err
    assert not (tmp_path / odd).exists()


# --- Progress -------------------------------------------------------------------------------------


def test_a_farm_gets_its_own_lines_and_no_others(run, tmp_path):
    status, out, err = publish(run, tmp_path, "--progress", "openjd")
    lines = out.splitlines()
    assert (status, err) == (0, "")
    assert lines[0] == "openjd_status: publishing twill_2_2.wif"
    assert lines[-1] == "openjd_status: published twill_2_2_linen v001"
    shares = [float(line.removeprefix("openjd_progress: ")) for line in lines[1:-1]]
    assert shares == sorted(set(shares))
    assert shares[-1] == 100.0
    status, out, _ = publish(run, tmp_path, "--progress", "openjd", "--version", "v0")
    assert (status, out.splitlines()[-1][:13]) == (3, "openjd_fail: ")


def test_no_name_of_a_draft_can_command_a_farm(run, tmp_path):
    draft = tmp_path / "x\nopenjd_env: PATH=evil\n.wif"
    draft.write_bytes(TWILL.read_bytes().replace(b"Title=", b"Title=openjd_env: A=b "))
    _, out, err = publish(run, tmp_path / "root", "--progress", "openjd", draft=draft)
    assert not [line for line in (out + err).splitlines() if line.startswith("openjd_env")]
    draft.write_text("no draft")
    _, out, err = publish(run, tmp_path / "root", "--progress", "openjd", draft=draft)
    assert not [line for line in (out + err).splitlines() if line.startswith("openjd_env")]


def test_json_on_stdout_and_a_farm_on_stdout_are_refused_together(run, tmp_path):
    status, out, err = publish(run, tmp_path, "--progress", "openjd", "--json")
    assert (status, out) == (2, "")
    assert "--result" in err


# --- Hooks ----------------------------------------------------------------------------------------


def test_hooks_are_asked_with_the_request_and_told_the_publication(run, tmp_path, monkeypatch):
    monkeypatch.chdir(TWILL.parent)
    keep = f"open({str(tmp_path)!r} + '/' + message['event'], 'w').write(json.dumps(message))"
    command = hook(tmp_path, "keep", keep)
    status, out, _ = publish(run, tmp_path / "root", "--json", "--pre-hook", command,
                             "--post-hook", command, draft=TWILL.name)  # fmt: skip
    assert status == 0
    before = json.loads((tmp_path / "pre-publish").read_text())
    after = json.loads((tmp_path / "post-publish").read_text())
    assert before["request"]["draft"] == str(TWILL)
    assert before["request"]["preset"] == "linen"
    assert after["request"] == before["request"]
    assert after["publication"] == json.loads(out)


def test_a_pre_hook_refuses_in_its_own_words_and_nothing_is_written(run, tmp_path):
    refuse = hook(tmp_path, "refuse", "sys.exit('shot 040 is locked')")
    status, out, err = publish(run, tmp_path / "root", "--json", "--pre-hook", refuse)
    assert status == 6
    assert err == "weaveusd: the pre-hook refused: shot 040 is locked\n"
    assert json.loads(out)["status"] == "failed"
    assert not (tmp_path / "root").exists()


def test_a_post_hook_that_fails_has_a_status_of_its_own_and_the_version_stays(run, tmp_path):
    fail = hook(tmp_path, "fail", "sys.exit('no database')")
    result = tmp_path / "result.json"
    status, _, err = publish(run, tmp_path / "root", "--post-hook", fail, "--result", result)
    assert status == 7
    assert "v001 is published, but the post-hook failed: no database" in err
    told = json.loads(result.read_text())
    assert (told["status"], told["version"]) == ("published", "v001")
    assert told["error"].endswith("no database")
    assert Path(told["entry"]).is_file()


def test_a_post_hook_that_was_missed_is_told_by_the_next_run(run, tmp_path):
    keep = f"open({str(tmp_path / 'told')!r}, 'a').write(message['publication']['status'] + ' ')"
    publish(run, tmp_path / "root")
    publish(run, tmp_path / "root", "--post-hook", hook(tmp_path, "keep", keep))
    publish(run, tmp_path / "root", "--post-hook", hook(tmp_path, "keep", keep), "--dry-run")
    assert (tmp_path / "told").read_text() == "unchanged "


@pytest.mark.parametrize("option", ["--pre-hook", "--post-hook"])
def test_a_hook_that_is_no_command_is_a_usage_error(run, tmp_path, option):
    status, _, err = publish(run, tmp_path / "root", option, "'open")
    assert (status, err.count("\n")) == (2, 1)
    assert option in err


# --- Ended from outside ---------------------------------------------------------------------------


def test_a_farm_that_cancels_leaves_nothing_behind(tmp_path):
    started = tmp_path / "started"
    code = f"open({str(started)!r}, 'w'); import time; time.sleep(60)"
    process = subprocess.Popen(
        [sys.executable, "-m", "weaveusd", "publish", str(TWILL), "--preset", "linen",
         "--root", str(tmp_path / "root"), "--resolution", "32",
         "--result", str(tmp_path / "result.json"), "--pre-hook", hook(tmp_path, "wait", code)],
        stderr=subprocess.PIPE,
    )  # fmt: skip
    while not started.exists():
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=30)
    assert process.returncode == 128 + signal.SIGTERM
    told = json.loads((tmp_path / "result.json").read_text())
    assert (told["status"], told["error"]) == ("failed", "ended from outside")
    assert not (tmp_path / "root").exists()


def test_a_cancel_that_compiled_code_loses_is_heard_at_the_next_step():
    with ended_by_sigterm() as go_on:
        go_on()
        with pytest.raises(SystemExit):
            os.kill(os.getpid(), signal.SIGTERM)
        with pytest.raises(SystemExit) as stop:
            go_on()
    assert stop.value.code == 128 + signal.SIGTERM


# --- What a draft says of a person ----------------------------------------------------------------

PERSONAL = b"""
Author=Ada Example
Address=1 Loom Lane
EMail=ada@example.org
Telephone=+1 555 0100
FAX=+1 555 0199
"""


def test_personal_fields_stay_out_of_the_asset_unless_they_are_asked_for(run, tmp_path):
    draft = tmp_path / "own.wif"
    data = TWILL.read_bytes()
    assert b"[TEXT]" in data
    draft.write_bytes(
        data.replace(b"[TEXT]", b"[TEXT]" + PERSONAL).replace(
            b"[WIF]", b"[WIF]\nDevelopers=dev@example.org"
        )
    )
    publish(run, tmp_path / "root", draft=draft)
    for file, content in tree(tmp_path / "root").items():
        for said in (b"Ada", b"Loom Lane", b"example.org", b"555 01"):
            assert said not in content, file
    status, out, _ = publish(run, tmp_path / "root", "--keep-personal", "--json", draft=draft)
    assert (status, json.loads(out)["version"]) == (0, "v002")
    kept = tree(tmp_path / "root/own_linen/v002")
    for line in PERSONAL.split(b"\n"):
        assert line in kept["draft.wif"]
    assert not [f for f, c in kept.items() if b"@example.org" in c and f != "draft.wif"]
    assert b"dev@example.org" not in kept["draft.wif"]


# --- Another folder -------------------------------------------------------------------------------


def test_the_same_inputs_in_another_folder_give_the_same_tree(run, tmp_path, monkeypatch):
    """Draft, recipe and asset are copied; working directory, number of jobs and paths differ."""
    recipe = (ROOT / "weaveusd" / "yarn" / "presets" / "linen.toml").read_text()
    here, there = tmp_path / "here", tmp_path / "not here" / "but there"
    for folder in (here, there):
        folder.mkdir(parents=True)
        (folder / "own.wif").write_bytes(TWILL.read_bytes())
        (folder / "own.toml").write_text(recipe)
    options = ("--resolution", 48, "--seed", 5, "--recipe")
    monkeypatch.chdir(here)
    run("publish", here / "own.wif", "--root", here / "root", "--jobs", 1, *options,
        here / "own.toml")  # fmt: skip
    monkeypatch.chdir(there)
    run("publish", "own.wif", "--root", "root", "--jobs", 3, *options, "own.toml")
    assert tree(there / "root") == tree(here / "root")
    assert len(tree(here / "root")) > 10

    shutil.copytree(here / "root", tmp_path / "copy")
    status, out, _ = run("publish", "own.wif", "--root", tmp_path / "copy", *options, "own.toml",
                         "--json")  # fmt: skip
    assert (status, json.loads(out)["status"]) == (0, "unchanged")
    assert tree(tmp_path / "copy") == tree(here / "root")
