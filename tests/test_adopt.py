"""A finished version is published below another root with the same bytes, or not at all."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from weaveusd import pipeline
from weaveusd.errors import InputError, VersionConflictError
from weaveusd.export.publish import publish_asset


def write(folder: Path) -> None:
    (folder / "textures").mkdir()
    (folder / "textures" / "a.bin").write_bytes(b"one")
    (folder / "twill.usda").write_text("#usda 1.0\n")


@pytest.fixture
def version(tmp_path: Path) -> Path:
    return publish_asset(tmp_path / "farm", "twill", write, losses=[{"network": "x"}]).folder


def tree(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_an_adopted_version_has_the_same_bytes_its_manifest_too(version, tmp_path):
    done = pipeline.adopt(version, root=tmp_path / "root")
    assert (done.status, done.version, done.asset) == ("published", "v001", "twill")
    assert tree(done.folder) == tree(version)
    assert pipeline.adopt(version, root=tmp_path / "root").status == "unchanged"


def test_a_version_that_is_taken_stays(version, tmp_path):
    def other(folder: Path) -> None:
        write(folder)
        (folder / "more").touch()

    held = publish_asset(tmp_path / "root", "twill", other).folder
    before = tree(held)
    with pytest.raises(VersionConflictError):
        pipeline.adopt(version, root=tmp_path / "root", version="v001")
    assert pipeline.adopt(version, root=tmp_path / "root").version == "v002"
    assert tree(held) == before


def test_what_is_not_as_published_is_not_adopted(version, tmp_path):
    (version / "textures" / "a.bin").write_bytes(b"two")
    with pytest.raises(InputError, match=r"v001: textures/a\.bin has SHA-256"):
        pipeline.adopt(version, root=tmp_path / "root")
    assert not (tmp_path / "root").exists()


@pytest.mark.parametrize("asset", ["../x", "a b", 3, None, "CON"])
def test_a_manifest_that_names_a_path_is_refused(version, tmp_path, asset):
    from weaveusd.export import manifest

    manifest.write_manifest(version, asset, manifest.list_files(version))
    with pytest.raises(InputError, match="expected a name that is published"):
        pipeline.adopt(version, root=tmp_path / "root")
    assert sorted(os.listdir(tmp_path)) == ["farm"]


def test_only_one_version_is_adopted_at_a_time(version, tmp_path):
    publish_asset(tmp_path / "farm", "twill", write, version="v002")
    with pytest.raises(InputError, match="2 versions, expected the folder of one"):
        pipeline.adopt(version.parent, root=tmp_path / "root")
    assert json.loads((version / "manifest.json").read_text())["asset"] == "twill"
