"""UsdUVTexture: files, wraps, spaces and coordinates against what the specification says."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from pxr import Sdf, UsdShade, UsdUtils

from tests.render.networks import QUADRANTS, card_stage, large_texels, node, quadrants
from tests.render.stages import add_mesh, bind, picture, preview_material, write_image


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return card_stage(tmp_path)


def textured(stage: Any, file: str, output: str = "rgb", st: Any = None, **inputs: Any) -> None:
    """A matte card whose color is a texture of /World/Look; without `st` it follows st."""
    material, shader = preview_material(stage, ior=1.0)
    if st is None:
        st = node(stage, "Reader", "UsdPrimvarReader_float2", "result", varname=("string", "st"))
    texture = node(
        stage, "Texture", "UsdUVTexture", output, file=("asset", file), st=("float2", st), **inputs
    )
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(texture)
    if not stage.GetPrimAtPath("/World/Card"):
        bind(add_mesh(stage), material)


def encoded(kind: Any) -> Any:
    """The quadrants as a file of that kind stores them: 8 bits under the sRGB curve."""
    linear = large_texels(QUADRANTS)
    if kind == oiio.UINT8:
        return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return linear


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("map.exr", oiio.HALF), ("map.exr", oiio.FLOAT), ("map.png", oiio.UINT8),
        ("map.png", oiio.UINT16), ("map.hdr", oiio.FLOAT), ("map.tif", oiio.UINT16),
        ("map.jpg", oiio.UINT8),
    ],
)  # fmt: skip
def test_every_file_is_the_right_way_up(
    mi: Any, stage: Any, tmp_path: Path, name: str, kind: Any
) -> None:
    write_image(tmp_path / name, encoded(kind), kind)
    textured(stage, f"./{name}")
    found, losses = quadrants(stage)
    np.testing.assert_allclose(found, QUADRANTS, atol=0.03)
    assert losses == []


def test_a_packed_texture_is_the_right_way_up(mi: Any, stage: Any, tmp_path: Path) -> None:
    from weaveusd.stage import open_stage

    write_image(tmp_path / "map.png", encoded(oiio.UINT8), oiio.UINT8)
    textured(stage, "./map.png")
    stage.GetRootLayer().Save()
    packed = tmp_path / "packed.usdz"
    assert UsdUtils.CreateNewUsdzPackage(stage.GetRootLayer().identifier, str(packed))
    (tmp_path / "map.png").unlink()
    found, losses = quadrants(open_stage(packed))
    np.testing.assert_allclose(found, QUADRANTS, atol=0.03)
    assert losses == []


def expected_at(s: float, t: float, wrap_s: str, wrap_t: str) -> Any:
    """The quadrant at texture coordinates under two wrap modes."""
    place = []
    for value, mode in ((s, wrap_s), (t, wrap_t)):
        if mode in ("black", "useMetadata") and not 0 <= value <= 1:
            return np.zeros(3)
        if mode == "repeat":
            value %= 1
        elif mode == "mirror":
            value = 1 - abs(value % 2 - 1)
        place.append(min(max(value, 0.001), 0.999))
    return QUADRANTS[int((1 - place[1]) * 2), int(place[0] * 2)]


@pytest.mark.parametrize(
    ("wrap_s", "wrap_t"),
    [
        ("repeat", "repeat"), ("clamp", "clamp"), ("mirror", "mirror"), ("black", "black"),
        ("repeat", "clamp"), ("mirror", "black"), ("clamp", "mirror"), ("useMetadata", "repeat"),
    ],
)  # fmt: skip
def test_each_axis_wraps_in_its_own_way(
    mi: Any, stage: Any, tmp_path: Path, wrap_s: str, wrap_t: str
) -> None:
    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    reader = node(stage, "Reader", "UsdPrimvarReader_float2", "result", varname=("string", "st"))
    spread = node(
        stage, "Spread", "UsdTransform2d", "result", in_=("float2", reader),
        scale=("float2", (4, 4)), translation=("float2", (-1.5, -1.5)),
    )  # fmt: skip
    textured(stage, "./map.exr", st=spread, wrapS=("token", wrap_s), wrapT=("token", wrap_t))
    image, losses = picture(stage, 32, 32)
    assert losses == []
    # Blocks of 4 × 4 pixels are half a unit of st: each lies within one quadrant.
    blocks = image.reshape(8, 4, 8, 4, 3)[:, 1:3, :, 1:3].mean(axis=(1, 3))
    for row in range(8):
        for column in range(8):
            s, t = 4 * (column + 0.5) / 8 - 1.5, 4 * (7.5 - row) / 8 - 1.5
            expected = expected_at(s, t, wrap_s, wrap_t)
            np.testing.assert_allclose(blocks[row, column], expected, atol=0.08)


def test_transforms_follow_each_other(mi: Any, stage: Any, tmp_path: Path) -> None:
    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    reader = node(stage, "Reader", "UsdPrimvarReader_float2", "result", varname=("string", "st"))
    first = node(
        stage, "First", "UsdTransform2d", "result", in_=("float2", reader),
        rotation=("float", 90.0),
    )  # fmt: skip
    second = node(
        stage, "Second", "UsdTransform2d", "result", in_=("float2", first),
        translation=("float2", (1, 0.5)),
    )  # fmt: skip
    textured(stage, "./map.exr", st=second, wrapS=("token", "repeat"), wrapT=("token", "repeat"))
    found, _ = quadrants(stage)
    for row in range(2):
        for column in range(2):
            s, t = 0.25 + 0.5 * column, 0.75 - 0.5 * row
            u, v = -t + 1, s + 0.5
            expected = QUADRANTS[int((1 - v % 1) * 2), int(u % 1 * 2)]
            np.testing.assert_allclose(found[row, column], expected, atol=0.05)


@pytest.mark.parametrize(("output", "channel"), [("r", 0), ("g", 1), ("b", 2), ("a", 3)])
def test_single_outputs_are_single_channels(
    mi: Any, stage: Any, tmp_path: Path, output: str, channel: int
) -> None:
    # Alpha stays apart: a decoder that multiplies color by it would show 0.05 for red.
    texel = np.array((0.2, 0.4, 0.6, 0.25), np.float32)
    spec = oiio.ImageSpec(4, 4, 4, oiio.UINT16)
    spec.attribute("oiio:UnassociatedAlpha", 1)
    writer = oiio.ImageOutput.create(str(tmp_path / "map.png"))
    assert writer.open(str(tmp_path / "map.png"), spec)
    assert writer.write_image(np.tile(texel, (4, 4, 1)))
    assert writer.close()
    textured(stage, "./map.png", output, sourceColorSpace=("token", "raw"))
    found, losses = quadrants(stage)
    assert losses == []
    assert found.mean() == pytest.approx(texel[channel], rel=0.02)


def test_scale_and_bias_act_after_decoding(mi: Any, stage: Any, tmp_path: Path) -> None:
    write_image(tmp_path / "map.png", np.full((4, 4, 3), 0.5), oiio.UINT8)
    textured(
        stage, "./map.png", scale=("float4", (0.5, 1, 2, 1)), bias=("float4", (0.1, 0, -0.1, 0))
    )
    linear = ((128 / 255 + 0.055) / 1.055) ** 2.4
    expected = (linear * 0.5 + 0.1, linear, linear * 2 - 0.1)
    assert quadrants(stage)[0].mean(axis=(0, 1)) == pytest.approx(expected, rel=0.02)


def test_a_missing_texture_shows_its_fallback(mi: Any, stage: Any) -> None:
    textured(stage, "./gone.png", fallback=("float4", (0.1, 0.2, 0.3, 1)))
    found, losses = quadrants(stage)
    assert found.mean(axis=(0, 1)) == pytest.approx((0.1, 0.2, 0.3), rel=0.03)
    assert losses == [
        "/World/Look/Texture: inputs:file: ./gone.png is not found: the texture's fallback is "
        "shown (dropped)"
    ]


def test_the_tiles_of_a_udim_lie_side_by_side(mi: Any, stage: Any, tmp_path: Path) -> None:
    colors = {1001: (0.9, 0.1, 0.1), 1002: (0.1, 0.9, 0.1), 1011: (0.1, 0.1, 0.9)}
    for tile, color in colors.items():
        size = 8 if tile == 1001 else 16
        write_image(tmp_path / f"map.{tile}.exr", np.tile(color, (size, size, 1)))
    stage.GetRootLayer().Save()
    reader = node(stage, "Reader", "UsdPrimvarReader_float2", "result", varname=("string", "st"))
    twice = node(
        stage, "Twice", "UsdTransform2d", "result", in_=("float2", reader), scale=("float2", (2, 2))
    )
    textured(stage, "./map.<UDIM>.exr", st=twice)
    found, losses = quadrants(stage)
    assert losses == []
    expected = np.array(((colors[1011], (0, 0, 0)), (colors[1001], colors[1002])))
    np.testing.assert_allclose(found, expected, atol=0.03)


def test_a_udim_that_would_not_fit_is_refused(
    mi: Any, stage: Any, tmp_path: Path, monkeypatch: Any
) -> None:
    from weaveusd.render import rasters

    for tile in (1001, 1100):  # two small files ask for a hundred tiles
        write_image(tmp_path / f"map.{tile}.exr", np.zeros((16, 16, 3)))
    monkeypatch.setattr(rasters, "MAX_BYTES", 200_000)
    textured(stage, "./map.<UDIM>.exr")
    _, losses = quadrants(stage)
    assert len(losses) == 1
    assert "has 10 x 10 tiles of 16 x 16 texels" in losses[0]


def test_an_empty_udim_shows_its_fallback(mi: Any, stage: Any) -> None:
    textured(stage, "./map.<UDIM>.exr")
    _, losses = quadrants(stage)
    assert len(losses) == 1
    assert "./map.<UDIM>.exr is not found" in losses[0]


@pytest.mark.parametrize(
    ("metadata", "expected"), [("periodic,periodic", "repeat"), ("clamp,mirror", "clamp")]
)
def test_the_wrap_that_a_file_states_counts(
    mi: Any, tmp_path: Path, metadata: str, expected: str
) -> None:
    from weaveusd.render.textures import read_image

    spec = oiio.ImageSpec(4, 4, 3, oiio.HALF)
    spec.attribute("wrapmodes", metadata)
    writer = oiio.ImageOutput.create(str(tmp_path / "map.exr"))
    assert writer.open(str(tmp_path / "map.exr"), spec)
    assert writer.write_image(np.zeros((4, 4, 3), np.float32))
    writer.close()
    assert read_image(str(tmp_path / "map.exr"), "here").wrap[0] == expected


def test_an_image_that_would_not_fit_is_refused_before_it_is_decoded(
    mi: Any, stage: Any, tmp_path: Path, monkeypatch: Any
) -> None:
    from weaveusd.render import rasters

    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    monkeypatch.setattr(rasters, "MAX_BYTES", 1000)
    textured(stage, "./map.exr")
    _, losses = quadrants(stage)
    assert losses == [
        f"/World/Look/Texture: inputs:file: {tmp_path}/map.exr takes 12288 bytes, of which 1000 "
        "are left: the texture's fallback is shown (dropped)"
    ]


def test_materials_of_equal_networks_share_a_look(mi: Any, stage: Any, tmp_path: Path) -> None:
    from pxr import Usd

    from weaveusd.render.materials import Looks
    from weaveusd.render.model import Losses

    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    textured(stage, "./map.exr")
    copy = stage.DefinePrim("/World/Copy")
    copy.GetReferences().AddInternalReference("/World/Look")
    other = add_mesh(stage, "/World/Other")
    bind(other, UsdShade.Material(copy))
    looks = Looks("preview", Usd.TimeCode.EarliestTime(), Losses())
    assert looks.of(stage.GetPrimAtPath("/World/Card")) is looks.of(other.GetPrim())
    UsdShade.Shader(stage.GetPrimAtPath("/World/Copy/Texture")).CreateInput(
        "wrapS", Sdf.ValueTypeNames.Token
    ).Set("clamp")
    looks = Looks("preview", Usd.TimeCode.EarliestTime(), Losses())
    assert looks.of(stage.GetPrimAtPath("/World/Card")) is not looks.of(other.GetPrim())


def png_header(width: int, height: int) -> bytes:
    """A PNG that promises its size and holds nothing."""
    ihdr = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    chunk = struct.pack(">I", 13) + ihdr + struct.pack(">I", zlib.crc32(ihdr))
    data = b"IDAT" + zlib.compress(b"")
    chunk += struct.pack(">I", len(data) - 4) + data + struct.pack(">I", zlib.crc32(data))
    return b"\x89PNG\r\n\x1a\n" + chunk


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (png_header(60000, 60000), "is no image"),
        (png_header(64, 64), "cannot be decoded"),
        (b"", "is no image"),
        (b"\x89PNG\r\n\x1a\nrubbish", "is no image"),
        (b"\x76\x2f\x31\x01" + b"\xff" * 64, "is no image"),
    ],
    ids=["bomb", "hollow", "empty", "rubbish", "rubbish_exr"],
)
def test_a_hostile_file_is_a_loss_of_one_line(
    mi: Any, stage: Any, tmp_path: Path, content: bytes, said: str
) -> None:
    name = "map.exr" if content.startswith(b"\x76") else "map.png"
    (tmp_path / name).write_bytes(content)
    textured(stage, f"./{name}", fallback=("float4", (0.5, 0.5, 0.5, 1)))
    found, losses = quadrants(stage)
    assert len(losses) == 1
    assert said in losses[0]
    assert "\n" not in losses[0]
    assert found.mean() == pytest.approx(0.5, rel=0.02)


def test_an_image_with_too_long_a_side_is_refused(
    mi: Any, stage: Any, tmp_path: Path, monkeypatch: Any
) -> None:
    from weaveusd.render import textures

    monkeypatch.setattr(textures, "MAX_SIDE", 16)
    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    textured(stage, "./map.exr")
    _, losses = quadrants(stage)
    assert len(losses) == 1
    assert "has 32 x 32 x 1 texels, expected at most 16 x 16" in losses[0]


def test_a_texel_that_is_no_number_is_refused(mi: Any, stage: Any, tmp_path: Path) -> None:
    pixels = np.full((4, 4, 3), 0.5)
    pixels[1, 2, 0] = np.nan
    write_image(tmp_path / "map.exr", pixels)
    textured(stage, "./map.exr")
    _, losses = quadrants(stage)
    assert len(losses) == 1
    assert "holds a texel that is no finite number" in losses[0]


def test_coordinates_far_out_do_no_harm(mi: Any, stage: Any, tmp_path: Path) -> None:
    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    reader = node(stage, "Reader", "UsdPrimvarReader_float2", "result", varname=("string", "st"))
    for scale in (1e8, -1e8):
        far = node(
            stage, "Far", "UsdTransform2d", "result", in_=("float2", reader),
            scale=("float2", (scale, scale)),
        )  # fmt: skip
        textured(stage, "./map.exr", st=far, wrapS=("token", "repeat"), wrapT=("token", "mirror"))
        found, _ = quadrants(stage)
        assert np.isfinite(found).all()
        assert found.max() <= 1
