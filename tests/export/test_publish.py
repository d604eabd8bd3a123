"""Publishing: versions, locks, kills and refusals."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from weaveusd.errors import (
    InputError,
    VersionConflictError,
    WeaveusdError,
)
from weaveusd.export.manifest import content_digest, list_files
from weaveusd.export.publish import PublishedAsset, plan_asset, publish_asset


def writer(text: str = "one"):
    def write(folder: Path) -> None:
        (folder / "textures").mkdir()
        (folder / "textures" / "a.bin").write_text(text)
        (folder / "twill.usda").write_text("#usda 1.0\n")

    return write


def publish(root: Path, text: str = "one", **settings) -> PublishedAsset:
    return publish_asset(root, "twill", writer(text), **settings)


def names(folder: Path) -> list[str]:
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*"))


def test_the_first_version_is_v001_and_nothing_else_is_left(tmp_path):
    asset = publish(tmp_path)
    assert (asset.status, asset.version) == ("published", "v001")
    assert asset.entry == tmp_path / "twill/v001/twill.usda"
    assert asset.entry.is_file()
    assert asset.material == "/twill/Material"
    assert os.listdir(tmp_path / "twill") == ["v001"]


def test_the_same_content_is_never_published_twice(tmp_path):
    first = publish(tmp_path)
    second = publish(tmp_path)
    assert (second.status, second.version) == ("unchanged", "v001")
    assert second.files == first.files
    assert os.listdir(tmp_path / "twill") == ["v001"]


def test_other_content_gets_the_next_number(tmp_path):
    publish(tmp_path)
    assert publish(tmp_path, "two").version == "v002"
    assert publish(tmp_path, "one").version == "v003"


def test_the_next_number_follows_the_highest_whatever_holds_it(tmp_path):
    (tmp_path / "twill/v007").mkdir(parents=True)
    (tmp_path / "twill/v0012").touch()
    assert publish(tmp_path).version == "v013"
    assert publish(tmp_path, "two", version="v1234").version == "v1234"
    assert publish(tmp_path, "three").version == "v1235"


def test_a_version_asked_for_by_number_is_made_kept_or_refused(tmp_path):
    assert publish(tmp_path, version="v005").status == "published"
    assert publish(tmp_path, version="v005").status == "unchanged"
    with pytest.raises(VersionConflictError, match="v005: exists with other content"):
        publish(tmp_path, "two", version="v005")
    assert (tmp_path / "twill/v005/textures/a.bin").read_text() == "one"
    assert os.listdir(tmp_path / "twill") == ["v005"]


@pytest.mark.parametrize("version", ["", "1", "v1", "v000", "v0001", "V001", "v001/..", "v٠٠١"])
def test_a_malformed_version_is_refused_in_one_line(tmp_path, version):
    with pytest.raises(InputError, match=r"^version .*expected"):
        publish(tmp_path, version=version)
    assert os.listdir(tmp_path) == []


def test_a_damaged_version_counts_as_other_content(tmp_path):
    publish(tmp_path)
    (tmp_path / "twill/v001/textures/a.bin").write_text("two")
    assert publish(tmp_path).version == "v002"


def test_the_manifest_lists_every_file_and_its_digest(tmp_path):
    asset = publish(tmp_path)
    manifest = json.loads((asset.folder / "manifest.json").read_text())
    assert manifest["content_sha256"] == asset.content_sha256
    assert [f["path"] for f in manifest["files"]] == ["textures/a.bin", "twill.usda"]
    assert list_files(asset.folder) == asset.files
    listing = subprocess.run(
        ["sha256sum", *(f.path for f in asset.files)],
        cwd=asset.folder, capture_output=True, check=True,
    )  # fmt: skip
    summed = subprocess.run(
        ["sha256sum"], input=listing.stdout, capture_output=True, check=True
    ).stdout
    assert summed.decode().startswith(content_digest(asset.files))
    json.dumps(asset.as_dict())


def test_the_check_sees_the_complete_asset(tmp_path):
    seen = []
    publish(tmp_path, check=lambda folder: seen.extend(names(folder)))
    assert seen == ["manifest.json", "textures", "textures/a.bin", "twill.usda"]


@pytest.mark.parametrize("error", [WeaveusdError("bad"), ValueError("slip"), KeyboardInterrupt()])
def test_a_failing_check_leaves_no_trace(tmp_path, error):
    def check(folder: Path) -> None:
        raise error

    with pytest.raises(type(error)):
        publish(tmp_path / "out", check=check)
    assert os.listdir(tmp_path) == []
    publish(tmp_path)
    before = names(tmp_path)
    with pytest.raises(type(error)):
        publish(tmp_path, "two", check=check)
    assert names(tmp_path) == before


def test_a_full_disk_is_told_in_one_line_and_leaves_no_trace(tmp_path):
    def write(folder: Path) -> None:
        (folder / "half").write_text("half")
        raise OSError(28, "No space left on device", str(folder / "half"))

    with pytest.raises(WeaveusdError, match=r"half: No space left on device$"):
        publish_asset(tmp_path / "out", "twill", write)
    assert os.listdir(tmp_path) == []


def test_an_asset_without_entry_layer_is_a_slip(tmp_path):
    with pytest.raises(ValueError, match=r"twill\.usda"):
        publish_asset(tmp_path, "twill", lambda folder: None)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("name", ["../x", "a b", "", "CON", "1", "x" * 65, "ä", "a/b"])
def test_an_unsafe_name_is_a_slip(tmp_path, name):
    with pytest.raises(ValueError, match="no safe name"):
        publish_asset(tmp_path, name, writer())
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("link", ["out", "out/twill"])
def test_symbolic_links_are_never_followed(tmp_path, link):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / link).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / link).symlink_to(elsewhere)
    with pytest.raises(InputError, match="symbolic link"):
        publish(tmp_path / "out")
    assert os.listdir(elsewhere) == []


def test_a_version_that_is_a_symbolic_link_is_never_followed(tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / "twill").mkdir()
    (tmp_path / "twill/v001").symlink_to(elsewhere)
    with pytest.raises(InputError, match="symbolic link"):
        publish(tmp_path, version="v001")
    assert publish(tmp_path).version == "v002"
    assert os.listdir(elsewhere) == []


def test_a_lock_that_is_a_link_is_refused_and_what_it_names_stays(tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("mine")
    (tmp_path / "out/twill").mkdir(parents=True)
    (tmp_path / "out/twill/.publish.lock").symlink_to(precious)
    with pytest.raises(InputError, match="symbolic link, expected a lock's file"):
        publish(tmp_path / "out")
    assert precious.read_text() == "mine"


def test_a_staging_folder_that_is_a_link_is_left_alone(tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "precious").touch()
    (tmp_path / "out/twill").mkdir(parents=True)
    (tmp_path / "out/twill/.publish.tmp-evil").symlink_to(elsewhere)
    assert publish(tmp_path / "out").status == "published"
    assert os.listdir(elsewhere) == ["precious"]


def test_a_folder_that_becomes_a_link_while_the_asset_is_written_is_refused(tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()

    def write(folder: Path) -> None:
        writer()(folder)
        (tmp_path / "out/twill").rename(elsewhere / "twill")
        (tmp_path / "out/twill").symlink_to(elsewhere / "twill")

    with pytest.raises(InputError, match="symbolic link"):
        publish_asset(tmp_path / "out", "twill", write)
    assert not list(elsewhere.glob("*/v*"))


def test_a_plan_says_what_a_publish_would_do_and_touches_nothing(tmp_path):
    planned = plan_asset(tmp_path / "out", "twill", writer())
    assert (planned.status, planned.version) == ("would-publish", "v001")
    assert os.listdir(tmp_path) == []
    asset = publish(tmp_path / "out")
    assert planned.as_dict() == {**asset.as_dict(), "status": "would-publish"}
    (tmp_path / "out/twill/.publish.tmp-dead").mkdir()
    before = names(tmp_path)
    assert plan_asset(tmp_path / "out", "twill", writer()).status == "unchanged"
    assert plan_asset(tmp_path / "out", "twill", writer("two")).version == "v002"
    with pytest.raises(VersionConflictError):
        plan_asset(tmp_path / "out", "twill", writer("two"), version="v001")
    assert names(tmp_path) == before


def test_symbolic_links_in_an_asset_are_a_slip(tmp_path):
    def write(folder: Path) -> None:
        writer()(folder)
        (folder / "link").symlink_to("/etc")

    with pytest.raises(ValueError, match="link"):
        publish_asset(tmp_path, "twill", write)
    assert os.listdir(tmp_path) == []


def test_a_file_in_the_way_is_told_in_one_line(tmp_path):
    (tmp_path / "twill").touch()
    with pytest.raises(InputError, match="a file, expected a folder"):
        publish(tmp_path)


def test_published_folders_obey_the_umask(tmp_path):
    asset = publish(tmp_path)
    assert asset.folder.stat().st_mode & 0o777 == asset.folder.parent.stat().st_mode & 0o777


CHILD = """
import sys, time
from pathlib import Path
from weaveusd.export.publish import publish_asset

