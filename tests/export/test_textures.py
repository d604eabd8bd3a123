"""The texture files hold what the textures say, the right way up, whatever the bands."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from tests.export.cloths import LOBES, texels, texture_set
from weaveusd.contract import CHANNELS
from weaveusd.errors import WeaveusdError
from weaveusd.export import textures
from weaveusd.export.encode import encode
from weaveusd.export.images import read_image
from weaveusd.export.textures import write_textures

FILES = sorted(name for channel in CHANNELS.values() for name in channel.files)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("textures")
    write_textures(texture_set(), path, LOBES)
    return path


def expected(channel: str) -> np.ndarray:
    """Return the channel as a picture: the row of the highest y on top."""
    return texture_set().whole()[channel][::-1]


def srgb_encode(linear: np.ndarray) -> np.ndarray:
    linear = linear.astype(np.float64)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def test_there_is_a_file_for_every_name_of_the_contract_and_no_other(folder):
    assert sorted(p.name for p in folder.iterdir()) == FILES


@pytest.mark.parametrize("channel", ["base_color", "normal", "tangent", "height", "fibre_angle"])
def test_exr_files_hold_the_values_signed_and_linear_to_half_precision(folder, channel):
    image = read_image(folder / f"{channel}.exr")
    np.testing.assert_array_equal(image, expected(channel).astype(np.float16))


@pytest.mark.parametrize("channel", ["normal", "tangent"])
def test_vector_pngs_hold_16_bits_and_an_exact_zero(folder, channel):
    stored = np.rint(read_image(folder / f"{channel}.png") * 65535)
    decoded = (stored / 65534 - 0.5) * 2
    assert np.abs(decoded - expected(channel)).max() <= 0.51 / 32767
    zero = expected("normal")[..., 1] == 0
    assert zero.all()
    if channel == "normal":
        assert (stored[..., 1] == 32767).all()


def test_the_color_png_follows_the_srgb_curve_to_half_a_step(folder):
    image = read_image(folder / "base_color.png")
    assert image.dtype == np.uint8
    error = np.abs(image / 255 - srgb_encode(expected("base_color")))
    assert error.max() <= 0.5001 / 255


def test_every_srgb_code_decodes_and_encodes_to_itself():
    codes = np.arange(256) / 255
    linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    got = encode(CHANNELS["base_color"], ".png", linear.astype(np.float32))
    np.testing.assert_array_equal(got, np.arange(256))
    wild = encode(CHANNELS["base_color"], ".png", np.array([-1, 2], np.float32))
    np.testing.assert_array_equal(wild, [0, 255])


def test_opacity_and_yarn_ids_hold_8_bits_with_gaps_at_zero(folder):
    opacity, ids = read_image(folder / "opacity.png"), read_image(folder / "yarn_id.png")
    np.testing.assert_array_equal(opacity, expected("opacity") * 255)
    np.testing.assert_array_equal(ids, expected("yarn_id") + 1)
    assert set(np.unique(ids)) == {0, 1, 2}


def test_roughness_is_that_of_the_yarn_and_full_where_hairs_are_loose(folder):
    image = read_image(folder / "roughness.png")[..., 0] / 255
    yarn = expected("yarn_id")[..., 0].astype(int)
    solid = expected("opacity")[..., 0] == 1
    np.testing.assert_allclose(image[solid], LOBES.roughness[yarn][solid], atol=0.51 / 255)
    assert set(image[~solid]) == {1.0}


def test_the_rotation_is_twice_the_angle_across_the_fibre_as_long_as_the_lobe_is_stretched(folder):
    x, y, zero = np.moveaxis(read_image(folder / "rotation.png") / 255 * 2 - 1, -1, 0)
    solid = expected("opacity")[..., 0] == 1
    yarn = expected("yarn_id")[..., 0].astype(int)
    normal, fibre = expected("normal"), expected("tangent")
    plane_x = np.array([1.0, 0.0, 0.0]) - normal * normal[..., :1]
    plane_x /= np.linalg.norm(plane_x, axis=-1, keepdims=True)
    across, plane_y = np.cross(normal, fibre), np.cross(normal, plane_x)
    angle = np.arctan2((across * plane_y).sum(-1), (across * plane_x).sum(-1))
    for found, wanted in ((x, np.cos(2 * angle)), (y, np.sin(2 * angle))):
        wanted = wanted * LOBES.stretch[yarn]
        np.testing.assert_allclose(found[solid], wanted[solid], atol=0.008)
        np.testing.assert_allclose(found[~solid], 0, atol=0.005)
    np.testing.assert_allclose(zero, 0, atol=0.005)


def test_the_top_row_of_every_file_has_the_highest_y(folder):
    ids = read_image(folder / "yarn_id.png")[..., 0]
    assert ids[0].max() == 2
    assert ids[-1].max() == 1
    height = read_image(folder / "height.exr")[..., 0]
    assert (height[0] < height[-1]).all()


@pytest.mark.parametrize("texels_in_a_band", [1, 32 * 5, 32 * 48, 10**9])
def test_bands_of_any_height_give_the_same_bytes(folder, tmp_path, monkeypatch, texels_in_a_band):
    monkeypatch.setattr(textures, "BAND_TEXELS", texels_in_a_band)
    write_textures(texture_set(), tmp_path, LOBES)
    for name in FILES:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_any_number_of_jobs_gives_the_same_bytes(folder, tmp_path, monkeypatch, jobs):
    monkeypatch.setattr(textures, "BAND_TEXELS", 32 * 5)
    write_textures(texture_set(), tmp_path, LOBES, jobs=jobs)
    for name in FILES:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name


def test_a_file_that_cannot_be_written_stops_the_others(tmp_path, monkeypatch):
    def refuse(self, rows):
        raise WeaveusdError("the disk is full")

    monkeypatch.setattr(textures.ImageWriter, "write", refuse)
    with pytest.raises(WeaveusdError, match="the disk is full"):
        write_textures(texture_set(), tmp_path, LOBES, jobs=2)


def test_each_row_is_computed_once_from_the_top_down(tmp_path, monkeypatch):
    monkeypatch.setattr(textures, "BAND_TEXELS", 32 * 10)
    asked: list[tuple[int, int]] = []

    def band(first, last):
        asked.append((first, last))
        return texels(first, last, 32, 48)

    shares: list[float] = []
    write_textures(replace(texture_set(), band=band), tmp_path, LOBES, progress=shares.append)
    assert asked == [(38, 48), (28, 38), (18, 28), (8, 18), (0, 8)]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_the_mean_opacity_comes_back(tmp_path):
    mean = write_textures(texture_set(), tmp_path, LOBES)
    assert mean == pytest.approx(float(texture_set().whole()["opacity"].mean()), abs=1e-7)


@pytest.mark.parametrize("name", FILES)
def test_files_say_what_their_numbers_mean(folder, name):
    source = oiio.ImageInput.open(str(folder / name))
    spec = source.spec()
    assert spec.get_float_attribute("XResolution") == pytest.approx(32 / 0.8 * 25.4, rel=1e-3)
    assert spec.get_float_attribute("YResolution") == pytest.approx(48 / 1.0 * 25.4, rel=1e-3)
    if name.endswith(".exr"):
        assert spec.format == oiio.HALF
        assert spec.get_string_attribute("compression") == "zip"
        assert spec.get_string_attribute("wrapmodes") == "periodic,periodic"
        space = spec.get_string_attribute("oiio:ColorSpace")
        assert space.startswith("lin_rec709" if name == "base_color.exr" else "data")
    else:
        tagged = b"sRGB" in (folder / name).read_bytes()[:200]
        assert tagged == (name == "base_color.png")


@pytest.mark.parametrize(
    ("channel", "value", "message"),
    [
        ("normal", None, "lacks channel normal"),
        ("normal", np.zeros((1, 1, 3), np.float32), "has shape"),
        ("height", np.full((48, 32, 1), np.nan, np.float32), "not finite"),
        ("yarn_id", np.full((48, 32, 1), 255, np.float32), "leaves the 2 yarns"),
        ("yarn_id", np.full((48, 32, 1), -2, np.float32), "leaves the 2 yarns"),
    ],
)
def test_a_broken_band_is_a_slip(tmp_path, channel, value, message):
    def band(first, last):
        rows = dict(texels(first, last, 32, 48))
        if value is None:
            del rows[channel]
        else:
            rows[channel] = value
        return rows

    with pytest.raises(ValueError, match=message):
        write_textures(replace(texture_set(), band=band), tmp_path, LOBES)
