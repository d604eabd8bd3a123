from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade, Vt

from tests.render.stages import (
    SQUARE,
    add_camera,
    add_dome,
    add_mesh,
    bind,
    domed_stage,
    middle,
    new_stage,
    picture,
    preview_material,
)
from weaveusd.errors import InputError

RED, GREEN = (0.8, 0.1, 0.1), (0.1, 0.8, 0.1)


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return domed_stage(tmp_path)


def shape_of(stage: Any) -> Any:
    """The only shape of a stage, as Mitsuba has it."""
    from weaveusd.render.translate import translate

    (shape,) = translate(stage, width=4, height=4).scene.shapes()
    return shape


def test_a_gray_card_shows_its_albedo(mi: Any, stage: Any) -> None:
    add_mesh(stage, color=(0.2, 0.5, 0.7))
    color, losses = middle(stage)
    assert color == pytest.approx([0.2, 0.5, 0.7], rel=0.02)
    assert losses == []


def test_what_has_no_color_is_gray(mi: Any, stage: Any) -> None:
    add_mesh(stage)
    assert middle(stage)[0] == pytest.approx([0.18] * 3, rel=0.02)


def test_every_color_of_a_face_is_shown(mi: Any, stage: Any) -> None:
    mesh = add_mesh(
        stage, points=((-1, -1, 0), (0, -1, 0), (1, -1, 0), (-1, 1, 0), (0, 1, 0), (1, 1, 0)),
        counts=(4, 4), indices=(0, 1, 4, 3, 1, 2, 5, 4), st=None,
    )  # fmt: skip
    primvar = mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform)
    primvar.Set([Gf.Vec3f(*RED), Gf.Vec3f(*GREEN)])
    image, _ = picture(stage, 16, 64)
    assert image[4:12, 3:6].mean(axis=(0, 1)) == pytest.approx(RED, rel=0.03)
    assert image[4:12, 10:13].mean(axis=(0, 1)) == pytest.approx(GREEN, rel=0.03)
    primvar.Set([Gf.Vec3f(*GREEN), Gf.Vec3f(*RED)])
    primvar.SetIndices(Vt.IntArray([1, 0]))
    image, _ = picture(stage, 16, 64)
    assert image[4:12, 3:6].mean(axis=(0, 1)) == pytest.approx(RED, rel=0.03)


def test_holes_stay_open(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, color=(0, 0, 0))
    assert middle(stage)[0].max() == 0
    mesh.CreateHoleIndicesAttr([0])
    color, losses = middle(stage)
    assert color == pytest.approx([1, 1, 1])
    assert losses == ["/World/Card: mesh has no face (dropped)"]


def test_a_mesh_without_normals_is_flat_and_with_normals_is_smooth(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage)
    assert not shape_of(stage).has_vertex_normals()
    tilted = Gf.Vec3f(0.6, 0, 0.8)
    mesh.CreateNormalsAttr([tilted] * 4)
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    normals = np.array(mi.traverse(shape_of(stage))["vertex_normals"]).reshape(-1, 3)
    np.testing.assert_allclose(normals, [[0.6, 0, 0.8]] * 4, atol=1e-6)
    # primvars:normals wins over normals, and a transform turns them as normals.
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "normals", Sdf.ValueTypeNames.Normal3fArray, UsdGeom.Tokens.constant
    )
    primvar.Set([Gf.Vec3f(0.6, 0.8, 0)])
    mesh.AddScaleOp().Set((2.0, 1.0, 1.0))
    normals = np.array(mi.traverse(shape_of(stage))["vertex_normals"]).reshape(-1, 3)
    expected = np.array((0.3, 0.8, 0)) / np.hypot(0.3, 0.8)
    np.testing.assert_allclose(normals, [expected] * 4, atol=1e-6)


@pytest.mark.parametrize("left_handed", [False, True])
@pytest.mark.parametrize("mirror", [False, True])
def test_the_front_stays_in_front(mi: Any, stage: Any, left_handed: bool, mirror: bool) -> None:
    order = (0, 3, 2, 1) if left_handed else (0, 1, 2, 3)
    mesh = add_mesh(stage, indices=order, color=RED)
    if left_handed:
        mesh.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
    if mirror:
        mesh.AddScaleOp().Set((-1.0, 1.0, 1.0))
    mesh.CreateDoubleSidedAttr(False)
    assert middle(stage)[0] == pytest.approx(RED, rel=0.03)
    mesh.AddRotateYOp().Set(180.0)
    assert middle(stage)[0].max() == 0  # the back of what is one-sided is black
    mesh.GetDoubleSidedAttr().Set(True)
    assert middle(stage)[0] == pytest.approx(RED, rel=0.03)


