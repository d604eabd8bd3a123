"""The plugins for pyblish, run by pyblish."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

import weaveusd
from weaveusd.validate.verify import verify

# pyblish's copy of six leaves a finder behind of which Python warns at every later import.
_FINDERS = list(sys.meta_path)
api = pytest.importorskip("pyblish.api", reason="pyblish-base is not installed")
util = pytest.importorskip("pyblish.util")
plugins = pytest.importorskip("weaveusd.integrations.pyblish")
sys.meta_path[:] = _FINDERS

DRAFTS = Path(__file__).parents[2] / "examples" / "drafts"


@pytest.fixture
def publish(tmp_path, monkeypatch):
    """Publish through pyblish: give the requests, get the context."""
    (tmp_path / "system").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "system"))
    api.deregister_all_paths()
    api.deregister_all_plugins()
    plugins.register()
    plugins.register()

    def publish(*requests: dict[str, object]) -> object:
        context = api.Context()
        context.data["weaveusd"] = list(requests)
        return util.publish(context)

    yield publish
    plugins.deregister()
    assert api.registered_plugins() == []
    assert os.listdir(tmp_path / "system") == []


def request(tmp_path: Path, draft: str = "plain", **settings: object) -> dict[str, object]:
    return {"draft": DRAFTS / f"{draft}.wif", "preset": "linen", "root": tmp_path / "root",
            "resolution": 32, **settings}  # fmt: skip


def errors(context) -> list[tuple[str, str]]:
    return [
        (result["plugin"].__name__, str(result["error"]))
        for result in context.data["results"]
        if result["error"] is not None
    ]


def test_cloths_are_published_as_weaveusd_publishes_them(publish, tmp_path):
    context = publish(request(tmp_path), request(tmp_path, "satin_5", seed=2))
    assert errors(context) == []
    ran = [result["plugin"].__name__ for result in context.data["results"]]
    assert list(dict.fromkeys(ran)) == [plugin.__name__ for plugin in plugins.PLUGINS]
    told = [instance.data["publication"] for instance in context]
    assert [t["asset"] for t in told] == ["plain_linen", "satin_5_linen"]
    for done in told:
        assert (done["status"], done["version"]) == ("published", "v001")
        assert Path(done["entry"]).is_relative_to(tmp_path / "root")
        assert verify(done["entry"]).intact
    direct = weaveusd.publish(DRAFTS / "plain.wif", preset="linen", root=tmp_path / "other",
                              resolution=32).asset  # fmt: skip
    for name in ("manifest.json", "look.usda"):
        assert (direct.folder / name).read_bytes() == Path(told[0]["folder"], name).read_bytes()


def test_the_same_cloth_is_unchanged(publish, tmp_path):
    publish(request(tmp_path))
    (instance,) = publish(request(tmp_path))
    assert instance.data["publication"]["status"] == "unchanged"
    assert os.listdir(tmp_path / "root" / "plain_linen") == ["v001"]


def test_a_broken_draft_is_an_error_of_validation_and_nothing_is_written(publish, tmp_path):
    broken = tmp_path / "broken.wif"
    broken.write_text("[WIF]\n")
    context = publish(request(tmp_path, draft=broken), request(tmp_path))
    ((plugin, message),) = errors(context)
    assert plugin == "ValidateWeaveCloth"
    assert "broken.wif" in message
    assert not (tmp_path / "root").exists()


def test_what_fails_its_checks_is_an_error_of_extraction_and_nothing_is_written(
    publish, tmp_path, monkeypatch
):
    from weaveusd.export.asset import write_asset

    def spoiled(material, folder, **settings):
        entry = write_asset(material, folder, **settings)
        (folder / "textures" / "normal.exr").unlink()
        return entry

    monkeypatch.setattr("weaveusd.export.asset.write_asset", spoiled)
    ((plugin, message),) = errors(publish(request(tmp_path)))
    assert plugin == "ExtractWeaveCloth"
    assert "nothing published" in message
    assert not (tmp_path / "root").exists()


def test_a_version_that_is_taken_is_an_error_of_integration(publish, tmp_path):
    publish(request(tmp_path))
    context = publish(request(tmp_path, seed=1, version="v001"))
    ((plugin, message),) = errors(context)
    assert plugin == "IntegrateWeaveCloth"
    assert "v001: exists with other content" in message


@pytest.mark.parametrize("wrong", [3, {"draft": "x"}, {"draft": "x", "root": "y", "dry_run": True}])
def test_a_request_of_another_form_is_an_error_of_collection(publish, wrong):
    ((plugin, message),) = errors(publish(wrong))
    assert plugin == "CollectWeaveCloths"
    assert message.startswith("context.data['weaveusd'][0]: ")
