"""Moment maps of an asset as Mitsuba reads them: right ones, missing ones and hostile ones."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from pxr import Sdf, Usd, UsdShade

from weaveusd import pipeline
from weaveusd.contract import CLOTH_SHADER_ID, MAX_MOMENT_TEXELS, moment_inputs
from weaveusd.draft.make import make_draft
from weaveusd.draft.resolve import from_drawdown
from weaveusd.draft.write import write_wif
from weaveusd.errors import StageError
from weaveusd.render.model import Losses
from weaveusd.render.run import render
from weaveusd.render.scenes import dress, scene_path
from weaveusd.stage import open_stage

TEXELS = 128
RECIPE = """
name = "brocade"
title = "Linen with threads of gold"
source = "a test"
certainty = "none"
[sett]
ends_per_cm = 19
picks_per_cm = 17
[[yarn]]
name = "linen"
systems = ["warp", "weft"]
palette = [1]
fibre = "linen"
tex = 66
twist_per_m = 420
packing = 0.6
flatness = 0.6
color = "#c8b48c"
[yarn.optics]
eta = 1.46
k_d = 0.3
gamma_s_deg = 12
gamma_v_deg = 24
[[yarn]]
name = "gold"
systems = ["warp"]
palette = [2]
fibre = "linen"
tex = 66
twist_per_m = 0
packing = 0.6
flatness = 0.6
color = "#c8b48c"
[yarn.optics]
eta = 1.8
k_d = 0.0
gamma_s_deg = 2
gamma_v_deg = 4
"""


@pytest.fixture(scope="module")
def entry(tmp_path_factory: Any) -> Path:
    """A linen of which every other end is of gold, published."""
    folder = tmp_path_factory.mktemp("brocade")
    (folder / "brocade.toml").write_text(RECIPE)
    up = make_draft("twill:2/2").drawdown()
    ends = np.arange(4, dtype=np.int32) % 2
    draft = from_drawdown(up, ends, np.zeros(4, np.int32), np.full((2, 3), 0.5))
    (folder / "brocade.wif").write_bytes(write_wif(draft))
    done = pipeline.publish(
        folder / "brocade.wif", recipe=folder / "brocade.toml", root=folder, resolution=TEXELS
    )
    return Path(done.asset.entry)


def shader_of(stage: Usd.Stage) -> UsdShade.Shader:
    return next(
        shader
        for shader in map(UsdShade.Shader, stage.Traverse())
        if shader and shader.GetIdAttr().Get() == CLOTH_SHADER_ID
    )


def translated(entry: Path, values: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The BSDF with levels and the losses, once inputs have other values."""
    from weaveusd.render.cloth import translate

    stage = open_stage(entry)
    stage.SetEditTarget(stage.GetSessionLayer())
    shader = shader_of(stage)
    for name, value in values.items():
        shader.GetInput(name).GetAttr().Set(Sdf.ValueBlock() if value is None else value)
    losses = Losses()
    bsdf, _ = translate(shader, Usd.TimeCode.Default(), losses, levels=True)
    return bsdf, [loss.what for loss in losses.as_tuple()]


def written(file: Path, pixels: Any, kind: str = "half") -> Sdf.AssetPath:
    rows, columns, channels = pixels.shape
    out = oiio.ImageOutput.create(str(file))
    assert out.open(str(file), oiio.ImageSpec(columns, rows, channels, kind))
    out.write_image(np.ascontiguousarray(pixels, np.float32))
    out.close()
    return Sdf.AssetPath(str(file))


def texels_of(entry: Path, name: str) -> Any:
    stage = open_stage(entry)
    path = shader_of(stage).GetInput(name).Get().resolvedPath
    return oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)


def test_an_asset_has_its_maps_and_its_kinds(mi: Any, entry: Path) -> None:
    bsdf, losses = translated(entry, {})
    assert losses == []
    np.testing.assert_array_equal(bsdf["kind_counts"].array, [2, 1])
    shares = np.array(bsdf["kinds"])[-1]
    assert shares[0] == pytest.approx(0.5, abs=0.05)
    assert shares[1:] == pytest.approx(1)


def test_the_finest_level_has_its_row_0_where_v_is_0(mi: Any, entry: Path) -> None:
    bsdf, _ = translated(entry, {})
    albedo = texels_of(entry, "weft_albedo_file")
    cells = np.array(bsdf["cells"])[: albedo.shape[0] * albedo.shape[1], 16:]
    share = cells[:, :3].sum(-1).reshape(albedo.shape[:2])
    np.testing.assert_allclose(share, albedo[::-1, :, 3], atol=2e-3)
    assert np.abs(share - albedo[..., 3]).max() > 0.1