def test_a_reset_transform_stack_stands_alone(mi: Any, stage: Any) -> None:
    away = UsdGeom.Xform.Define(stage, "/World/Away")
    away.AddTranslateOp().Set((50, 0, 0))
    mesh = add_mesh(stage, "/World/Away/Card", color=RED)
    assert middle(stage)[0] == pytest.approx([1, 1, 1])
    mesh.SetResetXformStack(True)
    assert middle(stage)[0] == pytest.approx(RED, rel=0.03)


def test_hidden_prims_and_guides_are_not_drawn(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, "/World/Group/Card", color=RED)
    group = UsdGeom.Xform.Define(stage, "/World/Group")
    group.MakeInvisible()
    assert middle(stage)[0] == pytest.approx([1, 1, 1])
    group.MakeVisible()
    for purpose, drawn in (("guide", False), ("proxy", False), ("render", True)):
        mesh.CreatePurposeAttr(purpose)
        assert (middle(stage)[0][1] < 0.5) == drawn


def test_a_subset_binds_its_faces_and_the_rest_keeps_its_material(mi: Any, stage: Any) -> None:
    mesh = add_mesh(
        stage, points=((-1, -1, 0), (0, -1, 0), (1, -1, 0), (-1, 1, 0), (0, 1, 0), (1, 1, 0)),
        counts=(4, 4), indices=(0, 1, 4, 3, 1, 2, 5, 4), st=None,
    )  # fmt: skip
    red, _ = preview_material(stage, "/World/Red", diffuseColor=RED, ior=1.0)
    green, _ = preview_material(stage, "/World/Green", diffuseColor=GREEN, ior=1.0)
    bind(mesh, red)
    subset = UsdGeom.Subset.CreateGeomSubset(
        mesh, "Right", UsdGeom.Tokens.face, Vt.IntArray([1]), UsdShade.Tokens.materialBind
    )
    bind(subset, green)
    image, losses = picture(stage, 16, 64)
    assert image[4:12, 3:6].mean(axis=(0, 1)) == pytest.approx(RED, rel=0.03)
    assert image[4:12, 10:13].mean(axis=(0, 1)) == pytest.approx(GREEN, rel=0.03)
    assert losses == []


def test_materials_are_inherited(mi: Any, stage: Any) -> None:
    add_mesh(stage, "/World/Group/Card", color=RED)
    green, _ = preview_material(stage, "/World/Green", diffuseColor=GREEN, ior=1.0)
    bind(UsdGeom.Xform.Define(stage, "/World/Group"), green)
    assert middle(stage)[0] == pytest.approx(GREEN, rel=0.03)


def test_instances_are_drawn(mi: Any, stage: Any) -> None:
    add_mesh(stage, "/World/Master/Card", color=RED)
    stage.GetPrimAtPath("/World/Master").SetTypeName("Xform")
    UsdGeom.Imageable(stage.GetPrimAtPath("/World/Master")).MakeInvisible()
    copy = stage.DefinePrim("/World/Copy", "Xform")
    copy.GetReferences().AddInternalReference("/World/Master")
    copy.SetInstanceable(True)
    UsdGeom.Imageable(copy).MakeVisible()
    assert middle(stage)[0] == pytest.approx(RED, rel=0.03)


def test_analytic_shapes_stand_where_they_should(mi: Any, stage: Any) -> None:
    sphere = UsdGeom.Sphere.Define(stage, "/World/Ball")
    sphere.CreateRadiusAttr(0.5)
    sphere.AddTranslateOp().Set((-0.6, 0, 0))
    sphere.CreateDisplayColorAttr([Gf.Vec3f(0, 0, 0)])
    cube = UsdGeom.Cube.Define(stage, "/World/Box")
    cube.CreateSizeAttr(0.8)
    cube.AddTranslateOp().Set((0.6, 0, 0))
    cube.CreateDisplayColorAttr([Gf.Vec3f(0, 0, 0)])
    image, losses = picture(stage, 64, 16)
    dark = image.max(axis=2) < 0.5
    scale = 64 / (2 * 10 * np.tan(np.radians(7)))
    assert dark[:, :32].sum() == pytest.approx(np.pi * (0.5 * scale) ** 2, rel=0.05)
    assert dark[:, 32:].sum() == pytest.approx((0.8 * scale * 10 / 9.6) ** 2, rel=0.08)
    assert losses == []


