"""Solids, points and curves, seen and measured."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, UsdGeom, Vt

import weaveusd
from tests.render.stages import add_camera, add_dome, bind, new_stage, picture, preview_material

BLACK = [Gf.Vec3f(0, 0, 0)]


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    """A white dome and an orthographic camera that sees 4 by 4 units on its 64 by 64 pixels."""
    made = new_stage(tmp_path / "scene.usda")
    add_dome(made)
    camera = add_camera(made)
    camera.CreateProjectionAttr(UsdGeom.Tokens.orthographic)
    camera.CreateHorizontalApertureAttr(40.0)
    camera.CreateVerticalApertureAttr(40.0)
    return made


def covered(stage: Any, spp: int = 64) -> tuple[Any, Any]:
    """The share of each of 64 by 64 pixels that black shapes cover, row 0 at y = 2; losses."""
    image, losses = picture(stage, 64, spp)
    return 1 - image.mean(axis=2), losses


def area(stage: Any) -> float:
    """The area that black shapes cover, in square units."""
    return float(covered(stage)[0].sum() / 256)


def black(prim: Any) -> Any:
    prim.CreateDisplayColorAttr(BLACK)
    return prim


ANALYTIC = {
    "Sphere": ({"radius": 1.5}, np.pi * 1.5**2),
    "Cube": ({"size": 2.0}, 4.0),
    "Cylinder": ({"radius": 0.5, "height": 3.0}, 3.0),
    "Cone": ({"radius": 1.0, "height": 3.0}, 3.0),
    "Capsule": ({"radius": 0.5, "height": 2.0}, 2 + np.pi / 4),
    "Plane": ({"width": 1.0, "length": 3.0}, 0.0),
    "Cylinder_1": ({"radiusTop": 0.25, "radiusBottom": 1.0, "height": 3.0}, 3.75),
    "Capsule_1": ({"radiusTop": 0.5, "radiusBottom": 0.5, "height": 2.0}, 2 + np.pi / 4),
}


@pytest.mark.parametrize("axis", ["X", "Y"])
@pytest.mark.parametrize("kind", list(ANALYTIC))
def test_a_solid_covers_what_its_numbers_say(mi: Any, stage: Any, kind: str, axis: str) -> None:
    numbers, expected = ANALYTIC[kind]
    prim = stage.DefinePrim("/World/Solid", kind)
    for name, value in numbers.items():
        prim.GetAttribute(name).Set(value)
    if prim.GetAttribute("axis"):
        prim.GetAttribute("axis").Set(axis)
    black(UsdGeom.Gprim(prim))
    share, losses = covered(stage)
    assert share.sum() / 256 == pytest.approx(expected, rel=0.01, abs=0.01)
    assert losses == []
    # A solid about X is wider than high, about Y higher than wide.
    columns, rows = (share > 0.5).any(axis=0).sum(), (share > 0.5).any(axis=1).sum()
    if kind not in ("Sphere", "Cube", "Plane"):
        assert (columns > rows) == (axis == "X")


def test_a_cone_points_along_its_axis(mi: Any, stage: Any) -> None:
    cone = black(UsdGeom.Cone.Define(stage, "/World/Cone"))
    cone.CreateAxisAttr("Y")
    share, _ = covered(stage)
    assert share[40].sum() > 2 * share[24].sum()


def test_solids_have_their_lids(mi: Any, stage: Any) -> None:
    for number, kind in enumerate((UsdGeom.Cylinder, UsdGeom.Cone)):
        solid = black(kind.Define(stage, f"/World/Solid{number}"))
        solid.CreateAxisAttr("Z")
        solid.CreateRadiusAttr(0.75)
        solid.AddTranslateOp().Set((2.0 * number - 1, 0, 0))
        solid.AddRotateXOp().Set(180.0)  # the cone shows its floor
    assert area(stage) == pytest.approx(2 * np.pi * 0.75**2, rel=0.01)


@pytest.mark.parametrize("matrix", [
    ((2, 0, 0), (0, 0.5, 0), (0, 0, 1)), ((1, 0.8, 0), (0, 1, 0), (0, 0, -1)),
])  # fmt: skip
def test_a_sphere_can_be_stretched_sheared_and_mirrored(mi: Any, stage: Any, matrix: Any) -> None:
    ball = black(UsdGeom.Sphere.Define(stage, "/World/Ball"))
    ball.CreateRadiusAttr(0.7)
    full = np.eye(4)
    full[:3, :3] = matrix
    ball.AddTransformOp().Set(Gf.Matrix4d(*full.ravel().tolist()))
    # The outline of the image of a ball under M is an ellipse of area π det(m), m mᵀ = (M Mᵀ)_xy.
    flat = (full[:3, :3].T @ full[:3, :3])[:2, :2]
    assert area(stage) == pytest.approx(np.pi * 0.49 * np.sqrt(np.linalg.det(flat)), rel=0.01)


def test_a_stretched_sphere_is_lit_by_its_true_normals(mi: Any, stage: Any) -> None:
    from weaveusd.render.translate import translate

    ball = UsdGeom.Sphere.Define(stage, "/World/Ball")
    ball.AddTransformOp().Set(Gf.Matrix4d(1, 0.3, 0, 0, -0.2, 0.5, 0.1, 0, 0, 0, 2, 0, 0, 0, 0, 1))
    scene = translate(stage, width=4, height=4).scene
    ray = mi.Ray3f(mi.Point3f(1.0, 1.0, 2000.0), mi.Vector3f(0, 0, -1))
    found = scene.ray_intersect(ray)
    linear = np.array(((1, 0.3, 0), (-0.2, 0.5, 0.1), (0, 0, 2))).T
    local = np.linalg.solve(linear, np.array(found.p).ravel())
    normal = np.linalg.inv(linear).T @ local
    normal /= np.linalg.norm(normal)
    np.testing.assert_allclose(np.array(found.n).ravel(), normal, atol=1e-4)


@pytest.mark.parametrize("count", [3, 60])
def test_points_are_spheres_of_their_widths(mi: Any, stage: Any, count: int) -> None:
    cloud = black(UsdGeom.Points.Define(stage, "/World/Cloud"))
    side = int(np.ceil(np.sqrt(count)))
    places = [
        ((k % side + 0.5) / side * 4 - 2, (k // side + 0.5) / side * 4 - 2, 0) for k in range(count)
    ]
    widths = 2 / side * (0.5 + 0.5 * np.arange(count) / count)
    cloud.CreatePointsAttr([Gf.Vec3f(*p) for p in places])
    cloud.CreateWidthsAttr(Vt.FloatArray(widths.tolist()))
    assert area(stage) == pytest.approx(np.pi / 4 * np.sum(widths**2), rel=0.01)


def test_points_have_their_colors(mi: Any, stage: Any) -> None:
    cloud = UsdGeom.Points.Define(stage, "/World/Cloud")
    cloud.CreatePointsAttr([Gf.Vec3f(-1, 0, 0), Gf.Vec3f(1, 0, 0)])
    cloud.CreateWidthsAttr([1.6, 1.6])
    colors = cloud.CreateDisplayColorPrimvar(UsdGeom.Tokens.vertex)
    colors.Set([Gf.Vec3f(0.8, 0, 0), Gf.Vec3f(0, 0.8, 0)])
    image, losses = picture(stage, 64, 16)
    assert image[32, 16] == pytest.approx([0.8, 0, 0], abs=0.1)
    assert image[32, 48] == pytest.approx([0, 0.8, 0], abs=0.1)
    assert losses == []


def strand(stage: Any, points: Any, **attributes: Any) -> Any:
    curves = black(UsdGeom.BasisCurves.Define(stage, "/World/Hair"))
    curves.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in points])
    attributes = {"curveVertexCounts": [len(points)], **attributes}
    for name, value in attributes.items():
        curves.GetPrim().GetAttribute(name).Set(value)
    return curves


def reference(basis: str, points: Any, wrap: str) -> Any:
    """Places along a curve of USD, from the definition of its basis."""
    if basis == "linear":
        ends = np.array([*points, *points[:1]] if wrap == "periodic" else points, float)
        t = np.linspace(0, 1, 50)[:, None]
        return np.concatenate([a + (b - a) * t for a, b in pairwise(ends)])
    p = np.array(points, float)
    if wrap == "pinned" and basis != "bezier":
        p = np.concatenate(([2 * p[0] - p[1]], p, [2 * p[-1] - p[-2]]))
    step = 3 if basis == "bezier" else 1
    n = len(p)
    if wrap == "periodic":
        starts, p = range(0, n, step), np.concatenate((p, p[:3]))
    else:
        starts = range(0, n - 3, step)
    t = np.linspace(0, 1, 200)[:, None]
    weights = {
        "bezier": ((1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3),
        "bspline": ((1 - t) ** 3 / 6, (3 * t**3 - 6 * t * t + 4) / 6,
                    (-3 * t**3 + 3 * t * t + 3 * t + 1) / 6, t**3 / 6),
        "catmullRom": ((-(t**3) + 2 * t * t - t) / 2, (3 * t**3 - 5 * t * t + 2) / 2,
                       (-3 * t**3 + 4 * t * t + t) / 2, (t**3 - t * t) / 2),
    }[basis]  # fmt: skip
    return np.concatenate([sum(w * p[s + k] for k, w in enumerate(weights)) for s in starts])


ZIGZAG = (
    (-1.6, -1, 0),
    (-1, 1.2, 0),
    (-0.2, -1.3, 0),
    (0.3, 1, 0),
    (0.9, -0.8, 0),
    (1.6, 0.9, 0),
    (1.2, 1.6, 0),
)


def crossed(along: Any) -> Any:
    """Return which of 64 by 64 pixels of the stage's camera hold one of the points (N, 2)."""
    seen = np.zeros((64, 64), bool)
    seen[((2 - along[:, 1]) * 16).astype(int), ((along[:, 0] + 2) * 16).astype(int)] = True
    return seen


