"""Subdivision surfaces: Catmull-Clark, Loop and bilinear, with creases, on plain arrays.

The rules are those of Catmull and Clark (1978) and Loop (1987), creases and corners of finite
sharpness those of DeRose, Kass and Truong (1998, "Subdivision Surfaces in Character Animation"):
sharpness falls by one with each level, and a vertex whose rule changes on the way is blended.
After the last level every value moves to the limit that further levels would lead to.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from weaveusd.render.topology import CREASE, SMOOTH, Topology, connect, gather_sum

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

Scheme = Literal["catmullClark", "loop", "bilinear"]
SCHEMES: tuple[str, ...] = get_args(Scheme)

ENOUGH_FACES = 1 << 15
"""Cages are refined to about as many faces: a cube's limit is then met within 1e-4 of its size."""

MOST_FACES = 1 << 23
"""Refined faces that are taken memory for; a cage that passes it in one level is not refined."""

MOST_LEVELS = 6


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """A refined cage: its faces, the cage's face of each, and how values of a cage follow."""

    topology: Topology
    parent: Indices  # (F,) face of the cage
    levels: tuple[Topology, ...]  # the cage first, without the last one
    scheme: Scheme

    def carry(self, values: Doubles, *, smooth: bool) -> Doubles:
        """Return values (V, k) of the cage's vertices at the refined ones, on the limit.

        Values that are not `smooth` are interpolated linearly along edges and over faces.
        """
        smooth = smooth and self.scheme != "bilinear"
        for level in self.levels:
            values = _refine(level, values, self.scheme, smooth)
        return _limit(self.topology, values, self.scheme) if smooth else values


def levels_for(counts: Indices, scheme: Scheme) -> int:
    """Return how often a cage with faces of `counts` corners is refined; 0 if it is too large.

    The first level makes a quadrangle of each corner, or four triangles of each triangle; each
    further level four faces of one.
    """
    first = 4 * counts.size if scheme == "loop" else int(counts.sum())
    if not 0 < first <= MOST_FACES:
        return 0
    levels = 1
    while levels < MOST_LEVELS and first * 4**levels <= ENOUGH_FACES:
        levels += 1
    return levels


def refine(cage: Topology, scheme: Scheme, levels: int) -> Refined:
    """Return the cage refined `levels` times; for Loop its faces must be triangles."""
    child = _split_triangles if scheme == "loop" else _split_corners
    topology, parent = cage, np.arange(cage.counts.size)
    passed = []
    for _ in range(levels):
        passed.append(topology)
        pieces = 4 if scheme == "loop" else topology.counts
        parent = np.repeat(parent, pieces)
        topology = child(topology)
    return Refined(topology, parent, tuple(passed), scheme)


def _split_corners(level: Topology) -> Topology:
    """Return the topology with one quadrangle for each corner of the faces."""
    edges = level.vertices + level.edge_of
    centers = level.vertices + len(level.ends) + level.face_of()
    quads = np.stack((level.corners, edges, centers, edges[level.preceding]), axis=1)
    vertices = level.vertices + len(level.ends) + level.counts.size
    return _connect_child(level, quads, vertices)


def _split_triangles(level: Topology) -> Topology:
    """Return the topology with four triangles for each triangle, the middle one last."""
    a, b, c = level.corners.reshape(-1, 3).T
    ab, bc, ca = (level.vertices + level.edge_of).reshape(-1, 3).T
    pieces = np.stack((a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca), axis=1).reshape(-1, 3)
    return _connect_child(level, pieces, level.vertices + len(level.ends))


def _connect_child(level: Topology, faces: Indices, vertices: int) -> Topology:
    """Return the topology of `faces`, each half of a sharp edge being one less sharp."""
    left = np.maximum(level.edge_sharpness - 1, 0)
    sharp = np.flatnonzero(left > 0)
    halves = [np.stack((level.ends[sharp, k], level.vertices + sharp), axis=1) for k in (0, 1)]
    vertex_sharpness = np.zeros(vertices)
    vertex_sharpness[: level.vertices] = np.maximum(level.vertex_sharpness - 1, 0)
    return connect(
        np.full(len(faces), faces.shape[1]), faces.ravel(), vertices, np.concatenate(halves),
        np.tile(left[sharp], 2), vertex_sharpness,
    )  # fmt: skip