@pytest.mark.parametrize(("axis", "turn"), [("Z", None), ("X", ("Y", -90)), ("Y", ("X", 90))])
def test_a_plane_faces_along_its_axis(mi: Any, stage: Any, axis: str, turn: Any) -> None:
    plane = UsdGeom.Plane.Define(stage, "/World/Plane")
    plane.CreateAxisAttr(axis)
    plane.CreateWidthAttr(1.0)
    plane.CreateLengthAttr(2.0)
    plane.CreateDoubleSidedAttr(False)
    plane.CreateDisplayColorAttr([Gf.Vec3f(*RED)])
    if turn:
        getattr(plane, f"AddRotate{turn[0]}Op")().Set(float(turn[1]))
    image, _ = picture(stage, 32, 16)
    seen = image[..., 1] < 0.5
    assert image[16, 16] == pytest.approx(RED, rel=0.05)
    assert seen.any(axis=1).sum() > 1.7 * seen.any(axis=0).sum()


def test_the_scale_of_a_stage_does_not_matter(mi: Any, tmp_path: Path) -> None:
    pictures = []
    for name, factor in (("metres", 0.01), ("microns", 10000.0)):
        stage = new_stage(tmp_path / f"{name}.usda")
        root = UsdGeom.Xform.Define(stage, "/World")
        root.AddScaleOp().Set((factor,) * 3)
        add_dome(stage)
        add_mesh(stage, color=RED)
        # A card that floats just above another one must not melt into it.
        add_mesh(stage, "/World/Near", points=[(0.5 * x, 0.5 * y, 1e-4) for x, y, _ in SQUARE],
                 color=GREEN)  # fmt: skip
        add_camera(stage, fov=14)
        pictures.append(picture(stage, 16, 32)[0])
    np.testing.assert_allclose(*pictures, atol=2e-3)
    assert pictures[0][8, 8] == pytest.approx(GREEN, rel=0.15)


def test_nothing_is_dropped_in_silence(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage)
    UsdGeom.NurbsPatch.Define(stage, "/World/Patch")
    UsdGeom.BasisCurves.Define(stage, "/World/Hair")
    UsdGeom.PointInstancer.Define(stage, "/World/Crowd")
    add_mesh(stage, "/World/Crowd/Prototype")
    add_mesh(stage, "/World/Broken", indices=(0, 1, 2, 9))
    add_mesh(stage, "/World/Flat").AddScaleOp().Set((1.0, 1.0, 0.0))
    material = UsdShade.Material.Define(stage, "/World/Empty")
    bind(mesh, material)
    _, losses = picture(stage, 4, 1)
    assert losses == [
        "/World/Empty: material has no surface that is understood (dropped)",
        "/World/Patch: NurbsPatch is not supported (dropped)",
        "/World/Hair: has 0 points, which is not what its curves ask for (dropped)",
        "/World/Crowd: instancer has no copies (dropped)",
        "/World/Broken: mesh names a point outside its 4 points (dropped)",
        "/World/Flat: shape is flattened by its transform (dropped)",
    ]


def test_values_that_are_no_numbers_are_reported(mi: Any, stage: Any) -> None:
    add_mesh(stage, color=(float("nan"), 0, 0))
    add_mesh(stage, "/World/Far", points=((0, 0, float("inf")), (1, 0, 0), (0, 1, 0), (1, 1, 0)))
    stage.DefinePrim("/World/Odd", "MadeUpType")
    _, losses = picture(stage, 4, 1)
    assert losses == [
        "/World/Card: primvar displayColor holds a value that is no finite number (dropped)",
        "/World/Far: mesh points holds a value that is no finite number (dropped)",
        "/World/Odd: type MadeUpType is unknown (dropped)",
    ]


def test_a_moving_stage_is_shown_at_its_first_moment(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, color=RED)
    move = mesh.AddTranslateOp()
    move.Set((0, 0, 0), 1)
    move.Set((50, 0, 0), 2)
    color = mesh.GetDisplayColorAttr()
    color.Clear()
    color.Set([Gf.Vec3f(*GREEN)], 1)
    assert middle(stage)[0] == pytest.approx(GREEN, rel=0.03)


def test_missing_references_are_reported(mi: Any, stage: Any) -> None:
    stage.DefinePrim("/World/Gone").GetReferences().AddReference("./gone.usda")
    _, losses = picture(stage, 4, 1)
    assert any("gone.usda" in loss and loss.endswith("(dropped)") for loss in losses)


def test_an_unknown_context_is_refused(mi: Any, stage: Any) -> None:
    with pytest.raises(InputError, match="unknown render context 'arnold': expected mitsuba, mtlx"):
        picture(stage, 4, 1, context="arnold")
