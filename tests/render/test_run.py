from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from pxr import Gf, Usd, UsdGeom

import weaveusd
from tests.render.stages import add_camera, add_dome, add_mesh, new_stage
from weaveusd.errors import InputError, StageError


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    stage = new_stage(tmp_path / "scene.usda")
    add_mesh(stage, color=(0.5, 0.25, 0.1))
    add_dome(stage)
    add_camera(stage).CreateVerticalApertureAttr(10.0)
    stage.Save()
    return tmp_path / "scene.usda"


def decoded(path: Path) -> Any:
    return np.asarray(oiio.ImageInput.open(str(path)).read_image(oiio.FLOAT))


def test_a_render_says_what_it_did(mi: Any, scene: Path) -> None:
    result = weaveusd.render(scene, width=32, spp=8)
    assert result.image.shape == (16, 32, 3)  # the height follows from the aperture
    assert result.image.dtype == np.float32
    assert not result.image.flags.writeable
    assert (result.width, result.height, result.spp) == (32, 16, 8)
    assert result.output is None
    assert result.variant == "llvm_ad_rgb"
    assert result.losses == ()
    assert result.seconds > 0


def test_an_exr_holds_the_picture_as_it_is(mi: Any, scene: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.exr"
    result = weaveusd.render(scene, output, width=16, spp=8)
    assert result.output == output
    np.testing.assert_array_equal(decoded(output), result.image.astype(np.float16))


def test_a_png_holds_srgb_without_exposure(mi: Any, scene: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.png"
    image = weaveusd.render(scene, output, width=16, height=16, spp=64).image
    found = decoded(output)[8, 8]
    expected = [1.055 * x ** (1 / 2.4) - 0.055 for x in image[8, 8]]
    assert found == pytest.approx(expected, abs=0.003)


@pytest.mark.parametrize("suffix", [".exr", ".png"])
def test_the_same_seed_gives_the_same_bytes(
    mi: Any, scene: Path, tmp_path: Path, suffix: str
) -> None:
    def run(name: str, seed: int) -> bytes:
        output = tmp_path / (name + suffix)
        weaveusd.render(scene, output, width=24, spp=4, seed=seed)
        return output.read_bytes()

    assert run("first", 5) == run("second", 5)
    assert run("first", 5) != run("third", 6)


def test_not_even_the_last_bit_depends_on_the_threads(mi: Any, scene: Path) -> None:
    first = weaveusd.render(scene, width=100, height=100, spp=24).image
    for _ in range(5):
        again = weaveusd.render(scene, width=100, height=100, spp=24).image
        np.testing.assert_array_equal(again, first)


def test_another_process_gives_the_same_bytes(mi: Any, scene: Path, tmp_path: Path) -> None:
    output = tmp_path / "here.exr"
    weaveusd.render(scene, output, width=24, spp=4)
    there = tmp_path / "there.exr"
    code = f"import weaveusd; weaveusd.render({str(scene)!r}, {str(there)!r}, width=24, spp=4)"
    subprocess.run([sys.executable, "-c", code], check=True)
    assert there.read_bytes() == output.read_bytes()


def test_many_small_passes_are_one_picture(
    mi: Any, scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from weaveusd.render import trace

    told: list[float] = []
    whole = weaveusd.render(scene, width=16, height=16, spp=64)
    monkeypatch.setattr(trace, "SAMPLES_A_PASS", 16 * 16 * 20)
    parts = weaveusd.render(scene, width=16, height=16, spp=64, progress=told.append)
    assert told == [20 / 64, 40 / 64, 60 / 64, 1.0]
    assert parts.image.mean() == pytest.approx(whole.image.mean(), rel=0.01)
    assert np.abs(parts.image - whole.image).max() > 0


def test_the_scalar_variant_renders_the_same(mi: Any, scene: Path) -> None:
    fast = weaveusd.render(scene, width=6, height=6, spp=256)
    slow = weaveusd.render(scene, width=6, height=6, spp=256, variant="scalar_rgb")
    assert slow.variant == "scalar_rgb"
    np.testing.assert_allclose(slow.image, fast.image, atol=0.1)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("out.jpg", r"ends in '\.jpg', expected \.exr or \.png"),
        ("none/out.exr", "the folder .*none does not exist"),
        ("folder.exr", "is a folder"),
    ],
)
def test_an_output_that_cannot_be_written_stops_at_once(
    scene: Path, tmp_path: Path, name: str, message: str
) -> None:
    (tmp_path / "folder.exr").mkdir()
    with pytest.raises(InputError, match=message):
        weaveusd.render(scene, tmp_path / name)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"width": 0}, "width is 0, expected 1 to 16384 pixels"),
        ({"height": 20000}, "height is 20000"),
        ({"spp": 0}, "spp is 0"),
        ({"seed": -1}, "seed is -1"),
        ({"variant": "llvm_mono"}, "unknown variant 'llvm_mono'"),
        ({"context": "arnold"}, "unknown render context 'arnold'"),
        ({"camera": "/Nowhere"}, "/Nowhere is no camera"),
    ],
)
def test_settings_out_of_range_are_refused(
    mi: Any, scene: Path, setting: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        weaveusd.render(scene, **setting)


def test_a_file_that_is_no_stage_is_refused(mi: Any, tmp_path: Path) -> None:
    (tmp_path / "bad.usda").write_text("no usd")
    with pytest.raises(StageError):
        weaveusd.render(tmp_path / "bad.usda")


def test_a_failed_write_leaves_the_old_picture(
    mi: Any, scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from weaveusd.render import pictures

    output = tmp_path / "out.exr"
    output.write_bytes(b"old")

    def fail(*_: Any) -> None:
        raise InputError("disk full")

    monkeypatch.setattr(pictures, "_write", fail)
    with pytest.raises(InputError, match="disk full"):
        weaveusd.render(scene, output, width=4, spp=1)
    assert output.read_bytes() == b"old"
    assert sorted(os.listdir(tmp_path)) == ["out.exr", "scene.usda"]


def test_a_picture_has_the_rights_of_any_new_file(mi: Any, scene: Path, tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("")
    weaveusd.render(scene, tmp_path / "out.png", width=4, spp=1)
    assert (tmp_path / "out.png").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_the_command_tells_losses_frames_and_purposes(
    mi: Any, scene: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from weaveusd import cli

    stage = Usd.Stage.Open(str(scene))
    card = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Card"))
    card.CreatePurposeAttr("guide")
    card.GetDisplayColorAttr().Set([Gf.Vec3f(0, 0, 0)], 7)
    stage.DefinePrim("/World/Smoke", "Volume")
    stage.Save()
    output = scene.parent / "out.exr"
    arguments = ["render", str(scene), "--output", str(output), "--json", "--width", "16"]
    told = []
    for more in ([], ["--frame", "7", "--purpose", "guide", "--purpose", "render"]):
        monkeypatch.setattr(sys, "argv", ["weaveusd", *arguments, *more])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        assert ended.value.code == 0
        told.append((json.loads(capsys.readouterr().out)["losses"], decoded(output)[4, 8].max()))
    smoke = {
        "prim": "/World/Smoke",
        "kind": "dropped",
        "what": "Volume is not supported",
        "count": 1,
    }
    assert told == [([smoke], 1.0), ([smoke], 0.0)]
