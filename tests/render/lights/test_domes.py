from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdLux

from tests.render.lights.lamps import card, irradiance, received
from tests.render.stages import add_camera, add_dome, add_mesh, new_stage, picture, write_image

ROWS = 64

# A lat-long picture seen from inside: its middle is +z, a quarter to the left +x, the top +y.
LATLONG = {"+z": (0.5, 0.5), "+x": (0.25, 0.5), "-x": (0.75, 0.5), "+y": (0.5, 0.02),
           "-z": (0.0, 0.5), "-y": (0.5, 0.98)}  # fmt: skip
# A ball seen by a camera on +z: its middle shows +z, sin 45° to the right +x.
BALL = {"+z": (0.5, 0.5), "+x": (0.854, 0.5), "-x": (0.146, 0.5), "+y": (0.5, 0.146)}
ANGULAR = {"+z": (0.5, 0.5), "+x": (0.75, 0.5), "-x": (0.25, 0.5), "+y": (0.5, 0.25)}
# The faces of a cross, +z in the middle of its three columns and second of four rows.
CROSS = {"+z": (0.5, 0.375), "+x": (1 / 6, 0.375), "-x": (5 / 6, 0.375), "+y": (0.5, 0.125),
         "-z": (0.5, 0.875), "-y": (0.5, 0.625)}  # fmt: skip