@pytest.mark.parametrize("wrap", ["nonperiodic", "periodic", "pinned"])
@pytest.mark.parametrize("basis", ["linear", "bezier", "bspline", "catmullRom"])
def test_a_curve_runs_where_its_basis_leads(mi: Any, stage: Any, basis: str, wrap: str) -> None:
    points = ZIGZAG[:6] if (basis, wrap) == ("bezier", "periodic") else ZIGZAG
    kind = {"type": "linear"} if basis == "linear" else {"type": "cubic", "basis": basis}
    strand(stage, points, widths=[0.06], wrap=wrap, **kind)
    share, losses = covered(stage)
    assert losses == []
    along = reference(basis, points, wrap)[:, :2]
    seen = crossed(along)
    # A pixel whose corner it touches is covered 0.48 deep, half a width, unless the curve ends
    # there: 10 whole cells at least of the 8 by 8 that have a sample each.
    from_ends = np.linalg.norm(along[:, None] - along[[0, -1]], axis=2).min(axis=1)
    assert share[crossed(along[from_ends > 0.04])].min() >= 10 / 64
    near = seen.copy()
    for dr in (-1, 0, 1):
        for dc in (-1, 0, 1):
            near |= np.roll(seen, (dr, dc), (0, 1))
    assert share[~near].max() < 1e-6  # and nothing where it does not run