def test_an_older_asset_is_shown_by_its_texels_and_told(mi: Any, entry: Path) -> None:
    stage = open_stage(entry)
    given = [name for name in moment_inputs() if shader_of(stage).GetInput(name)]
    bsdf, losses = translated(entry, dict.fromkeys(given))
    assert "cells" not in bsdf
    assert losses == ["cloth is shown in full: it has no moment maps to be seen by"]


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("warp_section", (0.0, 0.1), "is [0, 0.1], expected a flatness from 0.001 to 1000"),
        ("weft_section", (0.5, float("nan")), "expected a flatness"),
        ("weft_section", (0.5, -0.1), "and a curvature from 0 to 1000"),
        ("warp_kinds", [], "is [], expected 1 to 4 yarn ids from 1 to 3"),
        ("warp_kinds", [1, 4], "is [1, 4], expected 1 to 4 yarn ids"),
        ("warp_kinds", [0], "expected 1 to 4 yarn ids"),
        ("warp_kinds", [1] * 900, "expected 1 to 4 yarn ids"),
        ("warp_kinds", None, "is None, expected int[]"),
        ("warp_slopes_file", None, "names no file"),
        ("weft_kinds", [2, 2], "inputs:weft_kinds_file: names no file"),
        ("weft_along_file", Sdf.AssetPath("./none.exr"), "./none.exr is not found"),
    ],
)
def test_an_input_that_makes_no_sense_is_refused(
    mi: Any, entry: Path, name: str, value: Any, told: str
) -> None:
    with pytest.raises(StageError, match=re.escape(told)) as refused:
        translated(entry, {name: value})
    assert f"/Material/MitsubaSurface.inputs:{name.removesuffix('_kinds')}" in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("suffix", "shape", "kind", "told"),
    [
        ("exr", (16, 8, 4), "half", "has 8 x 16 texels, expected 16 x 16 as the other moment maps"),
        ("exr", (16, 16, 3), "half", "has 3 channels, expected at least 4"),
        ("png", (16, 16, 4), "uint8", "holds 8-bit integers, expected half or float"),
        ("exr", (MAX_MOMENT_TEXELS // 512 + 1, 512, 4), "half", "expected at most 262144 in all"),
    ],
)
def test_a_map_of_another_form_is_refused(
    mi: Any, entry: Path, tmp_path: Path, suffix: str, shape: Any, kind: str, told: str
) -> None:
    file = written(tmp_path / f"map.{suffix}", np.zeros(shape), kind)
    with pytest.raises(StageError, match=told) as refused:
        translated(entry, {"warp_along_file": file})
    assert "inputs:warp_along_file: " in str(refused.value)


def test_a_map_with_a_number_that_is_none_is_refused(mi: Any, entry: Path, tmp_path: Path) -> None:
    pixels = texels_of(entry, "warp_across_file")
    pixels[3, 4, 1] = np.nan
    file = written(tmp_path / "map.exr", pixels)
    with pytest.raises(StageError, match="holds a texel that is no finite number"):
        translated(entry, {"warp_across_file": file})


@pytest.mark.parametrize("name", ["slopes", "along", "across", "albedo", "kinds"])
@pytest.mark.parametrize("number", [-6e4, 6e4])
def test_numbers_that_no_mean_can_be_are_mended_and_told(
    mi: Any, entry: Path, tmp_path: Path, name: str, number: float
) -> None:
    pixels = texels_of(entry, f"warp_{name}_file")
    pixels[3, 4] = number
    pixels[5, 6] = number
    file = written(tmp_path / "map.exr", pixels)
    bsdf, losses = translated(entry, {f"warp_{name}_file": file})
    assert losses == ["2 texels of the moment maps hold what no mean can be; mended"]
    cells = np.array(bsdf["cells"])
    assert np.abs(cells).max() <= 1 + 1e-5
    assert cells.reshape(-1, 2, 16)[..., :3].sum((1, 2)).max() <= 1 + 1e-5


def test_a_cloth_in_acescg_has_the_albedo_of_one_in_rec709(mi: Any, tmp_path: Path) -> None:
    draft = tmp_path / "twill.wif"
    draft.write_bytes(write_wif(make_draft("twill:2/2")))
    colors = []
    for space in ("lin_rec709", "acescg"):
        done = pipeline.publish(
            draft, preset="shot_silk", root=tmp_path / space, resolution=64, color_space=space
        )
        bsdf, losses = translated(Path(done.asset.entry), {})
        assert losses == []
        colors.append(np.array(bsdf["cells"])[-1].reshape(2, 16)[:, 12:15])
    np.testing.assert_allclose(colors[1], colors[0], atol=0.02)


def test_a_picture_of_an_older_asset_is_the_full_one_and_says_so(
    mi: Any, entry: Path, tmp_path: Path
) -> None:
    scene = dress(scene_path("swatch"), entry, tmp_path / "older.usda")
    stage = open_stage(scene)
    shader = shader_of(stage)
    for name in moment_inputs():
        if shader.GetInput(name):
            shader.GetInput(name).GetAttr().Set(Sdf.ValueBlock())
    stage.GetRootLayer().Save()
    full, auto = (render(scene, width=8, spp=2, lod=lod) for lod in ("full", "auto"))
    np.testing.assert_array_equal(auto.image, full.image)
    assert full.losses == ()
    (loss,) = auto.losses
    assert loss.as_dict()["kind"] == "approximated"
    assert "it has no moment maps" in loss.what


def test_gold_among_linen_is_as_bright_from_afar_as_near(
    mi: Any, entry: Path, tmp_path: Path
) -> None:
    stage = dress(scene_path("swatch"), entry, tmp_path / "swatch.usda")
    full, level = (
        render(stage, width=16, spp=256, lod=lod).image.astype(float) for lod in ("full", 9)
    )
    np.testing.assert_allclose(level.mean((0, 1)), full.mean((0, 1)), rtol=0.03)
