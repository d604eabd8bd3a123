"""Readers that are not ours open the other doors of published assets."""

from __future__ import annotations

import json

import pytest

from tests.export import u3m_schema
from tests.web.tools import browser, run_node


def test_khronos_finds_no_error_in_any_gltf(asset):
    files = sorted(asset.parent.glob("*.glb"))
    assert files
    for path, report in zip(files, run_node("gltf.mjs", *files), strict=True):
        assert (report["numErrors"], report["numWarnings"]) == (0, 0), (path, report["messages"])


def test_every_u3m_is_valid(asset):
    files = sorted(asset.parent.glob("*.u3m"))
    assert files
    for path in files:
        assert list(u3m_schema.faults(json.loads(path.read_text()), path.parent)) == []


@pytest.mark.slow
def test_three_js_opens_a_usdz_with_its_textures(asset):
    for path in sorted(asset.parent.glob("*.usdz")):
        shown = run_node("page.mjs", browser(), "panel.mjs", path)["result"]
        assert shown["meshes"] == 1
        for name, srgb in (("map", True), ("normalMap", False)):
            texture = shown["maps"][name]
            assert max(texture["width"], texture["height"]) == 120, name
            assert texture["wrap"], name
            assert texture["srgb"] == srgb, name
        repeats = [texture["repeat"][axis] * shown["size"][axis] for axis in (0, 1)]
        assert repeats == pytest.approx([round(count) for count in repeats], abs=1e-3)


@pytest.mark.slow
def test_three_js_opens_a_gltf_with_its_textures(asset):
    for path in sorted(asset.parent.glob("*.glb")):
        shown = run_node("page.mjs", browser(), "panel.mjs", path)["result"]
        for name in ("map", "normalMap", "roughnessMap", "aoMap", "anisotropyMap"):
            assert shown["maps"][name]["width"] > 0, name