@pytest.mark.parametrize(
    ("how", "widths", "expected"),
    [
        ("constant", [0.5], (0.5, 0.5)),
        ("uniform", [0.5], (0.5, 0.5)),
        ("varying", [0.2, 0.8], (0.35, 0.65)),
        ("vertex", [0.2, 0.4, 0.6, 0.8], (0.35, 0.65)),
    ],
)
def test_a_curve_is_as_wide_as_it_says(
    mi: Any, stage: Any, how: str, widths: Any, expected: Any
) -> None:
    straight = [(x, 0, 0) for x in np.linspace(-2, 2, 4)]
    curves = strand(stage, straight, type="cubic", basis="bezier", widths=widths)
    curves.SetWidthsInterpolation(how)
    share, losses = covered(stage)
    assert losses == []
    for column, width in zip((16, 48), expected, strict=True):
        seen = share[:, column - 1 : column + 1].sum() / 2 / 16
        assert seen == pytest.approx(width, abs=0.02)


def test_curves_of_many_colors_have_them(mi: Any, stage: Any) -> None:
    points = [(-2, -1, 0), (2, -1, 0), (-2, 1, 0), (2, 1, 0)]
    curves = strand(stage, points, type="linear", widths=[0.5], curveVertexCounts=[2, 2])
    primvar = curves.CreateDisplayColorPrimvar(UsdGeom.Tokens.uniform)
    primvar.Set([Gf.Vec3f(0.8, 0, 0), Gf.Vec3f(0, 0.8, 0)])
    image, _ = picture(stage, 64, 64)
    assert image[48, 32].argmax() == 0
    assert image[16, 32].argmax() == 1
    assert image[16, 32].min() < 0.1


