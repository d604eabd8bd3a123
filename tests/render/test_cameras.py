from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, UsdGeom

from tests.render.stages import add_camera, add_dome, add_mesh, new_stage, picture
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


def marked(tmp_path: Path, **changes: Any) -> tuple[Any, Any, Any]:
    """A stage with one small black square that faces the camera, and where it should be."""
    stage = new_stage(tmp_path / "scene.usda")
    camera = camera_of(stage, **changes)
    view = camera.ComputeLocalToWorldTransform(0).RemoveScaleShear()
    point = view.Transform(Gf.Vec3d(1.1, 0.7, -12))
    half = 0.05
    corners = [
        view.Transform(Gf.Vec3d(1.1 + x * half, 0.7 + y * half, -12))
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    add_mesh(stage, points=corners, color=(0, 0, 0))
    return stage, camera, point


@pytest.mark.parametrize("size", [(96, 64), (64, 96), (80, 80)])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"horizontalAperture": 30.0, "verticalAperture": 10.0, "focalLength": 40.0},
        {"horizontalApertureOffset": 2.0, "verticalApertureOffset": -1.5},
        {"projection": "orthographic", "horizontalAperture": 60.0, "verticalAperture": 50.0},
    ],
)
def test_a_known_point_falls_on_its_pixel(
    mi: Any, tmp_path: Path, size: tuple[int, int], changes: dict[str, Any]
) -> None:
    from weaveusd.render.trace import trace
    from weaveusd.render.translate import translate

    stage, camera, point = marked(tmp_path, **changes)
    made = translate(stage, width=size[0], height=size[1])
    image = trace(made.scene, size, 256, seed=1)[..., 0]
    # The white dome fills the background; the card is one black square in it.
    weight = np.where(image < 0.999, 1 - image, 0)
    rows, columns = np.mgrid[: size[1], : size[0]] + 0.5
    found = np.array(((weight * columns).sum(), (weight * rows).sum())) / weight.sum()
    np.testing.assert_allclose(found, expected_pixel(camera, point, size), atol=0.12)


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
