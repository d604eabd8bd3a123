"""The figures: what they show, and that the same command gives the same bytes."""

from __future__ import annotations

import numpy as np
import pytest

from weaveusd.errors import WeaveusdError
from weaveusd.proof import curves
from weaveusd.proof.curves import Form
from weaveusd.proof.draw import draw
from weaveusd.proof.subjects import subjects
from weaveusd.shading import laws, microcylinder

SILK = subjects(["silk"])[0]
LINEN = subjects(["linen"])[0]


@pytest.mark.parametrize("gaussian", [False, True])
def test_surface_and_volume_make_up_what_is_rendered(gaussian):
    turn, found = curves.cut(LINEN, Form(gaussian), "along", 0.5)
    value = microcylinder.evaluate(
        curves.around("along", 0.5), curves.around("along", turn), laws.NORMAL, laws.ALONG,
        LINEN.parameters(curves.ALBEDO, gaussian=gaussian),
    )  # fmt: skip
    np.testing.assert_allclose(found.total, value[:, 0], rtol=1e-12, atol=1e-15)
    assert found.surface.min() >= 0
    assert found.volume.min() >= -1e-15


def test_the_highlight_stands_opposite_the_viewer_along_the_fibre():
    turn, found = curves.cut(SILK, Form(), "along", 0.5)
    assert turn[np.argmax(found.surface)] == pytest.approx(-0.5, abs=0.02)


def test_the_cone_is_a_band_across_the_fibre():
    """Bright where θo = -θi, whatever the azimuth; the viewer is on the left."""
    size = 201
    picture = curves.from_above(SILK, Form(), np.pi / 6, size)
    across = (np.arange(size) + 0.5) / size * 2 - 1
    assert across[np.nanargmax(picture[size // 2])] == pytest.approx(1 / 3, abs=0.03)
    # θo = 30° at azimuth 45°: from the normal cos α = cos 30° cos 45°.
    away = np.arccos(np.cos(np.pi / 6) * np.cos(np.pi / 4))
    turn = np.arctan2(np.sin(np.pi / 6), np.cos(np.pi / 6) * np.sin(np.pi / 4))
    x, y = away / (np.pi / 2) * np.sin(turn), away / (np.pi / 2) * np.cos(turn)
    row, column = int((1 - y) / 2 * size), int((x + 1) / 2 * size)
    line = picture[row]
    assert abs(int(np.nanargmax(line)) - column) <= 6
    assert np.isnan(picture[0, 0])


def test_the_same_figures_are_the_same_bytes(tmp_path):
    files = [
        draw(["linen"], tmp_path / run, formats=("png", "svg"), angles_deg=(30,))
        for run in ("first", "second")
    ]
    names = [file.name for file in files[0]]
    assert names == [f"linen_{kind}.{suffix}" for kind in ("components", "cone")
                     for suffix in ("png", "svg")]  # fmt: skip
    for one, other in zip(*files, strict=True):
        assert one.read_bytes() == other.read_bytes()
        assert b"<dc:date>" not in one.read_bytes()


def test_presets_stand_side_by_side_and_lobes_against_each_other(tmp_path):
    files = draw(
        ["linen", "polyester"],
        tmp_path,
        forms=(Form(published=True), Form(gaussian=True, published=True)),
        angles_deg=(0,),
    )
    assert [file.stem for file in files] == [
        "linen_published_components",
        "linen_published_cone",
        "linen_published_cone_gaussian",
        "polyester_published_components",
        "polyester_published_cone",
        "polyester_published_cone_gaussian",
        "side_by_side_published",
        "side_by_side_published_gaussian",
        "gaussian_against_cauchy_published",
    ]


def test_an_unknown_preset_writes_nothing(tmp_path):
    with pytest.raises(WeaveusdError, match="sackcloth"):
        draw(["linen", "sackcloth"], tmp_path / "figures")
    assert not (tmp_path / "figures").exists()


def test_a_folder_that_is_a_file_is_named(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(WeaveusdError, match=r"taken/linen_components\.png: cannot be written"):
        draw(["linen"], tmp_path / "taken", angles_deg=(0,))
