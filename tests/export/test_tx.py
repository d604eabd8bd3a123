"""Every level of a .tx is the mean of what it covers, and gaps do not tint it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from tests.export.cloths import cloth, plain_weave
from weaveusd.contract import CHANNELS
from weaveusd.errors import InputError, WeaveusdError
from weaveusd.export.asset import write_asset
from weaveusd.export.doors import write_doors
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.images import read_image, write_png8
from weaveusd.export.mipmap import CLEAR, Halving, smaller_levels
from weaveusd.export.moments import moment_files
from weaveusd.export.tiled import TILE
from weaveusd.export.tx import FILTERED, write_tx

MAPS = moment_files(plain_weave())


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("asset")
    write_asset(cloth(size=100), path)
    write_tx(path, CLOTH_ITSELF)
    return path


def levels(path: Path) -> list[np.ndarray]:
    opened = OpenImageIO.ImageInput.open(str(path))
    found = []
    while opened.seek_subimage(0, len(found)):
        spec = opened.spec()
        assert (spec.tile_width, spec.tile_height) == (TILE, TILE)
        pixels = opened.read_image(0, len(found), 0, spec.nchannels, OpenImageIO.FLOAT)
        found.append(np.asarray(pixels).reshape(spec.height, spec.width, spec.nchannels))
    opened.close()
    return found


def weighed_mean(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    return (values * weight).sum((0, 1)) / weight.sum()


def pyramid(values: np.ndarray, opacity: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    halving = Halving(values.shape[1], values.shape[0], values.shape[2])
    halving.add(values.astype(np.float32), opacity.astype(np.float32))
    return list(smaller_levels(halving))


def test_all_textures_that_have_a_mean_and_no_others_are_copied(folder):
    found = {path.name for path in (folder / "textures").glob("*.tx")}
    assert found == {Path(name).with_suffix(".tx").name for name in (*FILTERED, *MAPS)}
    labels = {f for c in CHANNELS.values() if c.encoding == "label" for f in c.files}
    assert not labels & set(FILTERED)


@pytest.mark.parametrize("name", FILTERED)
def test_the_first_level_is_the_texture_and_the_last_one_texel(folder, name):
    source = folder / "textures" / name
    found = levels(source.with_suffix(".tx"))
    exact = read_image(source)
    exact = exact / np.float32(255) if exact.dtype == np.uint8 else exact
    assert np.array_equal(found[0], exact.astype(np.float16).astype(np.float32))
    assert [level.shape[:2] for level in found] == [
        (150, 100), (75, 50), (37, 25), (18, 12), (9, 6), (4, 3), (2, 1), (1, 1)
    ]  # fmt: skip


@pytest.mark.parametrize("name", FILTERED)
def test_the_last_level_is_the_mean_of_what_is_opaque(folder, name):
    opacity = read_image(folder / "textures" / "opacity.png") / np.float64(255)
    assert 0 < opacity.mean() < 1
    found = levels((folder / "textures" / name).with_suffix(".tx"))
    weight = np.ones_like(opacity) if name == "opacity.png" else opacity
    np.testing.assert_allclose(
        found[-1][0, 0], weighed_mean(found[0].astype(float), weight), rtol=2e-3, atol=5e-4
    )


@pytest.mark.parametrize("name", MAPS)
def test_moment_maps_are_averaged_as_they_are_whatever_their_opacity(folder, name):
    source = folder / "textures" / name
    found = levels(source.with_suffix(".tx"))
    assert np.array_equal(found[0], read_image(source))
    assert [level.shape for level in found] == [(8, 8, 4), (4, 4, 4), (2, 2, 4), (1, 1, 4)]
    four = found[0].astype(float).reshape(4, 2, 4, 2, 4).mean((1, 3))
    np.testing.assert_allclose(found[1], four, rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(found[-1][0, 0], found[0].mean((0, 1)), rtol=1e-3, atol=1e-6)


def test_every_level_has_the_mean_of_the_one_above_on_odd_sides_too():
    rng = np.random.default_rng(1)
    values, opacity = rng.random((77, 53, 3)), rng.random((77, 53)) ** 4
    mean = weighed_mean(values, opacity[..., None])
    found = pyramid(values, opacity)
    assert [level.shape[:2] for level, _ in found] == [
        (38, 26), (19, 13), (9, 6), (4, 3), (2, 1), (1, 1)
    ]  # fmt: skip
    for level, weight in found:
        assert weight.mean() == pytest.approx(opacity.mean(), rel=1e-5)
        np.testing.assert_allclose(weighed_mean(level, weight[..., None]), mean, rtol=1e-5)


def test_a_texel_of_a_level_is_the_mean_of_four():
    rng = np.random.default_rng(2)
    values, opacity = rng.random((8, 6, 2)), np.ones((8, 6))
    (level, _), *_ = pyramid(values, opacity)
    four = values.reshape(4, 2, 3, 2, 2).mean((1, 3))
    np.testing.assert_allclose(level, four, rtol=1e-6)


def test_a_gap_tints_nothing_and_a_hole_keeps_the_color_around_it():
    values, opacity = np.full((4, 4, 1), 0.25), np.ones((4, 4))
    values[::2, ::2], opacity[::2, ::2] = 100.0, 0.0
    values[2:, 2:], opacity[2:, 2:] = 0.75, 0.0
    (level, weight), *_ = pyramid(values, opacity)
    np.testing.assert_allclose(level[..., 0], [[0.25, 0.25], [0.25, 0.75]], rtol=2e-4)
    np.testing.assert_allclose(weight, [[0.75, 0.75], [0.75, CLEAR]], rtol=1e-5)


def test_bands_of_any_height_give_the_same_levels():
    rng = np.random.default_rng(3)
    values = rng.random((45, 31, 3)).astype(np.float32)
    opacity = rng.random((45, 31)).astype(np.float32)
    whole = Halving(31, 45, 3)
    whole.add(values, opacity)
    for rows in (1, 7, 44):
        banded = Halving(31, 45, 3)
        for first in range(0, 45, rows):
            banded.add(values[first : first + rows], opacity[first : first + rows])
        for one, other in zip(whole.level(), banded.level(), strict=True):
            assert np.array_equal(one, other)


def test_where_all_is_opaque_levels_are_those_of_openimageio(tmp_path):
    rng = np.random.default_rng(4)
    values = rng.random((64, 64, 3)).astype(np.float32)
    buffer = OpenImageIO.ImageBuf(values)
    config = OpenImageIO.ImageSpec()
    config.attribute("maketx:filtername", "box")
    path = str(tmp_path / "theirs.exr")
    OpenImageIO.ImageBufAlgo.make_texture(OpenImageIO.MakeTxTexture, buffer, path, config)
    theirs = levels(Path(path))
    ours = [level for level, _ in pyramid(values, np.ones((64, 64)))]
    assert len(theirs) == len(ours) + 1
    for one, other in zip(ours, theirs[1:], strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-5)


def test_readers_are_told_that_it_is_a_periodic_texture_and_its_color_space(folder):
    for name in (*FILTERED, *MAPS):
        source = folder / "textures" / name
        opened = OpenImageIO.ImageInput.open(str(source.with_suffix(".tx")))
        spec = opened.spec()
        opened.close()
        colored = name == "base_color.exr" or name.endswith("_albedo.exr")
        space = "lin_rec709_scene" if colored else "data"
        assert spec.getattribute("wrapmodes") == "periodic,periodic"
        assert spec.getattribute("textureformat") == "Plain Texture"
        assert spec.getattribute("oiio:ColorSpace") == space
        assert spec.getattribute("DateTime") == "2000:01:01 00:00:00"
        assert spec.format == OpenImageIO.HALF


def test_openimageio_finds_the_mean_from_afar(folder):
    system = OpenImageIO.TextureSystem()
    options = OpenImageIO.TextureOpt()
    path = str(folder / "textures" / "tangent.tx")
    found = system.texture(path, options, 0.3, 0.7, 9.0, 0.0, 0.0, 9.0, 3)
    np.testing.assert_allclose(found, levels(Path(path))[-1][0, 0], atol=0.02)


def test_the_same_textures_give_the_same_bytes(folder, tmp_path):
    write_asset(cloth(size=100), tmp_path)
    write_doors(cloth(size=100), tmp_path, ["tx"])
    for name in (*FILTERED, *MAPS):
        path = Path("textures", name).with_suffix(".tx")
        assert (folder / path).read_bytes() == (tmp_path / path).read_bytes()


def test_no_layer_names_a_tx(folder):
    for path in folder.rglob("*"):
        if path.suffix in (".usda", ".mtlx"):
            assert ".tx" not in path.read_text(), path


def test_textures_of_two_sizes_are_refused(tmp_path):
    write_asset(cloth(), tmp_path)
    write_png8(tmp_path / "textures" / "opacity.png", np.zeros((4, 4, 1), np.uint8))
    with pytest.raises(InputError, match=r"opacity\.png: 4 x 4 texels, expected 32 x 48"):
        write_tx(tmp_path, CLOTH_ITSELF)


def test_a_disk_that_refuses_is_told_in_one_line(tmp_path):
    write_asset(cloth(), tmp_path)
    (tmp_path / "textures" / "base_color.tx").mkdir()
    with pytest.raises(WeaveusdError, match=r"base_color\.tx: cannot be written"):
        write_tx(tmp_path, CLOTH_ITSELF)
