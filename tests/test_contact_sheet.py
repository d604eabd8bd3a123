"""The contact sheet shows what an asset holds; the page of fabrics shows every one."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from weaveusd.contract import CHANNELS
from weaveusd.yarn.recipe import preset_names, read_preset

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "fabrics.md"
FABRICS = [name for name in preset_names() if read_preset(name).kind == "fabric"]


@pytest.fixture(scope="module")
def sheet():
    return runpy.run_path(str(ROOT / "examples" / "contact_sheet.py"))


def test_a_sheet_holds_a_render_and_a_tile_of_every_channel(sheet, tmp_path, monkeypatch, renderer):
    monkeypatch.setitem(sheet["card"].__globals__, "SPP", 1)
    path = tmp_path / "sheet.png"
    sheet["main"](path, ["oxford"])
    picture = oiio.ImageBuf(str(path)).get_pixels(oiio.UINT8)
    x, y = sheet["MARGIN"], sheet["MARGIN"] + sheet["TITLE"]
    render = picture[y : y + sheet["RENDER"], x : x + sheet["RENDER"]]
    assert render.std() > 10
    corners = list(sheet["places"]())
    assert len(corners) > len(CHANNELS)
    side = sheet["TILE"]
    for name, (left, top) in zip(CHANNELS, corners, strict=False):
        tile = picture[y + top : y + top + side, x + left : x + left + side]
        assert tile.std() > 2, name
    blue, white = (np.array(yarn.color) for yarn in read_preset("oxford").yarns)
    left, top = corners[0]
    color = picture[y + top : y + top + side, x + left : x + left + side] / 255
    for wanted in (blue, white):
        assert np.abs(color - wanted).max(-1).min() < 0.05


def test_labels_and_heights_become_colors_that_can_be_told_apart(sheet):
    ids = np.arange(12, dtype=np.float32).reshape(3, 4, 1) / 255
    colors = sheet["as_color"]("yarn_id", ids).reshape(-1, 3)
    assert (colors[0] == 0).all()
    apart = np.abs(colors[:, None] - colors).sum(-1) + np.eye(12)
    assert apart.min() > 0.1
    height = sheet["as_color"]("height", np.array([[[-0.4], [0.0]]], np.float32))
    np.testing.assert_allclose(height[0, :, 0], [0, 1], atol=1e-6)


def test_the_page_of_fabrics_shows_pictures_that_exist():
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", PAGE.read_text(encoding="utf-8"))
    assert {f"figures/fabrics_{name}.png" for name in FABRICS} < set(pictures)
    for picture in pictures:
        assert (PAGE.parent / picture).stat().st_size < 2.5e6


@pytest.mark.parametrize("name", FABRICS)
def test_the_swatch_on_the_page_is_the_preset_s(name):
    table = runpy.run_path(str(ROOT / "scripts" / "fabric_table.py"))
    assert table["is_drawn"](read_preset(name))
