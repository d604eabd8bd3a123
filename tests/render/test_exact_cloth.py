from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from pxr import Sdf, UsdGeom, UsdLux, UsdShade, UsdUtils

from tests.render.cloths import optics, plain_arrays, with_gaps
from tests.render.stages import (
    SQUARE,
    SQUARE_ST,
    add_camera,
    add_dome,
    add_mesh,
    bind,
    cloth_material,
    new_stage,
    picture,
    preview_material,
    write_cloth,
    write_image,
)
from weaveusd.errors import StageError

YARNS = ("linen", "shot weft")


def woven(size: int = 8) -> dict[str, Any]:
    """A cloth of two yarns, no two quadrants alike, with a gap in the quadrant +x +y."""
    arrays = plain_arrays(size=size)
    half = size // 2
    arrays["base_color"][:half, :half] = (0.8, 0.2, 0.1)
    arrays["base_color"][:half, half:] = (0.1, 0.7, 0.2)
    arrays["base_color"][half:, :half] = (0.1, 0.2, 0.6)
    arrays["normal"][:half] = (0.6, 0, 0.8)
    arrays["tangent"][:, half:] = (0.28, 0.96, 0)
    arrays["yarn_id"][half:] = 1
    gaps = np.zeros((size, size), bool)
    gaps[half:, half:] = True
    return with_gaps(arrays, gaps)


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    """A cloth card, repeated once, lit by a dome and a sun, seen from straight above."""
    made = new_stage(tmp_path / "scene.usda")
    add_dome(made, 0.5)
    sun = UsdLux.DistantLight.Define(made, "/World/Sun")
    sun.AddRotateYOp().Set(40.0)
    sun.CreateAngleAttr(0.0)
    sun.CreateIntensityAttr(2.0)
    add_camera(made).CreateProjectionAttr(UsdGeom.Tokens.orthographic)
    mesh = add_mesh(made)
    write_cloth(tmp_path / "textures", woven())
    bind(mesh, cloth_material(made, "/World/Cloth", optics(*YARNS, tau=0.2), (1.0, 1.0)))
    return made


def from_memory(mi: Any, stage: Any, arrays: Any, inputs: Any, uv_scale: Any) -> Any:
    """The same picture with the cloth made of arrays instead of files."""
    from weaveusd.render import cloth
    from weaveusd.render.bsdf import cloth_bsdf_dict

    kept = cloth.translate
    cloth.translate = lambda *_, **__: (cloth_bsdf_dict(arrays, inputs, uv_scale), "st")
    try:
        return picture(stage, 16, 128)[0]
    finally:
        cloth.translate = kept


def test_the_published_files_render_as_the_arrays_in_memory(mi: Any, stage: Any) -> None:
    found, losses = picture(stage, 16, 128)
    expected = from_memory(mi, stage, woven(), optics(*YARNS, tau=0.2), (1.0, 1.0))
    assert losses == []
    # Files hold half floats: the vectors differ in their fourth digit.
    np.testing.assert_allclose(found, expected, rtol=5e-3, atol=1e-3)
    turned = {name: value[::-1] for name, value in woven().items()}
    wrong = from_memory(mi, stage, turned, optics(*YARNS, tau=0.2), (1.0, 1.0))
    assert np.abs(wrong - expected).max() > 0.1


def test_the_cloth_lies_the_right_way_up(mi: Any, stage: Any) -> None:
    image, _ = picture(stage, 16, 64)
    corners = image.reshape(2, 8, 2, 8, 3)[:, 2:6, :, 2:6].mean(axis=(1, 3))
    assert corners[1, 0].argmax() == 0  # -x -y: the red yarn
    assert corners[1, 1].argmax() == 1  # +x -y: the green one
    assert corners[0, 0].argmax() == 2  # -x +y: the blue one
    assert corners[0, 1] == pytest.approx([0.5] * 3, rel=1e-3)  # +x +y: the dome through the gap


def test_one_unit_of_st_holds_uv_scale_repeats(mi: Any, stage: Any) -> None:
    scale = UsdShade.Shader(stage.GetPrimAtPath("/World/Cloth/Cloth")).GetInput("uv_scale")
    scale.Set((2.0, 4.0))
    image, _ = picture(stage, 64, 16)
    # Gaps lie in the quarter +x +y of every repeat, 32 x 16 pixels large; the image is top-down.
    dome = np.abs(image - 0.5).max(axis=2) < 1e-3
    assert dome[4::16, 24::32].all()
    assert not dome[12::16].any()
    assert not dome[:, 8::32].any()


def test_another_primvar_can_hold_the_coordinates(mi: Any, stage: Any) -> None:
    card = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Card"))
    before, _ = picture(stage, 8, 16)
    primvar = UsdGeom.PrimvarsAPI(card).CreatePrimvar(
        "cloth_st", Sdf.ValueTypeNames.Float2Array, UsdGeom.Tokens.vertex
    )
    primvar.Set(list(SQUARE_ST))
    UsdGeom.PrimvarsAPI(card).RemovePrimvar("st")
    _, losses = picture(stage, 8, 16)
    assert losses == ["/World/Card: has no texture coordinates st: 0 is used (approximated)"]
    shader = UsdShade.Shader(stage.GetPrimAtPath("/World/Cloth/Cloth"))
    shader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("cloth_st")
    after, losses = picture(stage, 8, 16)
    np.testing.assert_array_equal(before, after)
    assert losses == []