def test_broken_curves_and_points_say_what_is_wrong(mi: Any, stage: Any) -> None:
    strand(stage, ZIGZAG, curveVertexCounts=[5, 5])
    short = UsdGeom.BasisCurves.Define(stage, "/World/Short")
    short.CreatePointsAttr([Gf.Vec3f(0, 0, 0)] * 2)
    short.CreateCurveVertexCountsAttr([2])
    cloud = UsdGeom.Points.Define(stage, "/World/Cloud")
    cloud.CreatePointsAttr([Gf.Vec3f(0, 0, 0)] * 3)
    cloud.CreateWidthsAttr([1.0, 2.0])
    UsdGeom.Sphere.Define(stage, "/World/Ball").CreateRadiusAttr(-1.0)
    UsdGeom.NurbsCurves.Define(stage, "/World/Nurbs")
    _, losses = picture(stage, 4, 1)
    assert losses == [
        "/World/Hair: has 7 points, which is not what its curves ask for (dropped)",
        "/World/Short: points of curves that make no whole segment (dropped)",
        "/World/Short: has 0 segments, expected 1 to 4194304 (dropped)",
        "/World/Cloud: has 2 widths, expected 3 (dropped)",
        "/World/Ball: radius is -1, expected more than 0 (dropped)",
        "/World/Nurbs: NurbsCurves is not supported (dropped)",
    ]


def test_display_opacity_lets_light_through(mi: Any, stage: Any) -> None:
    ball = black(UsdGeom.Cube.Define(stage, "/World/Cube"))
    ball.CreateDisplayOpacityAttr([0.25])
    image, losses = picture(stage, 64, 256)
    # Two faces lie in the way, each keeps a quarter of the light.
    assert image[28:36, 28:36].mean() == pytest.approx(0.75**2, abs=0.01)
    assert losses == []


def test_a_material_wins_over_display_opacity(mi: Any, stage: Any) -> None:
    cube = black(UsdGeom.Cube.Define(stage, "/World/Cube"))
    cube.CreateDisplayOpacityAttr([0.25])
    bind(cube, preview_material(stage, diffuseColor=(0.5, 0.5, 0.5), ior=1.0)[0])
    image, losses = picture(stage, 64, 16)
    assert image[28:36, 28:36].mean() == pytest.approx(0.5, abs=0.02)
    assert losses == []


def test_squeezed_curves_tell_that_their_widths_are_a_mean(mi: Any, stage: Any) -> None:
    curves = strand(stage, [(-1, 0, 0), (1, 0, 0)], type="linear", widths=[0.2])
    scale = curves.AddScaleOp()
    scale.Set((2, 2, 2))
    assert covered(stage, 4)[1] == []
    scale.Set((1, 8, 1))
    share, losses = covered(stage)
    assert losses == ["/World/Hair: widths grow by the mean scale of its transform (approximated)"]
    assert share[:, 32].sum() / 16 == pytest.approx(0.4, abs=0.03)


@pytest.mark.parametrize(("count", "squeezed"), [(1, True), (600, False)])
def test_balls_shine_in_any_shape_and_number(
    mi: Any, stage: Any, count: int, squeezed: bool
) -> None:
    cloud = UsdGeom.Points.Define(stage, "/World/Cloud")
    cloud.CreatePointsAttr([Gf.Vec3f(0, 0, 0)] * count)
    cloud.CreateWidthsAttr([2.0])
    if squeezed:
        cloud.AddScaleOp().Set((1, 1, 0.5))
    bind(
        cloud,
        preview_material(stage, emissiveColor=(3.0, 3.0, 3.0), diffuseColor=(0.0, 0.0, 0.0))[0],
    )
    image, losses = picture(stage, 8, 16)
    if count == 1:
        assert losses == []
        assert image[4, 4] == pytest.approx(3, rel=0.1)
    else:
        assert losses == ["/World/Cloud: light of more than 512 balls (dropped)"]


def test_the_scalar_variant_has_the_same_shapes(mi: Any, stage: Any) -> None:
    ball = black(UsdGeom.Sphere.Define(stage, "/World/Ball"))
    ball.AddTransformOp().Set(Gf.Matrix4d().SetScale(Gf.Vec3d(1, 0.5, 1)))
    strand(stage, ZIGZAG, type="cubic", basis="bspline", widths=[0.3])
    stage.Save()
    file = stage.GetRootLayer().realPath
    fast = weaveusd.render(file, width=24, height=24, spp=256)
    slow = weaveusd.render(file, width=24, height=24, spp=64, variant="scalar_rgb")
    assert slow.variant == "scalar_rgb"
    assert fast.image.min() < 0.05
    np.testing.assert_allclose(slow.image.mean(), fast.image.mean(), atol=0.01)
    np.testing.assert_allclose(slow.image, fast.image, atol=0.35)
