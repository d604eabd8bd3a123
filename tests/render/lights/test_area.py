from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdLux

from tests.render.lights.lamps import (
    card,
    corners,
    disk_beside,
    irradiance,
    irradiances,
    polygon,
    put,
    rect,
    tube,
)
from tests.render.stages import add_camera, new_stage, picture, write_image
from weaveusd.render.lights import solids


@pytest.mark.parametrize("normalize", [False, True])
@pytest.mark.parametrize(
    "place",
    [
        {"at": (0, 0, 3)},
        {"at": (1.5, -1, 3), "turn": (25, -30, 40)},
        {"at": (0.5, 0, 4), "scale": (2, 0.5, 3)},
        {"at": (0.5, 0, 4), "scale": (-1, 1, 1)},
        {"at": (0.5, 0, 4), "turn": (180, 0, 0), "scale": (1, 1, -1)},
    ],
)
def test_a_rect_light_gives_what_lamberts_polygon_formula_says(
    mi: Any, tmp_path: Path, place: Any, normalize: bool
) -> None:
    stage = card(tmp_path)
    light = rect(stage)
    light.CreateIntensityAttr(3.0)
    light.CreateExposureAttr(1.0)
    light.CreateNormalizeAttr(normalize)
    world = put(light, **place)
    area = np.linalg.norm(np.cross(world[:3, 0] * 4, world[:3, 1] * 2)) if normalize else 1
    found, losses = irradiance(stage)
    assert found == pytest.approx(6 / area * polygon(corners(world, 4, 2)), rel=0.01)
    assert losses == []


def test_a_sheared_rect_light_is_a_parallelogram(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    light = rect(stage)
    light.CreateNormalizeAttr(True)
    world = np.array([[1, 0.8, 0, 0.3], [0, 1, 0, 0], [0.2, 0, 1, 3], [0, 0, 0, 1]])
    light.AddTransformOp().Set(Gf.Matrix4d(*world.T.ravel()))
    area = np.linalg.norm(np.cross(world[:3, 0] * 4, world[:3, 1] * 2))
    found, _ = irradiance(stage)
    assert found == pytest.approx(polygon(corners(world, 4, 2)) / area, rel=0.01)


def test_a_rect_light_shines_along_minus_z_only(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    put(rect(stage), at=(0, 0, 3), turn=(0, 180, 0))
    assert irradiance(stage, 16)[0] == 0


def test_units_of_length_change_nothing_but_what_normalize_divides_by(
    mi: Any, tmp_path: Path
) -> None:
    """E = L · form factor in any unit; with normalize L = I / A in square units of the stage."""
    found = {}
    for unit in (0.01, 1.0):
        for normalize in (False, True):
            folder = tmp_path / f"{unit}{normalize}"
            folder.mkdir()
            stage = card(folder)
            UsdGeom.SetStageMetersPerUnit(stage, unit)
            light = rect(stage)
            light.CreateNormalizeAttr(normalize)
            put(light, at=(0, 0, 3))
            found[unit, normalize] = irradiance(stage)[0]
    assert found[0.01, False] == pytest.approx(found[1.0, False], rel=1e-6)
    assert found[0.01, True] == pytest.approx(found[1.0, True], rel=1e-6)
    assert found[1.0, False] / found[1.0, True] == pytest.approx(8.0, rel=1e-5)


@pytest.mark.parametrize("normalize", [False, True])
@pytest.mark.parametrize("aside", [0.0, 3.0])
def test_a_disk_light_gives_half_pi_times_one_minus_the_roots_ratio(
    mi: Any, tmp_path: Path, aside: float, normalize: bool
) -> None:
    stage = card(tmp_path)
    light = UsdLux.DiskLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(1.5)
    light.CreateNormalizeAttr(normalize)
    put(light, at=(aside, 0, 4))
    found, losses = irradiance(stage)
    area = np.pi * 1.5**2 if normalize else 1
    assert found == pytest.approx(disk_beside(1.5, 4, aside) / area, rel=0.01)
    assert losses == []


def test_a_disk_scaled_unevenly_is_an_ellipse_of_that_area(mi: Any, tmp_path: Path) -> None:
    """From afar E = L A cos θ cos θ' / d², and L A is the intensity where normalize holds."""
    stage = card(tmp_path)
    light = UsdLux.DiskLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.5)
    light.CreateNormalizeAttr(True)
    put(light, at=(0, 0, 40), scale=(3, 0.5, 1))
    assert irradiance(stage)[0] == pytest.approx(1 / 1600, rel=0.01)


@pytest.mark.parametrize("normalize", [False, True])
def test_a_sphere_light_gives_pi_times_the_square_of_its_sine(
    mi: Any, tmp_path: Path, normalize: bool
) -> None:
    """E = π L (r / d)² cos θ while all of it is above the card."""
    stage = card(tmp_path)
    light = UsdLux.SphereLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(1.0)
    light.CreateNormalizeAttr(normalize)
    put(light, at=(3, 0, 6), scale=(2, 2, 2))
    distance = np.sqrt(45)
    radiance = 1 / (4 * np.pi * 4) if normalize else 1
    found, losses = irradiance(stage)
    expected = np.pi * radiance * (2 / distance) ** 2 * 6 / distance
    assert found == pytest.approx(expected, rel=0.01)
    assert losses == []


def test_a_stretched_sphere_light_fills_the_cone_of_its_ellipsoid(mi: Any, tmp_path: Path) -> None:
    """E = π L a² / (a² + d² - c²): tangents from d leave an ellipsoid (a, a, c) at that slope."""
    stage = card(tmp_path)
    light = UsdLux.SphereLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.5)
    put(light, at=(0, 0, 5), scale=(2, 2, 6))
    found, losses = irradiance(stage, 65536)
    assert found == pytest.approx(np.pi * 1 / (1 + 25 - 9), rel=0.01)
    assert losses == []