root, text, pause = Path(sys.argv[1]), sys.argv[2], float(sys.argv[3])

def write(folder):
    (folder / "twill.usda").write_text("#usda 1.0\\n")
    for i in range(20):
        (folder / f"{i}.bin").write_text(text * 1000)
        if i == 10:
            print("writing", flush=True)
            time.sleep(pause)

print(publish_asset(root, "twill", write).status, flush=True)
"""


def start(root: Path, text: str, pause: float = 0.0) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", CHILD, str(root), text, str(pause)],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip


def test_eight_publishers_at_once_make_one_version(tmp_path):
    outputs = [p.communicate()[0] for p in [start(tmp_path, "same", 0.2) for _ in range(8)]]
    assert sorted(o.split()[-1] for o in outputs) == ["published"] + 7 * ["unchanged"]
    assert os.listdir(tmp_path / "twill") == ["v001"]


def test_threads_with_different_content_each_get_a_version(tmp_path):
    with ThreadPoolExecutor(8) as pool:
        assets = list(pool.map(lambda i: publish(tmp_path, str(i)), range(8)))
    assert sorted(a.version for a in assets) == [f"v00{i}" for i in range(1, 9)]
    assert sorted(os.listdir(tmp_path / "twill")) == [f"v00{i}" for i in range(1, 9)]


def test_a_killed_run_publishes_nothing_and_the_next_one_cleans_up(tmp_path):
    publish(tmp_path)
    killed, alive = start(tmp_path, "killed", 60), start(tmp_path, "alive", 3)
    for process in (killed, alive):
        assert process.stdout.readline() == "writing\n"
    killed.send_signal(signal.SIGKILL)
    killed.communicate()
    assert len(list((tmp_path / "twill").glob(".publish.tmp-*"))) == 2
    assert publish(tmp_path).status == "unchanged"
    assert len(list((tmp_path / "twill").glob(".publish.tmp-*"))) == 1
    assert alive.communicate()[0].split()[-1] == "published"
    assert sorted(os.listdir(tmp_path / "twill")) == ["v001", "v002"]


@pytest.mark.slow
def test_a_kill_at_any_moment_leaves_old_versions_whole_and_no_new_one_half(tmp_path):
    for i in range(30):
        process = start(tmp_path, str(i), 0.02)
        process.stdout.readline()
        time.sleep(0.002 * i)
        process.kill()
        process.communicate()
        for folder in (tmp_path / "twill").glob("v*"):
            manifest = json.loads((folder / "manifest.json").read_text())
            assert content_digest(list_files(folder)) == manifest["content_sha256"]
    publish(tmp_path, "last")
    assert not list((tmp_path / "twill").glob(".*"))