def test_values_of_the_interface_reach_the_shader(mi: Any, stage: Any) -> None:
    before, _ = picture(stage, 8, 16)
    material = UsdShade.Material(stage.GetPrimAtPath("/World/Cloth"))
    shader = UsdShade.Shader(stage.GetPrimAtPath("/World/Cloth/Cloth"))
    public = material.CreateInput("scale", Sdf.ValueTypeNames.Float2)
    public.Set((3.0, 3.0))
    shader.GetInput("uv_scale").ConnectToSource(public)
    assert np.abs(picture(stage, 8, 16)[0] - before).max() > 0.05


def test_the_preview_is_used_in_the_preview_context(mi: Any, stage: Any) -> None:
    _, surface = preview_material(stage, "/World/Cloth", diffuseColor=(0.9, 0.0, 0.0), ior=1.0)
    exact, _ = picture(stage, 8, 16)
    plain, losses = picture(stage, 8, 16, context="preview")
    assert exact[..., 1].max() > 0.1
    assert plain[..., 1].max() < 1e-3
    assert losses == []
    assert surface.GetPrim().IsValid()


def test_a_cloth_can_be_read_out_of_a_package(mi: Any, stage: Any, tmp_path: Path) -> None:
    from weaveusd.stage import open_stage

    stage.Save()
    package = tmp_path / "packed.usdz"
    assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "scene.usda"), str(package))
    np.testing.assert_array_equal(picture(open_stage(package), 8, 16)[0], picture(stage, 8, 16)[0])


def shader_of(stage: Any) -> Any:
    return UsdShade.Shader(stage.GetPrimAtPath("/World/Cloth/Cloth"))


def textures_of(stage: Any) -> Path:
    return Path(stage.GetRootLayer().realPath).parent / "textures"


FAULTS: dict[str, tuple[Any, str]] = {
    "a missing file": (
        lambda s: (textures_of(s) / "normal.exr").unlink(),
        r"inputs:normal_file: \./textures/normal\.exr is not found$",
    ),
    "a file that is no image": (
        lambda s: (textures_of(s) / "tangent.exr").write_bytes(b"not an image"),
        r"inputs:tangent_file: .* is no image that can be read",
    ),
    "vectors in eight bits": (
        lambda s: shader_of(s).GetInput("normal_file").Set("./textures/opacity.png"),
        r"inputs:normal_file: has 1 channels, expected at least 3",
    ),
    "a texture of another size": (
        lambda s: write_image(textures_of(s) / "base_color.exr", np.ones((4, 4, 3))),
        r"base_color: is 4 x 4 texels, expected 8 x 8",
    ),
    "a yarn without optics": (
        lambda s: write_image(
            textures_of(s) / "yarn_id.png", np.full((8, 8, 1), 3 / 255), oiio.UINT8
        ),
        r"yarn_id: names yarn 2, but the shader describes 2",
    ),
    "yarn ids in sixteen bits": (
        lambda s: write_image(textures_of(s) / "yarn_id.png", np.ones((8, 8, 1)), oiio.UINT16),
        r"yarn_id_file: has 16 bits a texel, expected 8",
    ),
    "a color that is no number": (
        lambda s: write_image(textures_of(s) / "base_color.exr", np.full((8, 8, 3), np.nan)),
        r"base_color\.exr holds a texel that is no finite number",
    ),
    "optics of one yarn too few": (
        lambda s: shader_of(s).GetInput("k_s").Set([1.0]),
        r"k_s: has 1 values, but eta has 2",
    ),
    "optics of no yarn": (
        lambda s: shader_of(s).GetInput("eta").GetAttr().Block(),
        r"inputs:eta: is None, expected float\[\]",
    ),
    "no scale": (
        lambda s: shader_of(s).GetInput("uv_scale").Set((0.0, 1.0)),
        r"uv_scale: is \(0\.0, 1\.0\), expected two positive numbers",
    ),
}


@pytest.mark.parametrize("fault", list(FAULTS))
def test_a_broken_cloth_is_refused_in_one_line(mi: Any, stage: Any, fault: str) -> None:
    damage, message = FAULTS[fault]
    damage(stage)
    with pytest.raises(StageError, match=message) as caught:
        picture(stage, 4, 1)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("/World/Cloth/Cloth")


def test_a_huge_texture_is_refused_before_it_takes_memory(
    mi: Any, stage: Any, tmp_path: Path
) -> None:
    # A PNG header that promises 400 gigabytes, and nothing behind it.
    import struct
    import zlib

    body = b"IHDR" + struct.pack(">IIBBBBB", 200_000, 500_000, 8, 6, 0, 0, 0)
    chunk = struct.pack(">I", 13) + body + struct.pack(">I", zlib.crc32(body))
    (textures_of(stage) / "opacity.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk)
    with pytest.raises(StageError, match=r"opacity\.png (has 200000 x 500000|is no image)"):
        picture(stage, 4, 1)


def test_the_sun_shines_through_the_gaps(mi: Any, stage: Any) -> None:
    # A net of gaps alone, between the sun and a card: the card is lit as if it were not there.
    stage.RemovePrim("/World/Dome")
    stage.RemovePrim("/World/Card")
    add_mesh(stage, "/World/Wall", color=(0.5, 0.5, 0.5))
    lit, _ = picture(stage, 8, 16)
    net = add_mesh(stage, "/World/Net", points=[(20 * x, 20 * y, 2) for x, y, _ in SQUARE])
    bind(net, UsdShade.Material(stage.GetPrimAtPath("/World/Cloth")))
    shaded, _ = picture(stage, 8, 16)
    assert shaded.mean() < 0.9 * lit.mean()  # one gap in four, and what the yarns let through
    arrays = plain_arrays(size=8)
    write_cloth(textures_of(stage), with_gaps(arrays, np.ones((8, 8), bool)))
    through, losses = picture(stage, 8, 16)
    np.testing.assert_allclose(through, lit, rtol=1e-3)
    assert losses == []