def test_the_area_of_an_ellipsoid_is_that_of_legendres_integral() -> None:
    """An oblate one has A = 2π a² (1 + (1 - e²) artanh(e) / e), a sphere 4π r²."""
    a, c = 2.0, 0.7
    e = np.sqrt(1 - c * c / (a * a))
    exact = 2 * np.pi * a * a * (1 + (1 - e * e) * np.arctanh(e) / e)
    assert solids.ellipsoid_area(np.diag((a, c, a))) == pytest.approx(exact, rel=1e-6)
    assert solids.ellipsoid_area(np.eye(3) * 3) == pytest.approx(36 * np.pi, rel=1e-9)


def test_a_mesh_of_a_solid_has_its_area_and_faces_outward() -> None:
    for matrix in (np.diag((2.0, 1.0, 0.5, 1.0)), np.diag((-2.0, 1.0, 0.5, 1.0))):
        made = solids.ellipsoid(matrix)
        a, b, c = np.moveaxis(made.points[made.triangles], 1, 0)
        normals = np.cross(b - a, c - a) / 2
        area = np.linalg.norm(normals, axis=1).sum()
        assert area == pytest.approx(solids.ellipsoid_area(matrix[:3, :3]), rel=1e-3)
        assert (np.einsum("ij,ij->i", normals, a + b + c) > 0).all()


@pytest.mark.parametrize("normalize", [False, True])
@pytest.mark.parametrize(
    "place",
    [
        {"at": (0, 0, 2)},
        {"at": (1, 1, 3), "turn": (0, 50, 20)},
        {"at": (0.5, 0, 3), "scale": (1, 2, 0.5)},
        {"at": (0.5, 1, 3), "turn": (0, 0, 30), "scale": (-2, 2, 2)},
    ],
)
def test_a_cylinder_light_gives_the_integral_over_its_lateral_surface(
    mi: Any, tmp_path: Path, place: Any, normalize: bool
) -> None:
    stage = card(tmp_path)
    light = UsdLux.CylinderLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.3)
    light.CreateLengthAttr(2.5)
    light.CreateNormalizeAttr(normalize)
    world = put(light, **place)
    area = solids.tube_area(world[:3, :3] @ np.diag((2.5, 0.3, 0.3))[:, [1, 2, 0]])
    found, losses = irradiance(stage, 16384)
    assert found == pytest.approx(tube(world, 0.3, 2.5) / (area if normalize else 1), rel=0.01)
    assert losses == []


def test_the_area_of_a_tube_is_its_circumference_times_its_length() -> None:
    assert solids.tube_area(np.diag((0.3, 0.3, 2.0))) == pytest.approx(2 * np.pi * 0.3 * 2)
    # Ramanujan's second formula for the perimeter of an ellipse, exact to 1e-5 here.
    a, b = 1.0, 0.4
    h = ((a - b) / (a + b)) ** 2
    ellipse = np.pi * (a + b) * (1 + 3 * h / (10 + np.sqrt(4 - 3 * h)))
    assert solids.tube_area(np.diag((a, b, 3.0))) == pytest.approx(3 * ellipse, rel=1e-4)


