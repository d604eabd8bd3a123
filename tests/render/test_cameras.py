from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from tests.render.stages import SQUARE, add_camera, add_dome, add_mesh, new_stage, picture
from weaveusd.errors import StageError

SIZE = (96, 64)


def camera_of(stage: Any, **changes: Any) -> Any:
    camera = UsdGeom.Camera.Define(stage, "/World/Rig/Camera")
    camera.AddTransformOp().Set(
        Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 2, -0.5), 25))
        * Gf.Matrix4d().SetTranslate(Gf.Vec3d(3, -2, 20))
    )
    rig = UsdGeom.Xformable(camera.GetPrim().GetParent())
    rig.GetPrim().SetTypeName("Xform")
    UsdGeom.Xformable(rig.GetPrim()).AddScaleOp().Set((1.5, 1.5, 1.5))
    for name, value in changes.items():
        camera.GetPrim().GetAttribute(name).Set(value)
    return camera


def expected_pixel(camera: Any, point: Any, size: tuple[int, int]) -> Any:
    """Where USD's own camera puts a point: GfCamera's frustum, the aperture grown to fit."""
    gf = camera.GetCamera(0)
    aspect = size[0] / size[1]
    if aspect > gf.horizontalAperture / gf.verticalAperture:
        gf.horizontalAperture = gf.verticalAperture * aspect
    else:
        gf.verticalAperture = gf.horizontalAperture / aspect
    frustum = gf.frustum
    matrix = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()
    x, y, _ = matrix.Transform(Gf.Vec3d(*point))
    return np.array(((x + 1) / 2 * size[0], (1 - y) / 2 * size[1]))


def marked(tmp_path: Path, camera_maker: Any = camera_of, **changes: Any) -> tuple[Any, Any, Any]:
    """A stage with one small black square that faces the camera, and where it should be."""
    stage = new_stage(tmp_path / "scene.usda")
    camera = camera_maker(stage, **changes)
    return stage, camera, mark(stage, camera)


def mark(stage: Any, camera: Any, frame: float = 0.0) -> Any:
    """Put the square 12 units before the camera and return its middle."""
    view = camera.ComputeLocalToWorldTransform(frame)
    view = view.RemoveScaleShear() if view.GetDeterminant3() > 0 else view
    corners = [
        view.Transform(Gf.Vec3d(1.1 + x * 0.15, 0.7 + y * 0.15, -12))
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    add_mesh(stage, points=corners, color=(0, 0, 0))
    return view.Transform(Gf.Vec3d(1.1, 0.7, -12))


def seen_at(stage: Any, size: tuple[int, int], spp: int = 128, **more: Any) -> Any:
    """The pixel on which the darkness of the picture is centered."""
    image = picture(stage, size, spp, **more)[0][..., 0]
    # The white dome fills the background; the card is one black square in it.
    weight = np.where(image < 0.999, 1 - image, 0)
    rows, columns = np.mgrid[: size[1], : size[0]] + 0.5
    return np.array(((weight * columns).sum(), (weight * rows).sum())) / weight.sum()


@pytest.mark.parametrize("size", [(96, 64), (64, 80)])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"horizontalAperture": 30.0, "verticalAperture": 10.0, "focalLength": 40.0},
        {"horizontalApertureOffset": 2.0, "verticalApertureOffset": -1.5},
        {"projection": "orthographic", "horizontalAperture": 60.0, "verticalAperture": 50.0},
        {
            "projection": "orthographic", "horizontalAperture": 60.0, "verticalAperture": 50.0,
            "horizontalApertureOffset": 8.0, "verticalApertureOffset": -6.0,
        },
        {"fStop": 64.0, "focusDistance": 12.0},
        {
            "fStop": 64.0, "focusDistance": 12.0,
            "horizontalApertureOffset": 2.0, "verticalApertureOffset": -1.5,
        },
        {
            "fStop": 64.0, "focusDistance": 12.0,
            "horizontalApertureOffset": -1.0, "verticalApertureOffset": 2.5,
        },
    ],
)  # fmt: skip
def test_a_known_point_falls_on_its_pixel(
    mi: Any, tmp_path: Path, size: tuple[int, int], changes: dict[str, Any]
) -> None:
    stage, camera, point = marked(tmp_path, **changes)
    # The film of an open lens can be cut at half pixels.
    rough = "fStop" in changes and "verticalApertureOffset" in changes
    np.testing.assert_allclose(
        seen_at(stage, size), expected_pixel(camera, point, size), atol=0.37 if rough else 0.12
    )


