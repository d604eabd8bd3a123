"""The gallery shows every scene."""

from __future__ import annotations

import runpy
from pathlib import Path

import OpenImageIO as oiio  # noqa: N813
import pytest

from weaveusd.render.scenes import scene_names

GALLERY = Path(__file__).parents[1] / "examples" / "gallery.py"


@pytest.fixture(scope="module")
def gallery():
    return runpy.run_path(str(GALLERY))


def test_every_scene_is_in_the_gallery(gallery):
    assert {scene for scene, _, _ in gallery["SHOTS"]} == set(scene_names())


@pytest.mark.slow
def test_the_gallery_of_a_scene_is_its_pictures(gallery, tmp_path, renderer):
    gallery["main"](tmp_path, ["swatch"], 32, 4)
    for name in ("swatch_linen_plain", "swatch_denim_detail"):
        picture = oiio.ImageBuf(str(tmp_path / f"{name}.png"))
        assert (picture.spec().width, picture.spec().height) == (32, 32)
