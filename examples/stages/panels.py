"""Pattern pieces, sewn together where they meet.

A panel is a grid of vertices with two places: in the pattern, flat, in metres along weft (s) and
warp (t); and in space, where it is held before it is let go. Panels are sewn where they begin at
the same place in space.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from relax import Body, Fabric, Phase, make_body, relax

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from colliders import Colliders
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

MICRON = 1e-6
"""Starts are rounded to this, so that the last bit of a machine's sine is no part of a drape."""


@dataclass(frozen=True, slots=True, eq=False)
class Panel:
    """One piece of cloth; seen from outside, columns run right and rows up."""

    st: Doubles  # (rows, columns, 2)
    start: Doubles  # (rows, columns, 3)


@dataclass(frozen=True, slots=True, eq=False)
class Sewn:
    """Panels with common vertices along their seams."""

    panels: tuple[Panel, ...]
    ids: tuple[Indices, ...]  # (rows, columns) vertex of each panel's grid
    start: Doubles  # (V, 3)
    quads: Indices  # (Q, 4) vertices, counter-clockwise from outside
    st: Doubles  # (Q, 4, 2)
    panel: Indices  # (Q,) which panel
    even: NDArray[np.bool_]  # (Q,) white cells of the panel's chessboard


def plane(rows: int, columns: int, place: Callable[[Doubles, Doubles], Sequence[Doubles]]) -> Panel:
    """Return the panel of `place`: s, t, x, y, z of the shares 0…1 right and up."""
    right, up = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    values = np.stack(np.broadcast_arrays(*place(right, up)), axis=-1)
    values = np.rint(values / MICRON) * MICRON
    return Panel(values[..., :2], values[..., 2:])


def sew(panels: Sequence[Panel]) -> Sewn:
    """Return the panels with one vertex at each place."""
    every = np.concatenate([p.start.reshape(-1, 3) for p in panels])
    _, first, inverse = np.unique(
        np.rint(every / MICRON), axis=0, return_index=True, return_inverse=True
    )
    # Vertices are numbered as the panels name them first, which keeps neighbors together.
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    numbers = rank[inverse.ravel()]
    ids, quads, st, panel, even = [], [], [], [], []
    begin = 0
    for k, piece in enumerate(panels):
        rows, columns = piece.start.shape[:2]
        grid = numbers[begin : begin + rows * columns].reshape(rows, columns)
        begin += rows * columns
        ids.append(grid)
        quads.append(_corners(grid).reshape(-1, 4))
        st.append(_corners(piece.st).reshape(-1, 4, 2))
        panel.append(np.full(len(quads[-1]), k))
        row, column = np.indices((rows - 1, columns - 1))
        even.append((row + column).ravel() % 2 == 0)
    start = every[np.sort(first)]
    return Sewn(
        tuple(panels), tuple(ids), start, np.concatenate(quads), np.concatenate(st),
        np.concatenate(panel), np.concatenate(even),
    )  # fmt: skip


def body_of(sewn: Sewn, fabric: Fabric, pinned: NDArray[np.bool_] | None = None) -> Body:
    """Return what relaxes as `sewn`; quads are cut along either diagonal by turns.

    With an even number of rows and columns no triangle lies in a corner with all its edges sewn.
    """
    cuts = np.where(sewn.even[:, None], (0, 1, 2, 0, 2, 3), (0, 1, 3, 1, 2, 3))
    triangles = np.take_along_axis(sewn.quads, cuts, axis=1).reshape(-1, 3)
    pattern = np.take_along_axis(sewn.st, cuts[..., None], axis=1).reshape(-1, 3, 2)
    if pinned is None:
        pinned = np.zeros(len(sewn.start), bool)
    return make_body(triangles, pattern, fabric, pinned)


def refined(coarse: Sewn, positions: Doubles, fine: Sewn) -> Doubles:
    """Return a start for `fine`, of the same panels in twice the rows and columns."""
    start = np.empty_like(fine.start)
    for mine, theirs in zip(coarse.ids, fine.ids, strict=True):
        start[theirs] = _doubled(np.swapaxes(_doubled(positions[mine]), 0, 1)).swapaxes(0, 1)
    return start


def settled(
    pieces: Callable[[Any], list[Panel]], cells: Any, fabric: Fabric, solids: Colliders,
    first: list[Phase], then: list[Phase], *, friction: float = 0.4,
    pinned: Callable[[Sewn], NDArray[np.bool_]] | None = None,
) -> tuple[Sewn, Doubles]:  # fmt: skip
    """Return `pieces(cells)` sewn, and its vertices at rest.

    Half the cells fall through the phases `first`, all of them go on from there through `then`.
    `pinned` says which vertices never move.
    """
    coarse, fine = sew(pieces(cells // 2)), sew(pieces(cells))
    held = (None, None) if pinned is None else (pinned(coarse), pinned(fine))
    fallen = relax(body_of(coarse, fabric, held[0]), coarse.start, first, solids, friction)
    start = refined(coarse, fallen, fine)
    rest = relax(body_of(fine, fabric, held[1]), start, then, solids, friction, fine.start)
    return fine, rest


def normals(quads: Indices, positions: Doubles) -> Doubles:
    """Return the unit normals (V, 3) of vertices, the mean of their faces by area."""
    a, b, c, d = (positions[quads[:, k]] for k in range(4))
    facing = np.cross(c - a, d - b)
    total = np.zeros_like(positions)
    for k in range(4):
        np.add.at(total, quads[:, k], facing)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    # At a sharp corner front and back may cancel: there the normal points away from the middle.
    outward = positions - positions.mean(axis=0)
    total = np.where(length > 1e-12, total, outward)
    return total / np.linalg.norm(total, axis=1, keepdims=True)


def _corners(grid: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return the four corners (rows - 1, columns - 1, 4, …) of a grid's cells."""
    return np.stack((grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]), axis=2)


def _doubled(grid: Doubles) -> Doubles:
    """Return the rows of a grid with their means between them."""
    between = 0.5 * (grid[:-1] + grid[1:])
    result = np.empty((2 * len(grid) - 1, *grid.shape[1:]))
    result[::2], result[1::2] = grid, between
    return result
