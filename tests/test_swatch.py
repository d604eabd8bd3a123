"""Swatches show the cloth of a recipe in pixels, and pixels as text."""

from __future__ import annotations

import re
import subprocess
import sys
import time

import numpy as np
import pytest

from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.swatch import MAX_PIXELS, swatch, swatch_text
from weaveusd.yarn.recipe import preset_names, read_preset

CELL = re.compile(r"\x1b\[38;2;(\d+);(\d+);(\d+)(?:;48;2;(\d+);(\d+);(\d+))?m▀")


def linear(picture):
    display = picture / 255
    return np.where(display > 0.04045, ((display + 0.055) / 1.055) ** 2.4, display / 12.92)


@pytest.mark.parametrize("name", preset_names())
def test_a_swatch_is_as_bright_and_as_colored_as_its_yarns(name):
    recipe = read_preset(name)
    picture = swatch(recipe, width=36, height=20)
    assert (picture.shape, picture.dtype) == ((20, 36, 3), np.uint8)
    assert np.array_equal(picture, swatch(recipe, width=36, height=20))
    assert picture.std() > 4  # threads are seen
    cloth = weave(make_draft(recipe.weave or "plain"), recipe)
    colors = np.array([yarn.color for yarn in cloth.yarns])
    mean = linear(picture).mean((0, 1))
    low, high = np.minimum(colors.min(0), 0.18), np.maximum(colors.max(0), 0.18)
    assert (mean > 0.8 * low).all()
    assert (mean < 1.1 * high + 0.02).all()


def test_a_swatch_shows_the_weave_with_the_first_pick_below():
    """Denim's twill runs up to the right; its weft is light and shows at every fourth end."""
    size = 96
    light = swatch(read_preset("denim"), width=size, height=size)[::-1].mean(-1) > 140
    end = size // 12
    pick = round(end * 72 / 56)
    up = np.mean(light[pick:, end:] & light[:-pick, :-end])
    down = np.mean(light[:-pick, end:] & light[pick:, :-end])
    assert up > 2 * down


def test_gaps_of_an_open_cloth_show_the_table():
    chiffon = swatch(read_preset("chiffon"), width=120, height=120).reshape(-1, 3).astype(int)
    table = np.abs(chiffon - 118).max(axis=1) < 3
    assert 0.25 < table.mean() < 0.6


def test_all_presets_are_drawn_within_a_second_of_each_other():
    swatch(read_preset("wool"), width=24, height=12)  # the kernels are compiled or loaded
    begin = time.perf_counter()
    for name in preset_names():
        swatch(read_preset(name), width=24, height=12)
    assert time.perf_counter() - begin < 5  # under one on an idle machine


@pytest.mark.parametrize("size", [(0, 4), (4, 0), (MAX_PIXELS + 1, 4), (4, MAX_PIXELS + 1)])
def test_a_swatch_of_no_or_too_many_pixels_is_refused(size):
    with pytest.raises(ValueError, match="expected 1 to"):
        swatch(read_preset("denim"), width=size[0], height=size[1])


@pytest.mark.parametrize("size", [(1, 1), (1, 64), (64, 1)])
def test_a_swatch_may_be_of_any_proportions(size):
    assert swatch(read_preset("herringbone"), width=size[0], height=size[1]).shape[:2] == size[::-1]


@pytest.mark.parametrize("rows", [4, 5])
def test_text_holds_every_pixel_of_the_picture(rows):
    picture = np.arange(rows * 6 * 3).reshape(rows, 6, 3).astype(np.uint8)
    lines = swatch_text(picture).split("\n")
    assert len(lines) == (rows + 1) // 2
    for k, line in enumerate(lines):
        assert line.endswith("\x1b[0m")
        cells = CELL.findall(line)
        assert CELL.sub("", line) == "\x1b[0m"
        upper = [[int(v) for v in cell[:3]] for cell in cells]
        np.testing.assert_array_equal(upper, picture[2 * k])
        if 2 * k + 1 < rows:
            np.testing.assert_array_equal([[int(v) for v in c[3:]] for c in cells],
                                          picture[2 * k + 1])  # fmt: skip
        else:
            assert all(cell[3:] == ("", "", "") for cell in cells)


@pytest.mark.parametrize("picture", [np.zeros((2, 2)), np.zeros((2, 2, 3))])
def test_only_pictures_become_text(picture):
    with pytest.raises(ValueError, match="expected uint8"):
        swatch_text(picture)


def test_a_swatch_needs_no_renderer_and_no_usd():
    code = (
        "import sys; from weaveusd.swatch import swatch; from weaveusd.yarn.recipe import *;"
        "swatch(read_preset('denim'), width=8, height=8);"
        "sys.exit(any(m in sys.modules for m in ('pxr', 'mitsuba', 'OpenImageIO', 'colour')))"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