def test_a_moving_camera_is_where_it_is_at_the_frame(mi: Any, tmp_path: Path) -> None:
    stage = new_stage(tmp_path / "scene.usda")
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    move = camera.AddTranslateOp()
    move.Set((0, 0, 20), 1)
    move.Set((2, 1, 20), 5)
    camera.GetFocalLengthAttr().Set(30.0, 1)
    camera.GetFocalLengthAttr().Set(70.0, 5)
    add_mesh(stage, points=[(x * 0.05, y * 0.05, 0) for x, y, _ in SQUARE], color=(0, 0, 0))
    for frame in (1, 2, 4.5):
        gf = camera.GetCamera(frame)
        slope = gf.horizontalAperture / gf.focalLength / 64 * 20  # units a pixel
        at = np.array(camera.ComputeLocalToWorldTransform(frame).ExtractTranslation())
        expected = (32 - at[0] / slope, 32 + at[1] / slope)
        found = seen_at(stage, (64, 64), frame=frame)
        np.testing.assert_allclose(found, expected, atol=0.12)


def test_a_camera_below_a_mirrored_parent_sees_a_mirror_image(mi: Any, tmp_path: Path) -> None:
    stage, camera, _ = marked(tmp_path)
    rig = UsdGeom.Xformable(stage.GetPrimAtPath("/World/Rig"))
    rig.GetOrderedXformOps()[0].Set((-1, 1, 1))
    stage.RemovePrim("/World/Card")
    mark(stage, camera)
    # What stands at (1.1, 0.7, -12) in the camera's own space stays right and above.
    focal = camera.GetFocalLengthAttr().Get() / camera.GetHorizontalApertureAttr().Get() * 80
    expected = (40 + focal * 1.1 / 12, 40 - focal * 0.7 / 12)
    np.testing.assert_allclose(seen_at(stage, (80, 80)), expected, atol=0.12)


@pytest.mark.parametrize(("up", "unit"), [("Z", 1.0), ("Y", 0.01), ("Z", 0.001)])
def test_axis_and_units_of_a_stage_move_no_pixel(
    mi: Any, tmp_path: Path, up: str, unit: float
) -> None:
    stage, camera, point = marked(tmp_path)
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    expected = expected_pixel(camera, point, (96, 64))
    np.testing.assert_allclose(seen_at(stage, (96, 64)), expected, atol=0.12)


@pytest.mark.parametrize(
    ("settings", "factor"),
    [
        ({"exposure": 1.5}, 2**1.5),
        ({"exposure": -3.0}, 1 / 8),
        ({"exposure:time": 0.25, "exposure:iso": 400.0}, 1.0),
        ({"exposure:fStop": 4.0, "exposure:time": 8.0, "exposure:responsivity": 0.5}, 0.25),
        ({"exposure": 1.0, "exposure:iso": 50.0}, 1.0),
    ],
)
def test_exposure_multiplies_the_picture(
    mi: Any, tmp_path: Path, settings: dict[str, float], factor: float
) -> None:
    stage = new_stage(tmp_path / "scene.usda")
    add_dome(stage)
    camera = add_camera(stage)
    for name, value in settings.items():
        camera.GetPrim().GetAttribute(name).Set(value)
    image, losses = picture(stage, 4, 4)
    assert image == pytest.approx(np.full((4, 4, 3), factor), rel=1e-5)
    assert losses == []


def test_an_exposure_beyond_numbers_is_a_loss(mi: Any, tmp_path: Path) -> None:
    stage = new_stage(tmp_path / "scene.usda")
    add_dome(stage)
    camera = add_camera(stage)
    camera.CreateExposureAttr(1e6)
    image, losses = picture(stage, 4, 4)
    assert image.max() == pytest.approx(1)
    assert losses == ["/World/Camera: exposure that multiplies radiance by inf (dropped)"]


