"""What is next to what in a polygon mesh, and how sharp its edges and vertices are.

Plain arrays, nothing of USD or Mitsuba. A corner is one vertex of one face; corners are numbered
face by face.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

SMOOTH, CREASE, CORNER = 0, 1, 2
"""Rules by which a vertex moves: in all directions, along a crease, or not at all."""


@dataclass(frozen=True, slots=True, eq=False)
class Topology:
    """Faces, the edges between them, and their sharpness; infinite at borders.

    An edge of one face or of more than two is sharp, since no surface passes it smoothly.
    """

    vertices: int
    counts: Indices  # (F,) corners of each face
    corners: Indices  # (C,) vertex of each corner
    following: Indices  # (C,) next corner of the same face
    preceding: Indices  # (C,)
    edge_of: Indices  # (C,) edge from the corner to the following one
    ends: Indices  # (E, 2) vertices of each edge, the smaller one first
    shared: Indices  # (E,) corners that lead along each edge
    edge_sharpness: Doubles  # (E,)
    vertex_sharpness: Doubles  # (V,)

    def face_of(self) -> Indices:
        """Return the face of each corner, (C,)."""
        return np.repeat(np.arange(self.counts.size), self.counts)

    def valence(self) -> Indices:
        """Return the number of edges that meet in each vertex, (V,)."""
        return np.bincount(self.ends.ravel(), minlength=self.vertices)

    def rules(self, edge_sharpness: Doubles, vertex_sharpness: Doubles) -> Indices:
        """Return the rule of each vertex, (V,), for the sharpness given."""
        sharp = self.ends[edge_sharpness > 0].ravel()
        creases = np.bincount(sharp, minlength=self.vertices)
        rule = np.where(creases == 2, CREASE, SMOOTH)
        rule[(creases > 2) | (vertex_sharpness > 0)] = CORNER
        return rule


def connect(
    counts: Indices,
    corners: Indices,
    vertices: int,
    creases: Indices,
    crease_sharpness: Doubles,
    vertex_sharpness: Doubles,
) -> Topology:
    """Return the topology of faces of `counts` corners, creases (n, 2) being pairs of vertices.

    Creases along no edge are ignored; of several along one edge the sharpest counts.
    """
    starts = np.cumsum(counts) - counts
    number = np.arange(corners.size)
    following, preceding = number + 1, number - 1
    following[starts + counts - 1] = starts
    preceding[starts] = starts + counts - 1
    keys, edge_of = np.unique(
        _keys(corners, corners[following], vertices), return_inverse=True
    )  # fmt: skip
    shared = np.bincount(edge_of, minlength=keys.size)
    edge_sharpness = np.zeros(keys.size)
    wanted = _keys(creases[:, 0], creases[:, 1], vertices)
    place = np.minimum(np.searchsorted(keys, wanted), max(keys.size - 1, 0))
    real = keys[place] == wanted if keys.size else np.zeros(0, bool)
    np.maximum.at(edge_sharpness, place[real], crease_sharpness[real])
    edge_sharpness[shared != 2] = np.inf
    ends = np.stack((keys // vertices, keys % vertices), axis=1)
    fixed = vertex_sharpness.copy()
    fixed[ends[shared > 2].ravel()] = np.inf
    return Topology(
        vertices, counts, corners, following, preceding, edge_of, ends, shared, edge_sharpness,
        fixed,
    )  # fmt: skip


def gather_sum(values: Doubles, slots: Indices, size: int) -> Doubles:
    """Return the sums (size, k) of the rows of `values` (n, k) that fall into the same slot."""
    columns = [np.bincount(slots, weights=column, minlength=size) for column in values.T]
    return np.stack(columns, axis=1).astype(np.float64, copy=False)


def fans(topology: Topology) -> Indices:
    """Return a label (C,) for each corner: corners of one vertex not parted by a sharp edge share.

    Labels are the smallest corner of the fan.
    """
    label = np.arange(topology.corners.size)
    smooth = topology.edge_sharpness[topology.edge_of] <= 0
    along = np.flatnonzero(smooth)
    along = along[np.argsort(topology.edge_of[along], kind="stable")]
    left, right = along[0::2], along[1::2]  # the two corners that lead along each smooth edge
    far_left, far_right = topology.following[left], topology.following[right]
    alike = topology.corners[left] == topology.corners[right]  # both lead the same way
    one = np.concatenate((left, far_left))
    other = np.concatenate((np.where(alike, right, far_right), np.where(alike, far_right, right)))
    while True:
        least = np.minimum(label[one], label[other])
        before = label.copy()
        np.minimum.at(label, one, least)
        np.minimum.at(label, other, least)
        label = label[label]  # so that a fan of n corners is done in about log n rounds
        if np.array_equal(before, label):
            return label


def _keys(a: Indices, b: Indices, vertices: int) -> Indices:
    return np.asarray(np.minimum(a, b) * vertices + np.maximum(a, b), np.int64)
