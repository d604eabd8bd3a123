from __future__ import annotations

import struct
import time
import zlib
from pathlib import Path

import numpy as np
import pytest

from tests.validate.assets import cloth, publish
from weaveusd.errors import InputError
from weaveusd.export.images import ImageWriter
from weaveusd.validate import textures as module
from weaveusd.validate.open_asset import TEXTURE_FILES
from weaveusd.validate.textures import TextureFolder, decode_vectors, vector_table


def png_header(width: int, height: int) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    header = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    rows = zlib.compress(bytes(1000))
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
    )


def test_an_enormous_image_is_refused_by_its_header(tmp_path: Path) -> None:
    (tmp_path / "opacity.png").write_bytes(png_header(50_000, 50_000))
    start = time.perf_counter()
    with pytest.raises(InputError):
        TextureFolder(tmp_path).header("opacity.png")
    assert time.perf_counter() - start < 0.1


def test_an_image_wider_than_is_decoded_is_refused(tmp_path: Path) -> None:
    with ImageWriter(tmp_path / "opacity.png", 16385, 1, 1, "uint8", {}) as out:
        out.write(np.zeros((1, 16385, 1), np.uint8))
    with pytest.raises(InputError, match="16385 x 1 texels, expected at most 16384"):
        TextureFolder(tmp_path).header("opacity.png")


def test_what_is_no_image_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "opacity.png").write_text("a\nb")
    with pytest.raises(InputError, match=r"opacity\.png: not an image") as caught:
        TextureFolder(tmp_path).header("opacity.png")
    assert "\n" not in str(caught.value)


def test_decoding_in_bands_gives_what_decoding_at_once_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = publish(tmp_path / "v001").parent / "textures"
    (once,) = TextureFolder(folder).bands(*TEXTURE_FILES)
    monkeypatch.setattr(module, "BAND_TEXELS", 64 * 7)
    bands = list(TextureFolder(folder).bands(*TEXTURE_FILES))
    assert [band.first for band in bands] == [0, 16, 32, 48]
    for file in TEXTURE_FILES:
        rows = [band.pixels[file] for band in bands]
        np.testing.assert_array_equal(np.concatenate(rows), once.pixels[file])


def test_both_encodings_of_a_vector_decode_to_the_vector(tmp_path: Path) -> None:
    material = cloth()
    folder = publish(tmp_path / "v001", material).parent / "textures"
    truth = material.textures.whole()["normal"][::-1]
    (band,) = TextureFolder(folder).bands("normal.png", "normal.exr")
    for file, step in (("normal.png", 2.0**-16), ("normal.exr", 2.0**-12)):
        np.testing.assert_allclose(vector_table(file)[band.words(file)], truth, atol=step)
        np.testing.assert_allclose(decode_vectors(band.pixels[file]), truth, atol=step)