def test_a_lens_opens_as_wide_as_its_stop_says(mi: Any, tmp_path: Path) -> None:
    stage = new_stage(tmp_path / "scene.usda")
    add_dome(stage)
    camera = add_camera(stage, fov=40)
    camera.CreateFStopAttr(1.0)
    camera.CreateFocusDistanceAttr(5.0)
    add_mesh(stage, points=((-99, -99, 0), (0, -99, 0), (0, 99, 0), (-99, 99, 0)), color=(0, 0, 0))
    row = picture(stage, 129, 256)[0][60:69, :, 0].mean(axis=0)
    # A point at 10 with the focus at 5 becomes a disk, on the plane in focus half as wide as the
    # lens, f / N; over its diameter an edge rises, most steeply by 2 / (π radius) in the middle.
    lens = camera.GetFocalLengthAttr().Get() / 10
    radius = lens / 4 / (2 * 5 * np.tan(np.radians(20))) * 129
    assert (row[67] - row[61]) / 6 == pytest.approx(2 / (np.pi * radius), rel=0.05)


def test_the_first_camera_is_used_and_another_on_request(mi: Any, tmp_path: Path) -> None:
    from weaveusd.render.translate import translate

    stage = new_stage(tmp_path / "scene.usda")
    add_mesh(stage)
    add_dome(stage)
    add_camera(stage, path="/World/A")
    add_camera(stage, path="/World/B")
    assert translate(stage, width=4, height=4).camera == "/World/A"
    assert translate(stage, width=4, height=4, camera="/World/B").camera == "/World/B"
    for wrong in ("/World/Card", "/World/C", "B"):
        with pytest.raises(StageError, match=f"{wrong} is no camera"):
            translate(stage, width=4, height=4, camera=wrong)


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_a_stage_without_camera_is_seen_whole(mi: Any, tmp_path: Path, up: str) -> None:
    stage = new_stage(tmp_path / "scene.usda", up)
    UsdGeom.Cube.Define(stage, "/World/Cube").CreateSizeAttr(3.0)
    image, losses = picture(stage, 32, 16)
    assert "/: stage has no camera: one that sees everything is used (approximated)" in losses
    dark = image.max(axis=2) < 0.9
    assert dark[16, 16]
    edge = np.concatenate((dark[0], dark[-1], dark[:, 0], dark[:, -1]))
    assert not edge.any()


def test_what_is_nearer_than_the_authored_clipping_is_cut_off(mi: Any, tmp_path: Path) -> None:
    stage = new_stage(tmp_path / "scene.usda")
    add_mesh(stage, color=(0, 0, 0))
    add_dome(stage)
    camera = add_camera(stage)
    assert picture(stage, 5, 4)[0][2, 2].max() < 0.02
    camera.CreateClippingRangeAttr(Gf.Vec2f(11, 100))
    assert picture(stage, 5, 4)[0][2, 2].min() > 0.99


def test_an_open_lens_blurs_what_is_out_of_focus(mi: Any, tmp_path: Path) -> None:
    def edge_width(focus: float) -> int:
        stage = new_stage(tmp_path / f"focus{focus}.usda")
        add_mesh(stage, color=(0, 0, 0))
        add_dome(stage)
        camera = add_camera(stage)
        camera.CreateFStopAttr(2.0)
        camera.CreateFocusDistanceAttr(focus)
        row = picture(stage, 65, 256)[0][32, :, 0]
        return int(((row > 0.1) & (row < 0.9)).sum())

    assert edge_width(10.0) < edge_width(4.0)


def test_a_camera_that_cannot_see_is_refused(mi: Any, tmp_path: Path) -> None:
    stage = new_stage(tmp_path / "scene.usda")
    add_mesh(stage)
    add_camera(stage).CreateFocalLengthAttr(0.0)
    with pytest.raises(StageError, match="focalLength is 0, expected more than 0"):
        picture(stage, 4, 1)
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/World/Camera"))
    camera.GetFocalLengthAttr().Set(50.0)
    camera.CreateHorizontalApertureAttr(float("nan"))
    with pytest.raises(StageError, match="horizontalAperture is 'nan', expected a finite number"):
        picture(stage, 4, 1)
    camera.GetHorizontalApertureAttr().Set(20.0)
    camera.AddScaleOp().Set((1, 1, 0))
    with pytest.raises(StageError, match="is flattened by its transform"):
        picture(stage, 4, 1)
