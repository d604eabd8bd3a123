"""Meshes as the renderer has them: limits, subsets, normals and coordinates."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, Vt

from tests.render.stages import (
    add_mesh,
    add_texture,
    bind,
    domed_stage,
    picture,
    preview_material,
    write_image,
)

RED, GREEN, BLUE = (0.8, 0.1, 0.1), (0.1, 0.8, 0.1), (0.1, 0.1, 0.8)
CUBE = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
QUADS = (0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3)
STRIP = [(x, y, 0) for y in (-1, 1) for x in (-1, 0, 1)]
STRIP_FACES = (0, 1, 4, 3, 1, 2, 5, 4)


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return domed_stage(tmp_path)


def arrays(stage: Any) -> tuple[Any, Any, Any, list[str]]:
    """Points in stage units, normals, faces and losses of the only shape."""
    import mitsuba

    from weaveusd.render.translate import translate

    made = translate(stage, width=4, height=4)
    (shape,) = made.scene.shapes()
    found = mitsuba.traverse(shape)
    eye = np.array(made.scene.sensors()[0].world_transform().translation()).ravel()
    points = np.array(found["vertex_positions"]).reshape(-1, 3) * (10 / eye[2])
    normals = np.array(found["vertex_normals"]).reshape(-1, 3)
    faces = np.array(found["faces"]).reshape(-1, 3)
    return points, normals, faces, [str(loss) for loss in made.losses]


def add_cube(stage: Any, scheme: str = "catmullClark") -> Any:
    mesh = add_mesh(stage, "/World/Cube", CUBE, (4,) * 6, QUADS, st=None)
    mesh.GetSubdivisionSchemeAttr().Set(scheme)
    return mesh


def out_of(points: Any, faces: Any) -> Any:
    a, b, c = np.moveaxis(points[faces], 1, 0)
    return np.einsum("fk,fk->f", np.cross(b - a, c - a), a + b + c)


def test_a_subdivided_cube_lies_on_its_limit(mi: Any, stage: Any) -> None:
    add_cube(stage)
    points, normals, faces, losses = arrays(stage)
    assert losses == []
    assert len(faces) == 2 * 6 * 4**6
    assert np.abs(points).max(axis=0) == pytest.approx([0.8395061728] * 3, abs=1e-4)
    corner = np.abs(np.abs(points) - 0.5).max(axis=1) < 1e-4
    assert corner.sum() == 8
    np.testing.assert_allclose(normals[corner] * np.sqrt(3), np.sign(points[corner]), atol=1e-3)
    assert (out_of(points, faces) > 0).all()
    assert (np.einsum("vk,vk->v", normals, points) > 0).all()


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("left_handed", [False, True])
@pytest.mark.parametrize("scheme", ["catmullClark", "bilinear"])
def test_the_outside_of_a_subdivided_mesh_stays_outside(
    mi: Any, stage: Any, scheme: str, left_handed: bool, mirror: bool
) -> None:
    mesh = add_cube(stage, scheme)
    if left_handed:
        mesh.CreateOrientationAttr(UsdGeom.Tokens.leftHanded)
        mesh.GetFaceVertexIndicesAttr().Set(
            Vt.IntArray(np.array(QUADS).reshape(-1, 4)[:, ::-1].ravel().tolist())
        )
    if mirror:
        mesh.AddScaleOp().Set((-1, 1, 2))
    points, normals, faces, _ = arrays(stage)
    assert (out_of(points, faces) > 0).all()
    assert (np.einsum("vk,vk->v", normals, points) > 0).mean() > 0.99


def test_creases_of_a_stage_keep_a_cube_a_cube(mi: Any, stage: Any) -> None:
    mesh = add_cube(stage)
    rings = (0, 1, 3, 2, 0, 4, 5, 7, 6, 4)
    mesh.CreateCreaseIndicesAttr([*rings, 1, 5, 3, 7, 2, 6])
    mesh.CreateCreaseLengthsAttr([10, 2, 2, 2])
    mesh.CreateCreaseSharpnessesAttr([10.0, 10.0, 10.0, 10.0])
    points, normals, _, losses = arrays(stage)
    assert losses == []
    np.testing.assert_allclose(np.abs(points).max(axis=1), 1, atol=1e-4)
    np.testing.assert_allclose(np.abs(normals).max(axis=1), 1, atol=1e-4)


def closed_spline_area() -> float:
    """The area inside a closed cubic B-spline around the square of side 2, by the shoelace."""
    t = np.linspace(0, 1, 2000)[:-1, None]
    weights = ((1 - t) ** 3, 3 * t**3 - 6 * t * t + 4, -3 * t**3 + 3 * t * t + 3 * t + 1, t**3)
    square = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1)))
    pieces = [sum(w / 6 * square[(k + n) % 4] for n, w in enumerate(weights)) for k in range(4)]
    x, y = np.concatenate(pieces).T
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize("rule", ["edgeAndCorner", "edgeOnly", "none"])
def test_borders_are_drawn_as_they_are_told(mi: Any, stage: Any, rule: str) -> None:
    mesh = add_mesh(stage, st=None, color=(0, 0, 0))
    mesh.GetSubdivisionSchemeAttr().Set("catmullClark")
    mesh.CreateInterpolateBoundaryAttr(rule)
    image, losses = picture(stage, 64, 64)
    pixel = 2 * 10 * np.tan(np.radians(7)) / 64
    area = (1 - image.mean(axis=2)).sum() * pixel**2
    expected = {"edgeAndCorner": 4.0, "edgeOnly": closed_spline_area(), "none": 0.0}[rule]
    assert area == pytest.approx(expected, abs=0.02)
    assert losses == (["/World/Card: mesh has no face (dropped)"] if rule == "none" else [])


def test_hostile_creases_and_corners_are_left_out_with_a_loss(mi: Any, stage: Any) -> None:
    mesh = add_cube(stage)
    mesh.CreateCreaseIndicesAttr([0, 99])
    mesh.CreateCreaseLengthsAttr([2])
    mesh.CreateCreaseSharpnessesAttr([5.0])
    mesh.CreateCornerIndicesAttr([0, 1])
    mesh.CreateCornerSharpnessesAttr([float("nan"), 1.0])
    mesh.CreateFaceVaryingLinearInterpolationAttr("sideways")
    points, _, _, losses = arrays(stage)
    assert np.abs(points).max() < 0.84
    assert losses == [
        "/World/Cube: creases name a point outside the 8 points (dropped)",
        "/World/Cube: cornerSharpnesses holds a value that is no finite number (dropped)",
        "/World/Cube: faceVaryingLinearInterpolation sideways is unknown (approximated)",
    ]


def test_what_cannot_be_subdivided_is_shown_as_its_cage(mi: Any, stage: Any) -> None:
    add_mesh(stage).GetSubdivisionSchemeAttr().Set("loop")
    _, losses = picture(stage, 4, 1)
    assert losses == [
        "/World/Card: is shown as its control cage: loop subdivision wants triangles (approximated)"
    ]


def test_colors_follow_the_subdivided_surface(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, points=STRIP, counts=(4, 4), indices=STRIP_FACES, st=None)
    mesh.GetSubdivisionSchemeAttr().Set("catmullClark")
    mesh.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform).Set([Gf.Vec3f(*RED), Gf.Vec3f(*GREEN)])
    image, losses = picture(stage, 16, 64)
    assert image[4:12, 3:6].mean(axis=(0, 1)) == pytest.approx(RED, rel=0.05)
    assert image[4:12, 10:13].mean(axis=(0, 1)) == pytest.approx(GREEN, rel=0.05)
    assert losses == []


def test_subsets_that_share_faces_and_name_none_are_losses(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, points=STRIP, counts=(4, 4), indices=STRIP_FACES, st=None)
    for name, color, faces in (("A", RED, [0]), ("B", GREEN, [0, 1, 7, -3]), ("C", BLUE, [])):
        material, _ = preview_material(stage, f"/World/{name}", diffuseColor=color, ior=1.0)
        subset = UsdGeom.Subset.CreateGeomSubset(
            mesh, name, UsdGeom.Tokens.face, Vt.IntArray(faces), UsdShade.Tokens.materialBind
        )
        bind(subset, material)
    image, losses = picture(stage, 16, 64)
    assert image[4:12, 3:6].mean(axis=(0, 1)) == pytest.approx(RED, rel=0.05)
    assert image[4:12, 10:13].mean(axis=(0, 1)) == pytest.approx(GREEN, rel=0.05)
    assert losses == [
        "/World/Card/B: some indices name no face of the mesh (dropped)",
        "/World/Card/B: shares faces with an earlier subset (approximated)",
    ]


def test_subsets_of_a_subdivided_mesh_are_faces_of_its_cage(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, points=STRIP, counts=(4, 4), indices=STRIP_FACES, st=None, color=RED)
    mesh.GetSubdivisionSchemeAttr().Set("catmullClark")
    green, _ = preview_material(stage, "/World/Green", diffuseColor=GREEN, ior=1.0)
    subset = UsdGeom.Subset.CreateGeomSubset(
        mesh, "Right", UsdGeom.Tokens.face, Vt.IntArray([1]), UsdShade.Tokens.materialBind
    )
    bind(subset, green)
    image, _ = picture(stage, 16, 64)
    assert image[4:12, 3:6].mean(axis=(0, 1)) == pytest.approx(RED, rel=0.05)
    assert image[4:12, 10:13].mean(axis=(0, 1)) == pytest.approx(GREEN, rel=0.05)


NORMALS = {
    "constant": [(0.6, 0, 0.8)],
    "uniform": [(0.6, 0, 0.8), (-0.6, 0, 0.8)],
    "vertex": [(0.6, 0, 0.8), (0, 0, 1), (-0.6, 0, 0.8)] * 2,
    "varying": [(0.6, 0, 0.8), (0, 0, 1), (-0.6, 0, 0.8)] * 2,
    "faceVarying": [(0.6, 0, 0.8)] * 4 + [(-0.6, 0, 0.8)] * 4,
}


@pytest.mark.parametrize("indexed", [False, True])
@pytest.mark.parametrize("how", list(NORMALS))
def test_normals_of_every_interpolation_shade_where_they_stand(
    mi: Any, stage: Any, how: str, indexed: bool
) -> None:
    from weaveusd.render.translate import translate

    mesh = add_mesh(stage, points=STRIP, counts=(4, 4), indices=STRIP_FACES, st=None)
    given = NORMALS[how]
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "normals", Sdf.ValueTypeNames.Normal3fArray, how
    )
    distinct = sorted(set(given)) if indexed else given
    primvar.Set([Gf.Vec3f(*n) for n in distinct])
    if indexed:
        primvar.SetIndices(Vt.IntArray([distinct.index(n) for n in given]))
    scene = translate(stage, width=4, height=4).scene
    unit = float(np.array(scene.sensors()[0].world_transform().translation()).ravel()[2]) / 10
    for x in (-0.9, -0.5, 0.5, 0.9):
        ray = mi.Ray3f(mi.Point3f(x * unit, 0.2 * unit, 5 * unit), mi.Vector3f(0, 0, -1))
        found = np.array(scene.ray_intersect(ray).sh_frame.n).ravel()
        side = 0.6 if how == "constant" else -0.6 * np.sign(x)
        expected = np.array((side, 0, 0.8))
        if how in ("vertex", "varying"):
            expected = np.array((0, 0, 1)) * (1 - abs(x)) + expected * abs(x)
        np.testing.assert_allclose(found, expected / np.linalg.norm(expected), atol=1e-4)


def test_a_mirrored_mesh_is_shaded_as_its_mirror_image(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, st=None)
    mesh.CreateNormalsAttr([Gf.Vec3f(0.6, 0, 0.8)] * 4)
    mesh.SetNormalsInterpolation("vertex")
    mesh.AddScaleOp().Set((-1, 1, 1))
    _, normals, _, _ = arrays(stage)
    np.testing.assert_allclose(normals, [(-0.6, 0, 0.8)] * 4, atol=1e-6)


def test_opacity_of_a_vertex_is_a_mask(mi: Any, stage: Any) -> None:
    mesh = add_mesh(stage, st=None, color=(0, 0, 0))
    mesh.CreateDisplayOpacityPrimvar(UsdGeom.Tokens.vertex).Set([0.0, 1.0, 1.0, 0.0])
    image, losses = picture(stage, 32, 256)
    row = image[16, :, 0]
    x = (np.arange(32) + 0.5 - 16) / 16 * 10 * np.tan(np.radians(7))
    inside = np.abs(x) < 0.95
    np.testing.assert_allclose(row[inside], 1 - (x[inside] + 1) / 2, atol=0.12)
    assert losses == []


ST = {
    "constant": ([0], [0] * 8),
    "uniform": ([1, 2], [1] * 4 + [2] * 4),
    "vertex": ([0, 1, 2, 3, 4, 5], STRIP_FACES),
    "varying": ([0, 1, 2, 3, 4, 5], STRIP_FACES),
    "faceVarying": (list(range(8)), list(range(8))),
}


@pytest.mark.parametrize("scheme", ["none", "bilinear"])
@pytest.mark.parametrize("indexed", [False, True])
@pytest.mark.parametrize("how", list(ST))
def test_coordinates_of_every_interpolation_reach_their_corners(
    stage: Any, how: str, indexed: bool, scheme: str
) -> None:
    from weaveusd.render.meshes import corner_primvar, read_surface
    from weaveusd.render.model import Losses

    mesh = add_mesh(stage, points=STRIP, counts=(4, 4), indices=STRIP_FACES, st=None)
    mesh.GetSubdivisionSchemeAttr().Set(scheme)
    numbers, expected = ST[how]
    values = [Gf.Vec2f(k, -k) for k in numbers]
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, how)
    primvar.Set(values[::-1] if indexed else values)
    if indexed:
        primvar.SetIndices(Vt.IntArray(list(range(len(values)))[::-1]))
    losses, now = Losses(), Usd.TimeCode.Default()
    surface = read_surface(mesh.GetPrim(), now, losses)
    found = corner_primvar(mesh.GetPrim(), "st", 2, surface, now, losses)
    assert losses.as_tuple() == ()
    assert found is not None
    if scheme == "bilinear":  # the first corners of the refined faces are those of the cage
        pieces = len(found) // 8
        found = found[::pieces] if how in ("constant", "uniform") else cage_corners(surface, found)
    np.testing.assert_allclose(found[:, 0], expected)
    np.testing.assert_allclose(found[:, 1], -np.array(expected))


def cage_corners(surface: Any, values: Any) -> Any:
    """The values at the corners of the cage: those of the pieces that lie at its points."""
    face = np.zeros(len(values), int)
    face[surface.triangles.corners.ravel()] = np.repeat(surface.triangles.face, 3)
    at = {}
    for corner, (vertex, owner) in enumerate(zip(surface.indices, face, strict=True)):
        at[vertex, owner] = values[corner]
    return np.array([at[v, k // 4] for k, v in enumerate(STRIP_FACES)])


@pytest.mark.parametrize("scheme", ["none", "catmullClark"])
def test_primvars_that_make_no_sense_are_losses(mi: Any, stage: Any, scheme: str) -> None:
    mesh = add_mesh(stage, st=None)
    mesh.GetSubdivisionSchemeAttr().Set(scheme)
    bind(mesh, textured(stage))
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    primvar.Set([Gf.Vec2f(0, 0)] * 4)
    primvar.GetAttr().SetMetadata("interpolation", "sideways")
    missing = "/World/Card: has no texture coordinates st: 0 is used (approximated)"
    assert picture(stage, 4, 1)[1] == [
        "/World/Card: primvar st: interpolation sideways is unknown (dropped)", missing
    ]  # fmt: skip
    primvar.GetAttr().SetMetadata("interpolation", "vertex")
    primvar.SetIndices(Vt.IntArray([0, 1, 2, 99]))
    losses = picture(stage, 4, 1)[1]
    assert any("st" in loss for loss in losses)
    primvar.BlockIndices()
    primvar.Set([Gf.Vec2f(0, 0)] * 3)
    assert picture(stage, 4, 1)[1] == [
        "/World/Card: primvar st: has 3 vertex values, expected 4 (dropped)", missing
    ]  # fmt: skip


def textured(stage: Any) -> Any:
    """A material whose color follows st."""
    file = write_image(Path(stage.GetRootLayer().realPath).parent / "dot.exr", np.ones((2, 2, 3)))
    material, shader = preview_material(stage)
    add_texture(stage, shader, "diffuseColor", file.name)
    return material
