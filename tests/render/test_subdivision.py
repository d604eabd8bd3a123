"""Subdivision surfaces against limits that are known without subdividing."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from weaveusd.render.face_varying import INTERPOLATIONS, carry_corners
from weaveusd.render.subdivision import levels_for, refine
from weaveusd.render.topology import connect, fans

CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = np.array(
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
)
OCTAHEDRON = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
TRIANGLES = np.array([(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4),
                      (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])  # fmt: skip


def cage(
    faces: Any, vertices: int, creases: Any = (), sharpness: Any = (), corners: Any = None
) -> Any:
    faces = [np.asarray(face) for face in faces]
    return connect(
        np.array([len(face) for face in faces]), np.concatenate(faces), vertices,
        np.array(creases, np.int64).reshape(-1, 2), np.array(sharpness, float),
        np.zeros(vertices) if corners is None else np.asarray(corners, float),
    )  # fmt: skip


def grid(n: int, z: Any = None) -> tuple[Any, Any]:
    """A square of n by n quadrangles, one unit each."""
    y, x = np.mgrid[: n + 1, : n + 1].reshape(2, -1)
    points = np.stack((x, y, np.zeros_like(x) if z is None else z(x, y)), axis=1).astype(float)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    return points, np.stack((first, first + 1, first + n + 2, first + n + 1), axis=1)


def cubic(t: Any, controls: Any) -> Any:
    """A uniform cubic B-spline at t, control k standing at t = k."""
    d = np.abs(np.asarray(t)[:, None] - np.arange(len(controls)))
    weight = np.where(d < 1, 2 / 3 - d * d + d**3 / 2, np.where(d < 2, (2 - d) ** 3 / 6, 0))
    return weight @ controls


@pytest.mark.parametrize("levels", [1, 2, 4])
def test_a_cube_meets_its_limit_at_every_level(levels: int) -> None:
    refined = refine(cage(QUADS, 8), "catmullClark", levels)
    found = refined.carry(CUBE, smooth=True)
    # (n² v + 4 Σ e + Σ f) / (n (n + 5)) by Halstead, Kass and DeRose (1993) with n = 3: neighbors
    # of a corner add up to the corner, the diagonals of its faces to its opposite.
    np.testing.assert_allclose(found[:8], (9 + 4 - 1) / 24 * CUBE, atol=1e-12)
    assert len(found) == 6 * 4**levels + 2
    assert (refined.parent == np.repeat(np.arange(6), 4**levels)).all()


@pytest.mark.parametrize("levels", [1, 3])
def test_an_octahedron_meets_loops_limit(levels: int) -> None:
    found = refine(cage(TRIANGLES, 6), "loop", levels).carry(OCTAHEDRON, smooth=True)
    beta = (5 / 8 - (3 / 8) ** 2) / 4
    share = 1 / (4 + 3 / (8 * beta))
    np.testing.assert_allclose(found[:6], (1 - 4 * share) * OCTAHEDRON, atol=1e-12)
    assert len(found) == 4 * 4**levels + 2


def test_regular_quadrangles_are_a_bicubic_spline() -> None:
    heights = np.random.default_rng(3).normal(size=(7, 7))
    points, quads = grid(6, lambda x, y: heights[y, x])
    found = refine(cage(quads, 49), "catmullClark", 3).carry(points, smooth=True)
    inner = (np.abs(found[:, :2] - 3) <= 2).all(axis=1)  # beyond it the border is felt
    x, y, z = found[inner].T
    rows = np.array([cubic(x, row) for row in heights])  # (7, points)
    expected = np.array([cubic(y[k : k + 1], rows[:, k])[0] for k in range(len(x))])
    assert inner.sum() == 33**2
    np.testing.assert_allclose(z, expected, atol=1e-12)


@pytest.mark.parametrize(
    ("scheme", "cut"), [("catmullClark", False), ("loop", True), ("bilinear", False)]
)
def test_a_plane_stays_a_plane(scheme: Any, cut: bool) -> None:
    points, faces = grid(4)
    points[12] += (0.3, 0.2, 0)  # irregular, but flat
    if cut:
        faces = np.concatenate((faces[:, :3], faces[:, (0, 2, 3)]))
    height = points @ (0.5, -0.25, 0) + 2
    refined = refine(cage(faces, 25), scheme, 3)
    found = refined.carry(np.column_stack((points, height)), smooth=True)
    np.testing.assert_allclose(found[:, 3], found[:, :3] @ (0.5, -0.25, 0) + 2, atol=1e-12)


def test_a_border_is_a_cubic_spline_and_its_corners_stay_if_told() -> None:
    points, quads = grid(4)
    points[:5, 1] -= (0, 1, 0, 2, 0)  # the lower border is bent
    corners = np.zeros(25)
    corners[[0, 4, 20, 24]] = np.inf
    for kept, expected in ((corners, points[0]), (None, None)):
        refined = refine(cage(quads, 25, corners=kept), "catmullClark", 2)
        found = refined.carry(points, smooth=True)
        middle = (points[1] + 4 * points[2] + points[3]) / 6
        np.testing.assert_allclose(found[2], middle, atol=1e-12)
        if expected is None:
            assert np.linalg.norm(found[0] - points[0]) > 0.1
        else:
            np.testing.assert_allclose(found[0], expected, atol=1e-12)


def test_creases_lead_from_the_limit_back_to_the_cage() -> None:
    edges = np.unique(np.sort(np.stack((QUADS, np.roll(QUADS, -1, 1)), -1).reshape(-1, 2)), axis=0)
    reach = []
    for sharpness in (0.0, 0.5, 1.0, 1.5, 3.0, np.inf):
        topology = cage(QUADS, 8, edges, np.full(12, sharpness))
        found = refine(topology, "catmullClark", 5).carry(CUBE, smooth=True)
        reach.append(found[:8, 0].max())
    assert reach[0] == pytest.approx(0.5)
    assert reach[-1] == pytest.approx(1)
    assert (np.diff(reach) > 0).all()
    straight = refine(topology, "bilinear", 5).carry(CUBE, smooth=True)
    np.testing.assert_allclose(np.abs(found).max(axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(np.abs(straight).max(axis=1), 1, atol=1e-12)


def test_a_crease_of_sharpness_one_is_one_sharp_step_and_then_smooth() -> None:
    edges = np.array([(0, 1)])
    sharp_once = refine(cage(QUADS, 8, edges, [1.0]), "catmullClark", 4).carry(CUBE, smooth=True)
    first = refine(cage(QUADS, 8, edges, [np.inf]), "catmullClark", 1)
    # The first level of an endless crease, then the smooth rule alone.
    from weaveusd.render.subdivision import _refine

    points = _refine(first.levels[0], CUBE, "catmullClark", True)
    quads = first.topology.corners.reshape(-1, 4)
    rest = refine(cage(quads, len(points)), "catmullClark", 3).carry(points, smooth=True)
    np.testing.assert_allclose(np.sort(sharp_once, axis=0), np.sort(rest, axis=0), atol=1e-12)


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_coordinates_without_seams_follow_the_surface(interpolation: Any) -> None:
    points, quads = grid(4)
    refined = refine(cage(quads, 25), "catmullClark", 2)
    placed = refined.carry(points, smooth=True)[refined.topology.corners][:, :2]
    found = carry_corners(refined, points[quads.ravel(), :2], interpolation)
    inner = (np.abs(placed - 2) < 1).all(axis=1)
    np.testing.assert_allclose(found[inner], placed[inner], atol=1e-12)


def test_coordinates_of_an_island_keep_what_they_are_told_to() -> None:
    square = np.array(((0, 0), (1, 0), (1, 1), (0, 1)), float)
    islands = np.tile(square, (6, 1)) + np.repeat(2 * np.arange(6), 4)[:, None]
    refined = refine(cage(QUADS, 8), "catmullClark", 3)
    offsets = 2 * np.repeat(refined.parent, 4)[:, None]
    reach = {}
    for interpolation in INTERPOLATIONS:
        found = carry_corners(refined, islands, interpolation) - offsets  # type: ignore[arg-type]
        assert found.min() > -1e-12
        np.testing.assert_allclose(found.mean(axis=0), 0.5, atol=1e-12)
        reach[interpolation] = found.max()
    assert reach["none"] == pytest.approx(23 / 24)  # a closed spline around the square
    assert all(reach[name] == pytest.approx(1) for name in INTERPOLATIONS if name != "none")


def test_linear_coordinates_are_bilinear_in_every_face() -> None:
    values = np.random.default_rng(1).normal(size=(24, 2))
    refined = refine(cage(QUADS, 8), "catmullClark", 1)
    found = carry_corners(refined, values, "all").reshape(6, 4, 4, 2)
    given = values.reshape(6, 4, 2)
    np.testing.assert_allclose(found[:, :, 0], given)
    np.testing.assert_allclose(found[:, :, 1], (given + np.roll(given, -1, axis=1)) / 2)
    np.testing.assert_allclose(found[:, :, 2], np.repeat(given.mean(1, keepdims=True), 4, axis=1))


@pytest.mark.parametrize(
    ("faces", "scheme"), [(6, "catmullClark"), (10**5, "loop"), (10**6, "bilinear")]
)
def test_levels_are_bounded_by_memory(faces: int, scheme: Any) -> None:
    counts = np.full(faces, 3 if scheme == "loop" else 4)
    levels = levels_for(counts, scheme)
    first = 4 * faces
    assert levels >= 1
    assert first * 4 ** (levels - 1) <= max(1 << 15, first)
    assert levels_for(np.full(1 << 22, 4), scheme) == 0
    assert levels_for(np.zeros(0, int), scheme) == 0


def test_corners_of_a_vertex_are_one_fan_unless_a_crease_parts_them() -> None:
    n = 20_000
    rim = np.arange(1, n + 1)
    cone = np.stack((np.zeros(n, int), rim, np.roll(rim, -1)), axis=1)
    begin = time.process_time()
    label = fans(cage(cone, n + 1))
    assert time.process_time() - begin < 2
    assert len(set(label[0::3])) == 1
    for creases, parts in ((1, 1), (2, 2), (5, 5)):
        edges = [(0, 1 + k * (n // 5)) for k in range(creases)]
        label = fans(cage(cone, n + 1, edges, np.full(creases, 2.0)))
        assert len(set(label[0::3])) == parts
