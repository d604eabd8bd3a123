from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from weaveusd.render.polygons import per_corner, split, triangulate


def area_vector(points: Any, triangles: Any) -> Any:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a).sum(axis=0) / 2


@settings(deadline=None, max_examples=60)
@given(st.lists(st.floats(0.2, 1.0), min_size=3, max_size=12), st.integers(0, 2))
def test_any_star_is_cut_without_loss_or_overlap(radii: list[float], axis: int) -> None:
    angle = np.arange(len(radii)) / len(radii) * 2 * np.pi
    flat = np.stack((np.cos(angle), np.sin(angle)), axis=1) * np.array(radii)[:, None]
    points = np.insert(flat, axis, 0.3, axis=1)
    n = len(radii)
    found = triangulate(np.array([n]), points, np.arange(n), reverse=False)
    assert found.corners.shape == (n - 2, 3)
    pieces = [area_vector(points, t[None]) for t in found.corners]
    x, y = flat.T
    outline = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    # All pieces face the same way and together have the polygon's area: none overlaps.
    assert sum(abs(p[axis]) for p in pieces) == pytest.approx(abs(outline), rel=1e-9)


def test_reversing_turns_every_triangle() -> None:
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
    forth = triangulate(np.array([4]), points, np.arange(4), reverse=False)
    back = triangulate(np.array([4]), points, np.arange(4), reverse=True)
    assert area_vector(points, forth.corners)[2] == 1
    assert area_vector(points, back.corners)[2] == -1


def test_faces_keep_their_number_and_degenerate_ones_vanish() -> None:
    points = np.random.default_rng(0).normal(size=(9, 3))
    found = triangulate(np.array([2, 4, 3]), points, np.arange(9), reverse=False)
    assert found.face.tolist() == [1, 1, 2]
    assert set(found.corners.ravel().tolist()) == {2, 3, 4, 5, 6, 7, 8}


@pytest.mark.parametrize(
    ("how", "values", "expected"),
    [
        ("constant", [7], [7, 7, 7, 7, 7, 7]),
        ("uniform", [1, 2], [1, 1, 1, 2, 2, 2]),
        ("vertex", [5, 6, 7, 8], [5, 6, 7, 7, 6, 8]),
        ("faceVarying", [1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 6]),
    ],
)
def test_every_interpolation_reaches_the_corners(how: Any, values: Any, expected: Any) -> None:
    counts, indices = np.array([3, 3]), np.array([0, 1, 2, 2, 1, 3])
    found = per_corner(np.array(values, float)[:, None], how, counts, indices)
    assert found[:, 0].tolist() == expected
    with pytest.raises(ValueError, match=f"has {len(values) - 1} {how} values"):
        per_corner(np.array(values[1:], float)[:, None], how, counts, indices)


def test_vertices_are_shared_only_where_all_their_values_agree() -> None:
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
    indices = np.array([0, 1, 2, 0, 2, 3])
    triangles = triangulate(np.array([3, 3]), points, indices, reverse=False)
    smooth = split(triangles, indices, {"uv": points[indices][:, :2]})
    assert len(smooth.source) == 4
    seam = points[indices][:, :2].copy()
    seam[3:] += 10
    cut = split(triangles, indices, {"uv": seam})
    assert len(cut.source) == 6
    np.testing.assert_array_equal(indices[cut.source][cut.triangles], [[0, 1, 2], [0, 2, 3]])


def test_many_concave_quadrangles_are_cut_at_once() -> None:
    dart = np.array([(0, 0, 0), (2, -1, 0), (0.5, 0, 0), (2, 1, 0)], float)  # inward at the third
    count = 200_000
    begin = time.process_time()
    found = triangulate(np.full(count, 4), dart, np.tile(np.arange(4), count), reverse=False)
    assert time.process_time() - begin < 3
    inside = [area_vector(dart, piece[None] % 4)[2] for piece in found.corners[:2]]
    assert sum(inside) == pytest.approx(area_vector(dart, np.array([(0, 1, 2), (0, 2, 3)]))[2])
    assert len({v > 0 for v in inside}) == 1