def test_an_endless_tube_gives_pi_times_radius_over_distance(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    light = UsdLux.CylinderLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.5)
    light.CreateLengthAttr(400.0)
    put(light, at=(0, 0, 4))
    assert irradiance(stage, 16384)[0] == pytest.approx(np.pi * 0.5 / 4, rel=0.01)


def test_a_cylinder_light_does_not_shine_from_its_ends(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    put(UsdLux.CylinderLight.Define(stage, "/World/Light"), at=(0, 0, 4), turn=(0, 90, 0))
    assert irradiance(stage, 64)[0] == 0


def test_a_sphere_treated_as_a_point_gives_what_the_sphere_gives(mi: Any, tmp_path: Path) -> None:
    """I = π r² L, so E = I cos θ / d² is the sphere's own."""
    stage = card(tmp_path)
    light = UsdLux.SphereLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(1.0)
    put(light, at=(3, 0, 6), scale=(0.5, 0.5, 0.5))
    light.CreateTreatAsPointAttr(True)
    found, losses = irradiance(stage, 16)
    assert found == pytest.approx(np.pi * 0.25 / 45 * 6 / np.sqrt(45), rel=1e-3)
    assert losses == []


def test_a_normalized_point_has_a_quarter_of_its_intensity(mi: Any, tmp_path: Path) -> None:
    """Power does not follow the radius: π r² I / (4 π r²) = I / 4, also for none at all."""
    stage = card(tmp_path)
    light = UsdLux.SphereLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.0)
    light.CreateIntensityAttr(8.0)
    light.CreateNormalizeAttr(True)
    put(light, at=(0, 0, 4))
    found, losses = irradiance(stage, 16)
    assert found == pytest.approx(8 / 4 / 16, rel=1e-3)
    assert losses == ["/World/Light: sphere light of radius 0 is shown as a point (approximated)"]


def test_a_line_light_keeps_its_power(mi: Any, tmp_path: Path) -> None:
    """A thin tube gives L r ∫ cos θ' ... dx; with normalize L r = I / (2π l)."""
    stage = card(tmp_path)
    light = UsdLux.CylinderLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.0)
    light.CreateLengthAttr(2.0)
    light.CreateNormalizeAttr(True)
    light.CreateTreatAsLineAttr(True)
    world = put(light, at=(0, 0, 3))
    expected = tube(world, 0.002, 2.0) / (2 * np.pi * 0.002 * 2)
    assert irradiances(stage) == pytest.approx(expected, rel=0.01)
    _, losses = irradiance(stage, 4)
    assert len(losses) == 1
    assert "radius 0 is shown 0.001 of its length thick" in losses[0]


def sliver(stage: Any, kind: str, radius: float) -> float:
    """Define a light so thin, 1 aside and 6 above the card; return the irradiance there.

    A disk and a ball give E = L π r² cos θ cos θ' / d², where θ' of a ball is 0.
    """
    at = np.array((1.0, 0.0, 6.0))
    if kind == "rect":
        light: Any = rect(stage, 2 * radius, 2.0)
        return polygon(corners(put(light, at=at), 2 * radius, 2.0))
    if kind == "tube":
        light = UsdLux.CylinderLight.Define(stage, "/World/Light")
        light.CreateRadiusAttr(radius)
        light.CreateLengthAttr(2.0)
        return tube(put(light, at=at), radius, 2.0)
    kinds = {"disk": UsdLux.DiskLight, "ball": UsdLux.SphereLight}
    light = kinds[kind].Define(stage, "/World/Light")
    light.CreateRadiusAttr(radius)
    put(light, at=at)
    cosine = 6 / np.sqrt(37)
    return np.pi * radius**2 / 37 * cosine * (cosine if kind == "disk" else 1)


@pytest.mark.parametrize("radius", [1e-5, 1e-3, 0.02])
@pytest.mark.parametrize("kind", ["rect", "tube", "disk", "ball"])
def test_a_light_keeps_its_power_however_thin_it_is(
    mi: Any, tmp_path: Path, kind: str, radius: float
) -> None:
    stage = card(tmp_path)
    expected = sliver(stage, kind, radius)
    assert irradiances(stage) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("radius", [1e-5, 1e-3, 0.02])
