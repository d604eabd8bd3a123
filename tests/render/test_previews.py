"""Preview pictures lie in the asset, named by its entry layer, and the scale is true."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from pxr import UsdMedia

import weaveusd
from weaveusd import pipeline
from weaveusd.errors import InputError
from weaveusd.render import previews
from weaveusd.stage import open_stage
from weaveusd.validate.run import validate

DRAFTS = Path(__file__).resolve().parents[2] / "examples" / "drafts"


pytestmark = pytest.mark.usefixtures("renderer")


@pytest.fixture
def small(monkeypatch):
    """Pictures of a few pixels, the one to scale with four for a millimetre."""
    monkeypatch.setattr(previews, "PIXELS_PER_MM", 4)
    for name, picture in previews._PICTURES.items():
        width = round(previews.FIELD_MM[0] * 4) if picture.to_scale else 16
        monkeypatch.setitem(previews._PICTURES, name, replace(picture, width=width, spp=2))


def published(root, **settings):
    return weaveusd.publish(
        DRAFTS / "plain.wif", preset="linen", root=root, resolution=64, name="cloth", **settings
    )


def test_the_pictures_are_in_the_asset_and_the_entry_names_them(tmp_path, small):
    done = published(tmp_path, previews=True)
    files = {record.path for record in done.asset.files if record.path.startswith("previews/")}
    assert files == {f"previews/{name}.png" for name in previews.PREVIEWS}
    stage = open_stage(done.asset.entry)
    root = stage.GetDefaultPrim()
    thumbnails = UsdMedia.AssetPreviewsAPI(root).GetDefaultThumbnails()
    assert thumbnails.defaultImage.path == "./previews/draped.png"
    others = root.GetAssetInfoByKey("previews")["thumbnails"]
    assert others["scale"]["defaultImage"].path == "./previews/scale.png"
    assert "(previews/draped.png)" in (done.asset.folder / "README.md").read_text()
    assert done.findings == []
    (done.asset.folder / "previews" / "swatch.png").unlink()
    assert not validate(done.asset.entry).passed

    picture = OpenImageIO.ImageBuf(str(done.asset.folder / "previews" / "scale.png"))
    spec = picture.spec()
    assert (spec.width, spec.height) == tuple(round(4 * side) for side in previews.FIELD_MM)
    density = spec.get_float_attribute("XResolution")
    unit = {"cm": 10.0, "in": 25.4, "inch": 25.4}[spec.get_string_attribute("ResolutionUnit")]
    assert density / unit == pytest.approx(4, rel=0.01)
    # The swatch has a side of 50 mm, its pinked edges between 45 and 50; it is brighter than
    # what it lies on.
    light = picture.get_pixels(OpenImageIO.FLOAT).mean(-1)[60:240]
    columns = np.flatnonzero(light.mean(0) > 1.6 * np.median(light[:, :16]))
    assert columns.size / 4 == pytest.approx(49, abs=2.5)


def test_every_colorway_has_a_picture_that_its_variant_shows(tmp_path, small):
    done = published(tmp_path, previews=True, colorways={"dark": "denim"}, doors=["usdz"])
    files = {record.path for record in done.asset.files if record.path.startswith("previews/")}
    assert files == {f"previews/{name}.png" for name in (*previews.PREVIEWS, "draped.dark")}
    stage = open_stage(done.asset.entry)
    root = stage.GetDefaultPrim()
    light = [
        OpenImageIO.ImageBuf(str(done.asset.folder / "previews" / f"draped{name}.png"))
        for name in ("", ".dark")
    ]
    assert np.abs(np.subtract(*(p.get_pixels(OpenImageIO.FLOAT) for p in light))).max() > 0.05
    for colorway, file in {"linen": "draped", "dark": "draped.dark"}.items():
        root.GetVariantSet("colorway").SetVariantSelection(colorway)
        thumbnails = UsdMedia.AssetPreviewsAPI(root).GetDefaultThumbnails()
        assert thumbnails.defaultImage.path == f"./previews/{file}.png"
    assert "[`dark`](previews/draped.dark.png)" in (done.asset.folder / "README.md").read_text()
    assert done.findings == []


def test_only_so_many_colorways_have_a_picture():
    assert previews.pictures_of() == {"": ("draped.png", "swatch.png", "scale.png")}
    names = [f"c{i}" for i in range(40)]
    found = previews.pictures_of(names)
    assert list(found) == names[: previews.MAX_PREVIEWED]
    assert found["c0"] == previews.pictures_of()[""]
    assert found["c9"] == ("draped.c9.png",)


def test_a_scene_wears_the_colorway_that_is_named(tmp_path):
    done = published(tmp_path, colorways={"dark": "denim"})
    seen = [
        pipeline.render(
            done.asset.entry, tmp_path / f"{name}.png", scene="swatch", colorway=name,
            width=16, spp=4,
        ).image
        for name in (None, "linen", "dark")
    ]  # fmt: skip
    np.testing.assert_array_equal(seen[0], seen[1])
    assert np.abs(seen[2] - seen[0]).max() > 0.05
    with pytest.raises(InputError, match="no colorway 'blue', expected one of dark, linen"):
        pipeline.render(
            done.asset.entry, tmp_path / "x.png", scene="swatch", colorway="blue", width=8
        )
    with pytest.raises(InputError, match="expected a scene"):
        pipeline.render(done.asset.entry, tmp_path / "x.png", colorway="dark")