LAYOUTS = {
    "latlong": (LATLONG, (ROWS, 2 * ROWS)),
    "mirroredBall": (BALL, (2 * ROWS, 2 * ROWS)),
    "angular": (ANGULAR, (2 * ROWS, 2 * ROWS)),
    "cubeMapVerticalCross": (CROSS, (2 * ROWS, 3 * ROWS // 2)),
}

# Rotations about y and x that turn a camera, which looks along -z, to a direction.
LOOKING = {
    "+z": (180, 0),
    "+x": (-90, 0),
    "-x": (90, 0),
    "+y": (0, 90),
    "-z": (0, 0),
    "-y": (0, -90),
}


def mark(path: Path, layout: str, where: str, color: Any = (1, 1, 1)) -> None:
    """Write a picture that is dark but around the place that shows one direction."""
    places, (height, width) = LAYOUTS[layout]
    column, row = int(places[where][0] * width), int(places[where][1] * height)
    pixels = np.full((height, width, 3), 1e-4, np.float32)
    rows = np.clip(np.arange(row - 3, row + 4), 0, height - 1)
    columns = np.arange(column - 3, column + 4) % width
    pixels[np.ix_(rows, columns)] = color
    if layout == "latlong" and where in ("+y", "-y"):
        pixels[: 3 if where == "+y" else None][-3:] = color  # all longitudes meet there
    write_image(path, pixels)


def marked(
    tmp_path: Path, where: str, up: str = "Y", kind: str = "DomeLight", layout: str = "latlong"
) -> tuple[Any, Any, Any]:
    """A stage with a marked dome and a camera at the origin; dome and camera."""
    stage = new_stage(tmp_path / "scene.usda", up)
    mark(tmp_path / "dome.exr", layout, where)
    dome = stage.DefinePrim("/World/Dome", kind)
    dome.GetAttribute("inputs:texture:file").Set(Sdf.AssetPath("./dome.exr"))
    if layout != "latlong":
        dome.GetAttribute("inputs:texture:format").Set(layout)
    return stage, dome, add_camera(stage, distance=0.0, fov=4)


def look(camera: Any, yaw: float, pitch: float) -> None:
    camera.ClearXformOpOrder()
    camera.AddRotateYOp(opSuffix="yaw").Set(float(yaw))
    camera.AddRotateXOp(opSuffix="pitch").Set(float(pitch))


@pytest.mark.parametrize(
    ("layout", "where"),
    [(name, where) for name, (places, _) in LAYOUTS.items() for where in places],
)
def test_a_marked_texel_is_seen_in_the_direction_of_its_layout(
    mi: Any, tmp_path: Path, layout: str, where: str
) -> None:
    stage, _, camera = marked(tmp_path, where, layout=layout)
    yaw, pitch = LOOKING[where]
    look(camera, yaw, pitch)
    image, losses = picture(stage, 3, 16)
    assert image[1, 1] == pytest.approx([1, 1, 1], abs=0.03)
    assert losses == []
    look(camera, yaw + 37, pitch - 40)
    assert picture(stage, 3, 16)[0][1, 1].max() < 0.01


@pytest.mark.parametrize(
    ("up", "kind", "pole", "top", "middle"),
    [
        ("Z", "DomeLight", None, "+y", "+z"),  # a plain dome stands on Y in any stage
        ("Z", "DomeLight_1", "scene", "+z", "-y"),
        ("Y", "DomeLight_1", "scene", "+y", "+z"),
        ("Y", "DomeLight_1", "Z", "+z", "-y"),
        ("Z", "DomeLight_1", "Y", "+y", "+z"),
    ],
)
def test_the_top_of_a_dome_points_along_its_pole(
    mi: Any, tmp_path: Path, up: str, kind: str, pole: str | None, top: str, middle: str
) -> None:
    """On Z, longitude 0 points along -Y."""
    for where, seen in (("+y", top), ("+z", middle)):
        folder = tmp_path / where[1]
        folder.mkdir()
        stage, dome, camera = marked(folder, where, up, kind)
        if pole:
            dome.GetAttribute("poleAxis").Set(pole)
        look(camera, *LOOKING[seen])
        assert picture(stage, 3, 16)[0][1, 1].min() > 0.9


@pytest.mark.parametrize("scale", [1.0, 7.0])
def test_a_turned_dome_turns_its_picture_and_ignores_its_size(
    mi: Any, tmp_path: Path, scale: float
) -> None:
    stage, dome, _ = marked(tmp_path, "+x")
    # The mark on +x comes to -z, where the camera looks, by a quarter turn about +y.
    UsdLux.DomeLight(dome).AddRotateYOp().Set(90.0)
    UsdLux.DomeLight(dome).AddScaleOp().Set(Gf.Vec3f(scale))
    assert picture(stage, 3, 16)[0][1, 1].min() > 0.9


def test_a_constant_dome_gives_pi_times_its_radiance(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    dome = add_dome(stage, 0.7)
    dome.CreateNormalizeAttr(True)  # of no meaning for a dome
    found, losses = irradiance(stage)
    assert found == pytest.approx(np.pi * 0.7, rel=0.01)
    assert losses == []


@pytest.mark.parametrize("albedo", [0.0, 0.18, 0.5, 1.0])
def test_a_card_shows_its_albedo_times_the_radiance_around_it(
    mi: Any, tmp_path: Path, albedo: float
) -> None:
    stage = new_stage(tmp_path / "scene.usda")
    add_mesh(stage, color=(albedo,) * 3)
    add_camera(stage, distance=1.0, fov=6)
    add_dome(stage, 0.7)
    image, losses = picture(stage, 3, 4096)
    assert image == pytest.approx(np.full((3, 3, 3), 0.7 * albedo), rel=0.01)
    assert losses == []


def test_a_cap_of_a_dome_gives_pi_times_its_squared_sine(mi: Any, tmp_path: Path) -> None:
    """Rows down to the angle θ off the pole shine, the pole over the card: E = π L sin²θ."""
    stage = card(tmp_path)
    rows = 181
    pixels = np.zeros((rows, 2 * rows, 3), np.float32)
    pixels[:41] = 2.0  # row r is r degrees off the pole; the edge falls half way to the next
    write_image(tmp_path / "cap.exr", pixels)
    dome = UsdLux.DomeLight.Define(stage, "/World/Dome")
    dome.CreateTextureFileAttr("./cap.exr")
    dome.AddRotateXOp().Set(90.0)
    found, losses = irradiance(stage, 8192)
    assert found == pytest.approx(np.pi * 2 * np.sin(np.radians(40.5)) ** 2, rel=0.01)
    assert losses == []


def test_a_picture_that_is_not_two_by_one_is_taken_as_latlong_and_said(
    mi: Any, tmp_path: Path
) -> None:
    stage = card(tmp_path)
    write_image(tmp_path / "square.exr", np.ones((8, 8, 3), np.float32))
    add_dome(stage).CreateTextureFileAttr("./square.exr")
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(np.pi, rel=0.01)
    assert losses == ["/World/Dome: texture of 8 x 8 texels is taken as latlong (approximated)"]


def test_domes_add_up(mi: Any, tmp_path: Path) -> None:
    """E = π Σ L for even ones, each in its own color."""
    stage = card(tmp_path)
    for k, color in enumerate(((1, 0, 0), (0, 0.5, 0), (0, 0, 0.25))):
        dome = UsdLux.DomeLight.Define(stage, f"/World/Dome{k}")
        dome.CreateColorAttr(Gf.Vec3f(*color))
    found, losses = received(stage)
    assert found == pytest.approx(np.pi * np.array((1, 0.5, 0.25)), rel=0.01)
    assert losses == []


def test_pictured_domes_add_up_each_with_its_own_turn(mi: Any, tmp_path: Path) -> None:
    """A red mark, and a green one turned beside it, over an even blue."""
    stage, dome, camera = marked(tmp_path, "+x")
    dome.GetAttribute("inputs:color").Set(Gf.Vec3f(1, 0, 0))
    other = UsdLux.DomeLight.Define(stage, "/World/Other")
    mark(tmp_path / "other.exr", "angular", "+z")
    other.CreateTextureFileAttr("./other.exr")
    other.CreateTextureFormatAttr("angular")
    other.CreateColorAttr(Gf.Vec3f(0, 1, 0))
    other.AddRotateXOp().Set(-90.0)  # its +z comes to +y
    even = UsdLux.DomeLight.Define(stage, "/World/Even")
    even.CreateColorAttr(Gf.Vec3f(0, 0, 0.5))
    seen = {}
    for where in ("+x", "+y", "-z"):
        look(camera, *LOOKING[where])
        image, losses = picture(stage, 3, 16)
        seen[where] = image[1, 1]
        assert losses == []
    assert seen["+x"] == pytest.approx([1, 0, 0.5], abs=0.05)
    assert seen["+y"] == pytest.approx([0, 1, 0.5], abs=0.05)
    assert seen["-z"] == pytest.approx([0, 0, 0.5], abs=0.01)


def test_a_turned_picture_keeps_its_flux(mi: Any, tmp_path: Path) -> None:
    """A small bright spot gives L ω cos θ wherever a second dome puts it."""
    found = []
    for turn in (0.0, 11.3):
        folder = tmp_path / str(turn)
        folder.mkdir()
        stage = card(folder)
        pixels = np.zeros((128, 256, 3), np.float32)
        pixels[63:65, 127:129] = 1000.0  # around +z, over the card
        write_image(folder / "spot.exr", pixels)
        write_image(folder / "dark.exr", np.zeros((256, 512, 3), np.float32))
        spot = UsdLux.DomeLight.Define(stage, "/World/Spot")
        spot.CreateTextureFileAttr("./spot.exr")
        spot.AddRotateYOp().Set(turn)
        other = UsdLux.DomeLight.Define(stage, "/World/Dark")
        other.CreateTextureFileAttr("./dark.exr")
        found.append(irradiance(stage, 4096)[0])
    assert found[1] / found[0] == pytest.approx(np.cos(np.radians(11.3)), rel=0.01)


@pytest.mark.parametrize(
    ("layout", "said"),
    [
        ("latlong", "is no image that can be read"),
        ("fisheye", "dome texture in the format fisheye: the dome has one color (dropped)"),
        ("cubeMapVerticalCross", "is 8 x 8 texels, expected a cross of 3 x 4 squares"),
    ],
)
def test_a_dome_whose_picture_cannot_be_read_has_one_color(
    mi: Any, tmp_path: Path, layout: str, said: str
) -> None:
    stage = card(tmp_path)
    if layout == "latlong":
        (tmp_path / "dome.exr").write_bytes(b"no picture")
    else:
        write_image(tmp_path / "dome.exr", np.ones((8, 8, 3), np.float32))
    dome = add_dome(stage)
    dome.CreateTextureFileAttr("./dome.exr")
    dome.CreateTextureFormatAttr(layout)
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(np.pi, rel=0.01)
    assert len(losses) == 1
    assert said in losses[0]


def test_a_pipe_is_not_waited_for(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    os.mkfifo(tmp_path / "dome.exr")
    add_dome(stage).CreateTextureFileAttr("./dome.exr")
    assert "./dome.exr is no regular file" in irradiance(stage, 1)[1][0]


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (2, 1), (3, 7)])
def test_the_smallest_pictures_are_shown(mi: Any, tmp_path: Path, shape: tuple[int, int]) -> None:
    stage = card(tmp_path)
    write_image(tmp_path / "dome.exr", np.full((*shape, 3), 0.5, np.float32))
    dome = add_dome(stage)
    dome.CreateTextureFileAttr("./dome.exr")
    dome.CreateTextureFormatAttr("latlong")
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(np.pi / 2, rel=0.01)
    assert losses == []


def test_a_gray_picture_with_negative_texels_is_clamped_and_said(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    pixels = np.full((8, 16, 1), 0.25, np.float32)
    pixels[-1] = -5
    write_image(tmp_path / "dome.exr", pixels)
    dome = add_dome(stage)
    dome.CreateTextureFileAttr("./dome.exr")
    dome.AddRotateXOp().Set(90.0)
    found, losses = received(stage, 256)
    assert found == pytest.approx(np.full(3, np.pi / 4), rel=0.01)
    assert losses == ["/World/Dome: negative radiance in its texture is taken as 0 (approximated)"]


def test_a_portal_is_named_and_hides_nothing(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    dome = add_dome(stage)
    UsdLux.PortalLight.Define(stage, "/World/Dome/Portal")
    dome.CreatePortalsRel().AddTarget("/World/Dome/Portal")
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(np.pi, rel=0.01)
    assert losses == [
        "/World/Dome: portal /World/Dome/Portal guides no samples: "
        "the dome shines through everything (approximated)",
        "/World/Dome/Portal: portal guides no samples (approximated)",
    ]