@pytest.mark.parametrize("kind", ["rect", "tube", "disk", "ball"])
def test_a_ray_enters_a_light_once(mi: Any, tmp_path: Path, kind: str, radius: float) -> None:
    """What is met behind a clear surface counts in full, as if it were seen through glass."""
    from weaveusd.render.translate import translate

    stage = card(tmp_path)
    sliver(stage, kind, radius)
    scene = translate(stage, width=3, height=3).scene
    box = next(shape for shape in scene.shapes() if shape.is_emitter()).bbox()
    low, high = np.array(box.min), np.array(box.max)
    shares = np.random.default_rng(5).random((3, 1 << 16))
    toward = low[:, None] + (high - low)[:, None] * shares
    toward /= np.linalg.norm(toward, axis=0)
    ray = mi.Ray3f(mi.Point3f(0), mi.Vector3f(toward.astype(np.float32)))
    met, entered = scene.ray_intersect(ray), []
    for _ in range(3):
        entered.append(np.array(met.is_valid() & (met.wi.z > 0)))
        met = scene.ray_intersect(met.spawn_ray(ray.d), met.is_valid())
    first, *again = entered
    assert first.mean() > 0.5
    assert not np.any(again)


def quadrants(path: Path) -> None:
    """Top left red, top right green, bottom left blue, bottom right white."""
    pixels = np.zeros((8, 8, 3), np.float32)
    pixels[:4, :4, 0] = pixels[:4, 4:, 1] = pixels[4:, :4, 2] = 1
    pixels[4:, 4:] = 1
    write_image(path, pixels)


def test_the_picture_of_a_rect_light_is_upright_from_its_front(mi: Any, tmp_path: Path) -> None:
    """Its first texel lies on (+X, +Y) and its last on (-X, -Y), as the schema says."""
    stage = new_stage(tmp_path / "scene.usda")
    quadrants(tmp_path / "four.exr")
    light = rect(stage, 2, 2)
    light.CreateTextureFileAttr("./four.exr")
    light.CreateIntensityAttr(0.5)
    light.CreateColorAttr(Gf.Vec3f(1, 0.5, 1))
    # The camera looks along -z; the light is turned to shine towards it.
    put(light, turn=(0, 180, 0))
    add_camera(stage, distance=10, fov=11.4)
    image, losses = picture(stage, 8, 16)
    assert losses == []
    assert image[1, 1] == pytest.approx([0.5, 0, 0], abs=1e-3)
    assert image[1, 6] == pytest.approx([0, 0.25, 0], abs=1e-3)
    assert image[6, 1] == pytest.approx([0, 0, 0.5], abs=1e-3)
    assert image[6, 6] == pytest.approx([0.5, 0.25, 0.5], abs=1e-3)


def test_a_textured_rect_light_gives_the_polygon_of_its_lit_half(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    pixels = np.zeros((64, 64, 3), np.float32)
    pixels[:, :32] = 1  # the left half, on +X
    write_image(tmp_path / "half.exr", pixels)
    light = rect(stage, 4, 2)
    light.CreateTextureFileAttr("./half.exr")
    put(light, at=(0, 0, 2))
    lit = np.array([(0, -1, 2), (2, -1, 2), (2, 1, 2), (0, 1, 2)])
    assert irradiance(stage)[0] == pytest.approx(polygon(lit), rel=0.015)


def test_a_missing_picture_leaves_a_rect_light_its_color(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    light = rect(stage)
    light.CreateTextureFileAttr("./nowhere.exr")
    world = put(light, at=(0, 0, 3))
    found, losses = irradiance(stage)
    assert found == pytest.approx(polygon(corners(world, 4, 2)), rel=0.01)
    assert losses == [
        "/World/Light: /World/Light.inputs:texture:file: ./nowhere.exr is not found: "
        "the light has one color (dropped)"
    ]


def test_a_light_that_is_turned_off_is_dark_and_casts_no_shadow(mi: Any, tmp_path: Path) -> None:
    stage = card(tmp_path)
    light = rect(stage)
    light.CreateIntensityAttr(0.0)
    put(light, at=(0, 0, 3))
    assert irradiance(stage, 16) == (0.0, [])
    sun = UsdLux.DistantLight.Define(stage, "/World/Sun")
    sun.CreateAngleAttr(0.0)
    sun.CreateIntensityAttr(1.0)
    assert irradiance(stage, 16)[0] == pytest.approx(1.0, rel=1e-3)
