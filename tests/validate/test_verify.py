"""Verify: no bit, file or link is other than published without being told."""

from __future__ import annotations

import hashlib
import json
import os
import random
import shutil
from pathlib import Path

import pytest

from weaveusd.errors import InputError
from weaveusd.export.manifest import FileRecord, list_files, write_manifest
from weaveusd.export.publish import publish_asset
from weaveusd.validate import integrity
from weaveusd.validate.verify import verify


def write(folder: Path) -> None:
    (folder / "textures").mkdir()
    (folder / "textures" / "normal.exr").write_bytes(random.Random(1).randbytes(5000))
    (folder / "textures" / "empty").touch()
    (folder / "twill.usda").write_text("#usda 1.0\n")
    (folder / "look.usda").write_text("#usda 1.0\n# look\n")


@pytest.fixture
def version(tmp_path: Path) -> Path:
    return publish_asset(tmp_path / "root", "twill", write).folder


def found(version: Path) -> list[tuple[str, str]]:
    verification = verify(version)
    return [(d.kind, d.path) for v in verification.versions for d in v.differences]


def test_what_was_published_is_intact_and_stays_so_when_moved(version, tmp_path):
    assert verify(version).intact
    assert verify(version / "twill.usda").intact
    shutil.copytree(version, tmp_path / "elsewhere")
    assert verify(tmp_path / "elsewhere").intact


def test_every_kind_of_difference_is_listed_at_once(version):
    (version / "look.usda").unlink()
    (version / "textures" / "notes.txt").write_text("mine")
    (version / "twill.usda").write_text("#usda 1.1\n")
    (version / "textures" / "empty").write_text("full")
    assert found(version) == [
        ("missing", "look.usda"),
        ("changed", "textures/empty"),
        ("added", "textures/notes.txt"),
        ("changed", "twill.usda"),
    ]


def test_a_hundred_flipped_bits_in_any_file_are_found(version):
    files = [p for p in sorted(version.rglob("*")) if p.is_file() and p.stat().st_size]
    seed = random.Random(0)
    for _ in range(100):
        path = seed.choice(files)
        before = path.read_bytes()
        after = bytearray(before)
        after[seed.randrange(len(after))] ^= 1 << seed.randrange(8)
        path.write_bytes(after)
        assert not verify(version).intact, path
        path.write_bytes(before)
    assert verify(version).intact


def test_every_bit_of_the_manifest_counts(version):
    path = version / "manifest.json"
    before = path.read_bytes()
    for bit in range(0, 8 * len(before), 3):
        after = bytearray(before)
        after[bit // 8] ^= 1 << bit % 8
        path.write_bytes(after)
        assert found(version), f"bit {bit}"
    path.write_bytes(before)
    assert verify(version).intact


def test_links_are_findings_wherever_they_lead(version, tmp_path):
    same = tmp_path / "same.usda"
    same.write_bytes((version / "twill.usda").read_bytes())
    (version / "twill.usda").unlink()
    (version / "twill.usda").symlink_to(same)
    shutil.copytree(version / "textures", tmp_path / "textures")
    shutil.rmtree(version / "textures")
    (version / "textures").symlink_to(tmp_path / "textures")
    (version / "dangling").symlink_to(tmp_path / "gone")
    assert found(version) == [
        ("added", "dangling"),
        ("added", "textures"),
        ("missing", "textures/empty"),
        ("missing", "textures/normal.exr"),
        ("changed", "twill.usda"),
    ]


def test_pipes_and_names_that_are_no_text_are_findings_and_not_waited_for(version):
    os.mkfifo(version / "pipe")
    (version / "twill.usda").unlink()
    os.mkfifo(version / "twill.usda")
    os.close(os.open(os.fsencode(version) + b"/\xff\xfe", os.O_CREAT))
    assert found(version) == [
        ("added", "pipe"),
        ("changed", "twill.usda"),
        ("added", "\\udcff\\udcfe"),
    ]


@pytest.mark.parametrize(
    "manifest",
    [
        b"", b"[]", b"{}", b"null", b"\xff", b"[" * 100_000, b'{"files": 3}',
        b'{"files": [{"path": "a", "bytes": "x", "sha256": ""}]}',
        b'{"files": [], "content_sha256": "", "manifest_sha256": 1e999}',
    ],
)  # fmt: skip
def test_a_manifest_of_any_other_form_is_a_finding(version, manifest):
    (version / "manifest.json").write_bytes(manifest)
    assert found(version) == [("broken", "manifest.json")]


def test_a_manifest_that_is_gone_a_link_or_a_pipe_is_a_finding(version, tmp_path):
    path = version / "manifest.json"
    path.rename(tmp_path / "manifest.json")
    assert found(version) == [("missing", "manifest.json")]
    path.symlink_to(tmp_path / "manifest.json")
    assert found(version) == [("broken", "manifest.json")]
    path.unlink()
    os.mkfifo(path)
    assert found(version) == [("broken", "manifest.json")]


def test_paths_in_a_manifest_are_never_opened(version, tmp_path):
    (tmp_path / "secret").write_text("mine")
    digest = hashlib.sha256(b"mine").hexdigest()
    files = list_files(version)
    for path in ("../../../secret", str(tmp_path / "secret"), "./twill.usda", "a\nb"):
        write_manifest(version, "twill", tuple(sorted((*files, FileRecord(path, digest, 4)))))
        assert found(version) == [("missing", path.replace("\n", "\\n"))]


def test_all_versions_of_an_asset_are_looked_at_by_number(version):
    home = version.parent
    shutil.copytree(version, home / "v1000")
    shutil.copytree(version, home / "v002")
    (home / "v002" / "twill.usda").unlink()
    (home / "v003").symlink_to(version)
    verification = verify(home)
    assert [v.folder.name for v in verification.versions] == ["v001", "v002", "v003", "v1000"]
    assert [bool(v.differences) for v in verification.versions] == [False, True, True, False]


def test_what_is_no_asset_is_told_in_one_line(tmp_path, version):
    for path in (tmp_path, tmp_path / "gone", version / "textures"):
        with pytest.raises(InputError, match=r"expected a published asset$"):
            verify(path)


def test_an_asset_of_too_many_files_is_refused(version, monkeypatch):
    monkeypatch.setattr(integrity, "MAX_FILES", 5)
    with pytest.raises(InputError, match="more than 5 files"):
        verify(version)


def test_the_command_lists_what_it_found_and_answers_four(run, version):
    status, out, _ = run("verify", version, "--json")
    answer = json.loads(out)
    assert (status, answer["status"], len(answer["versions"])) == (0, "intact", 1)
    (version / "look.usda").unlink()
    status, out, _ = run("verify", version / "twill.usda", "--json")
    answer = json.loads(out)
    assert (status, answer["status"]) == (4, "damaged")
    assert answer["versions"][0]["differences"] == [
        {"kind": "missing", "path": "look.usda", "message": "is gone"}
    ]
    status, out, _ = run("verify", version.parent)
    assert status == 4
    assert "look.usda: is gone" in out
    assert run("verify", version / "nowhere")[0] == 3