def _refine(level: Topology, values: Doubles, scheme: Scheme, smooth: bool) -> Doubles:
    """Return the values (V, k) of a level at the vertices of the next one."""
    middle = values[level.ends].mean(axis=1)
    if scheme == "loop":
        if not smooth:
            return np.concatenate((values, middle))
        opposite = values[level.corners[level.preceding]]
        across = gather_sum(opposite, level.edge_of, len(level.ends))
        edges = _blend(0.75 * middle + 0.125 * across, middle, level.edge_sharpness)
        return np.concatenate((_vertices(level, values, _loop_vertices), edges))
    faces = gather_sum(values[level.corners], level.face_of(), level.counts.size)
    faces /= level.counts[:, None]
    if not smooth:
        return np.concatenate((values, middle, faces))
    beside = gather_sum(faces[level.face_of()], level.edge_of, len(level.ends))
    edges = _blend(0.5 * middle + 0.25 * beside, middle, level.edge_sharpness)

    def moved(topology: Topology, cage: Doubles) -> Doubles:
        n = _at_least_one(topology.valence())
        around = gather_sum(faces[topology.face_of()], topology.corners, topology.vertices)
        return np.asarray(((n - 2) * cage + (_neighbors(topology, cage) + around) / n) / n)

    return np.concatenate((_vertices(level, values, moved), edges, faces))


def _loop_vertices(level: Topology, values: Doubles) -> Doubles:
    n = _at_least_one(level.valence())
    beta = _loop_beta(n)
    return np.asarray((1 - n * beta) * values + beta * _neighbors(level, values))


def _vertices(
    level: Topology, values: Doubles, moved: Callable[[Topology, Doubles], Doubles]
) -> Doubles:
    """Return the moved vertices; one whose rule changes with the next level is blended."""
    now = level.rules(level.edge_sharpness, level.vertex_sharpness)
    later = level.rules(level.edge_sharpness - 1, level.vertex_sharpness - 1)
    smooth, crease = moved(level, values), _along_crease(level, values, 0.125)
    weight = _fading(level)
    masks = np.stack((smooth, crease, values))
    rows = np.arange(level.vertices)
    result: Doubles = weight * masks[now, rows] + (1 - weight) * masks[later, rows]
    alone = level.valence() == 0
    result[alone] = values[alone]
    return result


def _fading(level: Topology) -> Doubles:
    """Return (V, 1) the mean of the sharpness in 0…1 that meets in each vertex; 1 where none."""

    def ends_now(sharpness: Doubles) -> NDArray[np.bool_]:
        return np.asarray((sharpness > 0) & (sharpness <= 1))

    fading = ends_now(level.edge_sharpness)
    slots = level.ends[fading].ravel()
    own = ends_now(level.vertex_sharpness)
    weights = np.repeat(level.edge_sharpness[fading], 2)[:, None]
    total = gather_sum(weights, slots, level.vertices)[:, 0]
    total += np.where(own, level.vertex_sharpness, 0)
    count = np.bincount(slots, minlength=level.vertices) + own
    return np.where(count > 0, total / np.maximum(count, 1), 1.0)[:, None]


def _limit(level: Topology, values: Doubles, scheme: Scheme) -> Doubles:
    """Return the values (V, k) where infinitely many further levels would move them.

    With n edges, e the neighbors' sum and f that of the opposite corners of the quadrangles
    around, v goes to ``(n² v + 4 e + f) / (n (n + 5))``, under Loop's rule to
    ``(1 - n x) v + x e`` with ``x = 1 / (n + 3 / (8 β))``, on a crease to the B-spline's 1:4:1.
    """
    n = _at_least_one(level.valence())
    around = _neighbors(level, values)
    if scheme == "loop":
        share = 1 / (n + 3 / (8 * _loop_beta(n)))
        smooth = (1 - n * share) * values + share * around
    else:
        across = level.corners[level.following[level.following]]
        opposite = gather_sum(values[across], level.corners, level.vertices)
        smooth = (n * n * values + 4 * around + opposite) / (n * (n + 5))
    rule = level.rules(level.edge_sharpness, level.vertex_sharpness)[:, None]
    crease = _along_crease(level, values, 1 / 6)
    moved = np.where(rule == SMOOTH, smooth, np.where(rule == CREASE, crease, values))
    return np.where(level.valence()[:, None] == 0, values, moved)


def _along_crease(level: Topology, values: Doubles, share: float) -> Doubles:
    """Return the vertices moved by `share` of each neighbor along the sharp edges they lie on."""
    sharp = level.ends[level.edge_sharpness > 0]
    around = gather_sum(
        np.concatenate((values[sharp[:, 1]], values[sharp[:, 0]])), sharp.T.ravel(), level.vertices
    )
    return np.asarray((1 - 2 * share) * values + share * around)


def _neighbors(level: Topology, values: Doubles) -> Doubles:
    """Return the sum of the values at the other ends of each vertex's edges."""
    other = np.concatenate((values[level.ends[:, 1]], values[level.ends[:, 0]]))
    return gather_sum(other, level.ends.T.ravel(), level.vertices)


def _loop_beta(valence: Doubles) -> Doubles:
    return np.asarray((0.625 - (0.375 + np.cos(2 * np.pi / valence) / 4) ** 2) / valence)


def _at_least_one(valence: Indices) -> Doubles:
    return np.maximum(valence, 1).astype(np.float64)[:, None]


def _blend(smooth: Doubles, sharp: Doubles, sharpness: Doubles) -> Doubles:
    share = np.clip(sharpness, 0, 1)[:, None]
    return np.asarray((1 - share) * smooth + share * sharp)
