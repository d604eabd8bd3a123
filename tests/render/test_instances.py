"""Copies: instancers, instancers in instancers, native instances."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdLux, Vt

from tests.render.stages import (
    add_camera,
    add_mesh,
    bind,
    domed_stage,
    new_stage,
    picture,
    preview_material,
)

RED, GREEN = (0.8, 0.1, 0.1), (0.1, 0.8, 0.1)


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return domed_stage(tmp_path, fov=30)


def add_instancer(stage: Any, positions: Any, which: Any = None, path: str = "/World/Crowd") -> Any:
    """An instancer of the card below it, which is a square of side 2."""
    crowd = UsdGeom.PointInstancer.Define(stage, path)
    add_mesh(stage, f"{path}/Card", st=None)
    crowd.CreatePrototypesRel().SetTargets([f"{path}/Card"])
    crowd.CreateProtoIndicesAttr(list(which) if which is not None else [0] * len(positions))
    crowd.CreatePositionsAttr([Gf.Vec3f(*map(float, p)) for p in positions])
    return crowd


def corners(stage: Any, **more: Any) -> tuple[Any, list[str]]:
    """The vertices of the whole scene in stage units, sorted, and the losses."""
    import mitsuba

    from weaveusd.render.translate import translate

    made = translate(stage, width=4, height=4, **more)
    points = [
        np.array(mitsuba.traverse(shape)["vertex_positions"]).reshape(-1, 3)
        for shape in made.scene.shapes()
    ]
    found = np.concatenate(points)
    far = made.scene.sensors()[0].world_transform().translation()
    found = found * (10 / float(np.array(far).ravel()[2]))  # the camera stands at z = 10
    order = np.lexsort(found.round(4).T)
    return found[order], [str(loss) for loss in made.losses]


def by_usd(instancer: Any, frame: float = 0.0) -> Any:
    """The corners of the card's copies by USD's own matrices."""
    world = np.array(instancer.ComputeLocalToWorldTransform(frame))
    card = np.array(((-1, -1, 0, 1), (1, -1, 0, 1), (1, 1, 0, 1), (-1, 1, 0, 1)), float)
    matrices = instancer.ComputeInstanceTransformsAtTime(frame, frame)
    found = np.concatenate([(card @ np.array(m) @ world)[:, :3] for m in matrices])
    return found[np.lexsort(found.round(4).T)]


def test_copies_stand_where_usd_computes_them(mi: Any, stage: Any) -> None:
    rng = np.random.default_rng(7)
    crowd = add_instancer(stage, rng.normal(size=(6, 3)))
    crowd.CreateScalesAttr([Gf.Vec3f(*map(float, s)) for s in rng.uniform(-2, 2, (6, 3))])
    turns = [Gf.Quath(*map(float, q / np.linalg.norm(q))) for q in rng.normal(size=(6, 4))]
    crowd.CreateOrientationsAttr(turns)
    crowd.AddTranslateOp().Set((0.5, 1, -2))
    crowd.AddRotateXYZOp().Set((10, 20, 30))
    UsdGeom.Xformable(stage.GetPrimAtPath("/World/Crowd/Card")).AddRotateZOp().Set(40.0)
    crowd.CreateInvisibleIdsAttr([2])
    crowd.DeactivateId(4)
    found, losses = corners(stage)
    np.testing.assert_allclose(found, by_usd(crowd), atol=2e-3)
    assert len(found) == 16
    assert losses == []


def test_exact_orientations_win_over_half_ones(mi: Any, stage: Any) -> None:
    crowd = add_instancer(stage, [(0, 0, 0)])
    crowd.CreateOrientationsAttr([Gf.Quath(1, 0, 0, 0)])
    s = float(np.sqrt(0.5))
    crowd.CreateOrientationsfAttr([Gf.Quatf(s, 0, s, 0)])
    found, _ = corners(stage)
    assert np.ptp(found[:, 0]) == pytest.approx(0, abs=1e-4)
    assert np.ptp(found[:, 2]) == pytest.approx(2, abs=1e-4)


def test_copies_move_with_time(mi: Any, stage: Any) -> None:
    crowd = add_instancer(stage, [(0, 0, 0)])
    positions = crowd.GetPositionsAttr()
    positions.Clear()
    positions.Set([Gf.Vec3f(0, 0, 0)], 1)
    positions.Set([Gf.Vec3f(4, 0, 0)], 5)
    crowd.CreateInvisibleIdsAttr().Set(Vt.Int64Array([0]), 7)
    crowd.GetInvisibleIdsAttr().Set(Vt.Int64Array([]), 1)
    crowd.CreateVelocitiesAttr([Gf.Vec3f(9, 9, 9)])
    assert corners(stage)[0][:, 0].mean() == pytest.approx(0, abs=1e-4)
    found, losses = corners(stage, frame=4)
    assert found[:, 0].mean() == pytest.approx(3, abs=1e-4)
    assert losses == ["/World/Crowd: velocities are ignored between samples (approximated)"]


def test_instancers_lie_in_instancers(mi: Any, stage: Any) -> None:
    outer = UsdGeom.PointInstancer.Define(stage, "/World/Outer")
    inner = add_instancer(stage, [(0, 0, 0), (5, 0, 0)], path="/World/Outer/Inner")
    inner.AddTranslateOp().Set((0, 0, 1))
    outer.CreatePrototypesRel().SetTargets(["/World/Outer/Inner"])
    outer.CreateProtoIndicesAttr([0, 0, 0])
    outer.CreatePositionsAttr([Gf.Vec3f(0, y, 0) for y in (0, 5, 10)])
    found, losses = corners(stage)
    expected = [
        (x + dx, y + dy, 1) for x in (0, 5) for y in (0, 5, 10) for dx in (-1, 1) for dy in (-1, 1)
    ]
    np.testing.assert_allclose(found, sorted(expected, key=lambda p: p[::-1]), atol=1e-3)
    assert losses == []


def test_a_prototype_elsewhere_is_drawn_by_its_instancer_alone(mi: Any, stage: Any) -> None:
    stage.CreateClassPrim("/Library")
    add_mesh(stage, "/Library/Card", st=None)
    crowd = add_instancer(stage, [(3, 0, 0)])
    crowd.GetPrototypesRel().SetTargets(["/Library/Card"])
    found, losses = corners(stage)
    assert len(found) == 4
    assert losses == []


def test_an_instancer_in_itself_is_a_loss(mi: Any, stage: Any) -> None:
    crowd = add_instancer(stage, [(0, 0, 0), (5, 0, 0)], which=[0, 1])
    crowd.GetPrototypesRel().SetTargets(["/World/Crowd/Card", "/World"])
    found, losses = corners(stage)
    assert len(found) == 4
    assert losses == ["/World/Crowd: prototype /World holds the instancer (dropped)"]


def test_a_prototype_whose_name_begins_alike_is_another(mi: Any, stage: Any) -> None:
    crowd = add_instancer(stage, [(0, 0, 0)])
    UsdGeom.Scope.Define(stage, "/Wor")
    add_mesh(stage, "/Wor/Card", st=None)
    crowd.GetPrototypesRel().SetTargets(["/Wor"])
    assert corners(stage)[1] == []


def test_two_instancers_in_each_other_end(mi: Any, stage: Any) -> None:
    for one, other in (("A", "B"), ("B", "A")):
        crowd = add_instancer(stage, [(0, 0, 0), (1, 0, 0)], which=[0, 1], path=f"/World/{one}")
        crowd.GetPrototypesRel().SetTargets([f"/World/{one}/Card", f"/World/{other}"])
    _, losses = corners(stage)
    assert any("holds the instancer" in loss for loss in losses)


def test_what_is_wrong_with_an_instancer_is_told(mi: Any, stage: Any) -> None:
    add_mesh(stage, "/World/Sound")
    add_instancer(stage, [(0, 0, 0)] * 2, which=[0, 7], path="/World/A")
    add_instancer(stage, [(0, 0, 0)] * 2, which=[0, 0, 0], path="/World/B")
    add_instancer(stage, [(0, 0, 0)], path="/World/C").CreateScalesAttr([Gf.Vec3f(1, 0, 1)])
    add_instancer(stage, [(0, 0, 0)], path="/World/D").GetPrototypesRel().SetTargets(["/None"])
    _, losses = corners(stage)
    assert losses == [
        "/World/A: copies of none of the 1 prototypes (dropped)",
        "/World/B: instancer has 2 positions, expected 3 (dropped)",
        "/World/C: copies that are flattened by their scale (dropped)",
        "/World/D: prototype /None does not exist (dropped)",
    ]


def test_a_billion_copies_are_cut_and_told(mi: Any, stage: Any, monkeypatch: Any) -> None:
    from weaveusd.render import gather

    monkeypatch.setattr(gather, "MAX_COPIES", 1000)
    path = "/World"
    for level in range(6):
        path = f"{path}/L{level}"
        crowd = UsdGeom.PointInstancer.Define(stage, path)
        crowd.CreatePrototypesRel().SetTargets([f"{path}/L{level + 1}"])
        crowd.CreateProtoIndicesAttr([0] * 50)
        crowd.CreatePositionsAttr([Gf.Vec3f(k, 0, 0) for k in range(50)])
    add_mesh(stage, f"{path}/L6", st=None)
    found, losses = corners(stage)
    assert 0 < len(found) <= 4000
    assert any(loss.endswith("copies beyond the first 1000 (dropped)") for loss in losses)


def test_copies_can_have_colors_of_their_own(mi: Any, stage: Any) -> None:
    crowd = add_instancer(stage, [(-1.2, 0, 0), (1.2, 0, 0)])
    primvar = UsdGeom.PrimvarsAPI(crowd).CreatePrimvar(
        "displayColor", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex
    )
    primvar.Set([Gf.Vec3f(*RED), Gf.Vec3f(*GREEN)])
    image, losses = picture(stage, 16, 64)
    assert image[7:9, 3:6].mean(axis=(0, 1)) == pytest.approx(RED, abs=0.05)
    assert image[7:9, 10:13].mean(axis=(0, 1)) == pytest.approx(GREEN, abs=0.05)
    assert losses == []
    UsdGeom.PrimvarsAPI(crowd).CreatePrimvar(
        "size", Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex
    ).Set([1.0, 2.0])
    _, losses = picture(stage, 4, 1)
    assert losses == ["/World/Crowd: primvar size that differs from copy to copy (dropped)"]


def test_every_solid_and_curve_can_be_copied(mi: Any, stage: Any) -> None:
    crowd = add_instancer(stage, [(-1.2, 0, 0), (1.2, 0, 0)], which=[0, 1])
    UsdGeom.Sphere.Define(stage, "/World/Crowd/Group/Ball").CreateRadiusAttr(1.0)
    hair = UsdGeom.BasisCurves.Define(stage, "/World/Crowd/Hair")
    hair.CreateTypeAttr("linear")
    hair.CreatePointsAttr([Gf.Vec3f(0, -1, 0), Gf.Vec3f(0, 1, 0)])
    hair.CreateCurveVertexCountsAttr([2])
    hair.CreateWidthsAttr([1.0])
    crowd.GetPrototypesRel().SetTargets(["/World/Crowd/Group", "/World/Crowd/Hair"])
    image, losses = picture(stage, 32, 16)
    dark = image.max(axis=2) < 0.5
    pixel = 2 * 10 * np.tan(np.radians(15)) / 32
    assert dark[:, :16].sum() * pixel**2 == pytest.approx(np.pi, rel=0.12)
    assert dark[:, 16:].sum() * pixel**2 == pytest.approx(
        2 + np.pi / 4, rel=0.12
    )  # its ends are round
    assert losses == []


def test_lights_are_copied_too(mi: Any, tmp_path: Path) -> None:
    def brightness(copies: int) -> float:
        made = new_stage(tmp_path / f"lights{copies}.usda")
        add_camera(made, fov=5)
        add_mesh(made, color=(0.5, 0.5, 0.5))
        crowd = UsdGeom.PointInstancer.Define(made, "/World/Lamps")
        lamp = UsdLux.SphereLight.Define(made, "/World/Lamps/Lamp")
        lamp.CreateRadiusAttr(0.1)
        crowd.CreatePrototypesRel().SetTargets(["/World/Lamps/Lamp"])
        crowd.CreateProtoIndicesAttr([0] * copies)
        turn = np.arange(copies) * 2 * np.pi / copies
        places = zip(3 * np.cos(turn), 3 * np.sin(turn), strict=True)
        crowd.CreatePositionsAttr([Gf.Vec3f(float(x), float(y), 4) for x, y in places])
        return float(picture(made, 8, 64)[0].mean())

    assert brightness(4) == pytest.approx(4 * brightness(1), rel=0.05)


def native(stage: Any, count: int) -> None:
    """A master with one card and `count` instances of it in a row."""
    master = stage.CreateClassPrim("/Master")
    add_mesh(stage, "/Master/Card", color=RED, st=None)
    assert master.IsAbstract()
    for k in range(count):
        copy = stage.DefinePrim(f"/World/Copy{k}", "Xform")
        copy.GetInherits().AddInherit("/Master")
        copy.SetInstanceable(True)
        UsdGeom.Xformable(copy).AddTranslateOp().Set((3.0 * k, 0, 0))


def test_native_instances_stand_in_their_places_and_are_one_mesh(mi: Any, stage: Any) -> None:
    from weaveusd.render.translate import translate

    native(stage, 20)
    found, losses = corners(stage)
    assert len(translate(stage, width=4, height=4).scene.shapes()) == 1
    assert len(found) == 80
    assert sorted(set(found[:, 0].round(2))) == sorted(
        {3.0 * k + s for k in range(20) for s in (-1, 1)}
    )
    assert losses == []


def test_native_instances_keep_the_materials_bound_above_them(mi: Any, stage: Any) -> None:
    native(stage, 2)
    green = preview_material(stage, "/World/Green", diffuseColor=GREEN, ior=1.0)[0]
    bind(UsdGeom.Xform(stage.GetPrimAtPath("/World/Copy0")), green)
    stage.GetPrimAtPath("/World/Copy1").GetAttribute("xformOp:translate").Set((-3.0, 0, 0))
    image, losses = picture(stage, 32, 64)
    assert image[16, 16] == pytest.approx(GREEN, abs=0.06)
    assert image[16, 2] == pytest.approx(RED, abs=0.06)
    assert losses == []


def test_heavy_copies_are_instances_and_look_the_same(
    mi: Any, stage: Any, monkeypatch: Any
) -> None:
    from weaveusd.render import assembly
    from weaveusd.render.translate import translate

    crowd = add_instancer(stage, [(-1.2, 0, 0), (1.2, 0, 1)])
    crowd.CreateScalesAttr([Gf.Vec3f(1, 1, 1), Gf.Vec3f(-0.5, 1, 1)])
    flat, _ = picture(stage, 24, 64)
    monkeypatch.setattr(assembly, "MAX_PRIMITIVES", 1)
    shared, losses = picture(stage, 24, 64)
    np.testing.assert_allclose(flat, shared, atol=0.05)
    assert losses == []
    assert len(translate(stage, width=4, height=4).scene.shapes()) == 2
    monkeypatch.setattr(assembly, "MAX_INSTANCES", 1)
    _, losses = picture(stage, 4, 1)
    assert losses == ["/World/Crowd/Card: 1 of 2 copies of 2 primitives (dropped)"]


def test_ten_thousand_copies_cost_a_moment(mi: Any, stage: Any) -> None:
    places = np.random.default_rng(2).normal(size=(10_000, 3)) * 3
    add_instancer(stage, places)
    begin = time.process_time()
    picture(stage, 8, 4)
    assert time.process_time() - begin < 5
