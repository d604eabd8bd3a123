"""Reading and writing images: limits, bytes, density."""

from __future__ import annotations

import resource
import signal
import struct
import time
import zlib
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from weaveusd.errors import InputError, WeaveusdError
from weaveusd.export import images
from weaveusd.export.images import ImageWriter, density, read_image, write_png8
from weaveusd.export.png import png_fault


def ramp(channels: int, height: int = 5, width: int = 7) -> np.ndarray:
    count = height * width * channels
    return (np.arange(count) * 3 % 256).astype(np.uint8).reshape(height, width, channels)


def png_header(path: Path, width: int, height: int) -> None:
    head = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    chunk = b"IHDR" + head
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk
        + struct.pack(">I", zlib.crc32(chunk)) + struct.pack(">I", 8) + b"IDAT" + b"\0" * 8
    )  # fmt: skip


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_an_8_bit_png_comes_back_as_it_was_written(tmp_path, channels):
    path = tmp_path / "x.png"
    write_png8(path, ramp(channels))
    image = read_image(path)
    assert image.dtype == np.uint8
    np.testing.assert_array_equal(image, ramp(channels))


def test_the_first_row_of_an_array_is_the_top_of_the_picture(tmp_path):
    path = tmp_path / "x.png"
    pixels = np.zeros((2, 1, 1), np.uint8)
    pixels[0] = 255
    write_png8(path, pixels)
    assert oiio.ImageBuf(str(path)).getpixel(0, 0)[0] == 1.0


@pytest.mark.parametrize(
    "pixels", [np.zeros((2, 2, 3), np.float32), np.zeros((2, 2), np.uint8), ramp(5)]
)
def test_other_arrays_are_a_slip(tmp_path, pixels):
    with pytest.raises(ValueError, match="uint8"):
        write_png8(tmp_path / "x.png", pixels)


def test_a_missing_image_is_told_in_one_line(tmp_path):
    with pytest.raises(InputError, match=r"none\.png: no such file$"):
        read_image(tmp_path / "none.png")


@pytest.mark.parametrize("content", [b"", b"no image at all", b"\x89PNG\r\n\x1a\n"])
def test_a_file_that_is_no_image_is_told_in_one_line(tmp_path, content):
    path = tmp_path / "x.png"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"x\.png: ") as caught:
        read_image(path)
    assert "\n" not in str(caught.value)


def test_an_image_cut_short_is_refused(tmp_path):
    path = tmp_path / "x.exr"
    with ImageWriter(path, 64, 64, 3, "float16", {}) as out:
        out.write(np.random.default_rng(0).random((64, 64, 3)).astype(np.float16))
    path.write_bytes(path.read_bytes()[:4000])
    with pytest.raises(InputError, match=r"x\.exr"):
        read_image(path)


def test_a_huge_image_is_refused_by_its_header(tmp_path):
    path = tmp_path / "x.png"
    png_header(path, 50_000, 50_000)
    start = time.perf_counter()
    with pytest.raises(InputError, match=r"x\.png: .*(50000 x 50000|2384 MB)"):
        read_image(path)
    assert time.perf_counter() - start < 0.5


def test_more_pixels_than_the_limit_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(images, "MAX_PIXELS", 34)
    write_png8(tmp_path / "x.png", ramp(3))
    with pytest.raises(InputError, match="7 x 5 pixels, expected at most 34"):
        read_image(tmp_path / "x.png")


def test_too_many_channels_are_refused(tmp_path):
    path = tmp_path / "x.exr"
    with ImageWriter(path, 4, 4, 9, "float16", {}) as out:
        out.write(np.zeros((4, 4, 9), np.float16))
    with pytest.raises(InputError, match="9 channels, expected at most 8"):
        read_image(path)


def test_alpha_is_never_multiplied_in(tmp_path):
    path = tmp_path / "x.png"
    pixels = np.full((2, 2, 4), 200, np.uint8)
    pixels[..., 3] = 10
    write_png8(path, pixels)
    np.testing.assert_array_equal(read_image(path), pixels)


def test_a_file_that_cannot_be_written_is_told_in_one_line(tmp_path):
    with pytest.raises(WeaveusdError, match=r"x\.png: cannot be written: "):
        write_png8(tmp_path / "none" / "x.png", ramp(3))


def test_rows_that_do_not_fit_are_a_slip(tmp_path):
    with ImageWriter(tmp_path / "x.png", 7, 5, 3, "uint8", {}) as out:
        for rows in (np.zeros((6, 7, 3), np.uint8), np.zeros((5, 7, 3), np.uint16)):
            with pytest.raises(ValueError, match="unexpected rows"):
                out.write(rows)
        out.write(np.zeros((5, 7, 3), np.uint8))


@pytest.mark.parametrize(("suffix", "dtype"), [(".png", "uint8"), (".exr", "float16")])
def test_the_physical_size_is_stated_in_pixels_per_inch(tmp_path, suffix, dtype):
    path = tmp_path / f"x{suffix}"
    with ImageWriter(path, 100, 50, 1, dtype, density(100, 50, (25.4, 10.0))) as out:
        out.write(np.zeros((50, 100, 1), dtype))
    spec = oiio.ImageInput.open(str(path)).spec()
    assert spec.get_float_attribute("XResolution") == pytest.approx(100, rel=1e-4)
    assert spec.get_float_attribute("YResolution") == pytest.approx(127, rel=1e-4)
    assert spec.get_string_attribute("ResolutionUnit") in ("in", "inch")


def written(path: Path) -> bytes:
    noise = np.random.default_rng(0).random((64, 64, 3))
    if path.suffix == ".png":
        write_png8(path, (noise * 255).astype(np.uint8))
    else:
        with ImageWriter(path, 64, 64, 3, "float16", {}) as out:
            out.write(noise.astype(np.float16))
    return path.read_bytes()


@pytest.mark.parametrize("suffix", [".png", ".exr"])
@pytest.mark.parametrize("missing", [1, 100, 5000])
def test_a_disk_that_fills_up_never_goes_unnoticed(tmp_path, suffix, missing):
    path = tmp_path / f"x{suffix}"
    size = len(written(path))
    path.unlink()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size - missing, hard))
    try:
        with pytest.raises(WeaveusdError, match=rf"x\{suffix}: cannot be written"):
            written(path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, handler)


def test_a_png_with_any_part_missing_or_changed_is_refused(tmp_path):
    whole = written(tmp_path / "x.png")
    broken = {
        "cut short": [whole[: len(whole) * part // 8] for part in range(2, 8)] + [whole[:-1]],
        "wrong checksum": [whole[:5000] + b"x" + whole[5001:]],
        "no pixels": [whole[:33] + whole[-12:]],
    }
    for fault, variants in broken.items():
        for content in variants:
            (tmp_path / "y.png").write_bytes(content)
            assert fault in str(png_fault(tmp_path / "y.png"))
            with pytest.raises(InputError, match=r"y\.png: "):
                read_image(tmp_path / "y.png")
    assert png_fault(tmp_path / "x.png") is None


def test_rows_left_out_are_a_slip(tmp_path):
    with (
        pytest.raises(ValueError, match="2 rows of 5"),
        ImageWriter(tmp_path / "x.exr", 7, 5, 1, "float16", {}) as out,
    ):
        out.write(np.zeros((2, 7, 1), np.float16))
