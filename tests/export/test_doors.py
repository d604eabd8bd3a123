"""Other doors are published with the asset, listed, checked, and the same every time."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import weaveusd
from tests.export.cloths import cloth
from weaveusd.contract import DOORS, SYSTEMS
from weaveusd.errors import InputError
from weaveusd.export.asset import write_asset
from weaveusd.export.doors import write_doors
from weaveusd.export.moments import moment_files
from weaveusd.export.tx import FILTERED
from weaveusd.validate.verify import verify

TWILL = Path(__file__).resolve().parents[2] / "examples" / "drafts" / "twill_2_2.wif"


def publish(root: Path, **settings):
    return weaveusd.publish(TWILL, root=root, preset="denim", name="d", resolution=64, **settings)


def test_every_door_is_in_the_manifest_and_none_comes_unasked(tmp_path):
    plain = publish(tmp_path / "plain")
    done = publish(tmp_path / "doors", doors=DOORS)
    listed = {record.path for record in done.asset.files}
    maps = {Path(record.path).name for record in plain.asset.files
            if Path(record.path).name.startswith(SYSTEMS)}  # fmt: skip
    assert len(maps) >= 8
    extra = listed - {record.path for record in plain.asset.files}
    assert extra == {
        "d.usdz", "d.glb", "d.u3m",
        *(f"u3m/{name}.png" for name in (
            "alpha", "roughness", "anisotropy_value", "anisotropy_rotation")),
        *(f"textures/{Path(name).stem}.tx" for name in (*FILTERED, *maps)),
    }  # fmt: skip
    manifest = json.loads((done.asset.folder / "manifest.json").read_text())
    assert {record["path"] for record in manifest["files"]} == listed
    assert all(not version.differences for version in verify(done.asset.folder).versions)


def test_the_same_doors_again_are_unchanged_with_any_number_of_jobs(tmp_path):
    first = publish(tmp_path, doors=("usdz", "gltf", "u3m", "tx"), jobs=1)
    again = publish(tmp_path, doors=("tx", "u3m", "gltf", "usdz"), jobs=3)
    assert (first.asset.status, again.asset.status) == ("published", "unchanged")
    more = publish(tmp_path, dry_run=True)
    assert (more.asset.status, more.asset.version) == ("would-publish", "v002")


def test_a_door_that_does_not_exist_is_named_before_anything_is_written(tmp_path):
    with pytest.raises(InputError, match="doors: found 'fbx', expected usdz, gltf, u3m, tx"):
        publish(tmp_path / "root", doors=("usdz", "fbx"))
    assert not (tmp_path / "root").exists()


def test_a_colorway_has_files_of_its_own_and_tx_of_what_differs(tmp_path):
    cloths = {"one": cloth(), "two": cloth(size=16)}
    write_asset(cloths["one"], tmp_path, colorways=cloths)
    write_doors(cloths["one"], tmp_path, DOORS, colorways=cloths)
    for suffix in (".usdz", ".glb", ".u3m"):
        assert (tmp_path / f"plain{suffix}").is_file()
        assert (tmp_path / f"plain.two{suffix}").is_file()
    front = json.loads((tmp_path / "plain.two.u3m").read_text())["material"]["front"]
    assert front["basecolor"]["texture"]["image"]["path"] == "textures/two/base_color.png"
    assert front["roughness"]["texture"]["image"]["path"] == "u3m/roughness.two.png"
    own = tmp_path / "textures" / "two"
    assert {p.stem for p in own.glob("*.tx")} <= {p.stem for p in own.iterdir()}
    assert {p.stem for p in own.glob("*.tx")} == {
        Path(name).stem
        for name in (*FILTERED, *moment_files(cloths["two"].weave))
        if (own / name).is_file()
    }
