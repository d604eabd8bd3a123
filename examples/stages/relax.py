"""Cloth at rest: triangles that resist as woven cloth does, stepped until they hang still.

Extended position based dynamics with one sweep a step (Macklin, Müller and Chentanez 2016; Macklin
et al. 2019). A triangle knows its place in the pattern, so what resists is the stretch of warp and
weft and the shear between them (Müller et al. 2014); a hinge resists bending by the quadratic
energy of Bergou et al. 2006, less their factor of 3: on grids of right angles that makes a bend
along either thread cost what it does in theory. Lengths are metres, masses kilograms, times
seconds; y is up.

Sums run in one order, and nothing but + - * / and square roots touches a coordinate: the same
start gives the same rest, to the bit, on any machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import kernels
import numpy as np

if TYPE_CHECKING:
    from colliders import Colliders
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

GRAVITY = 9.81


@dataclass(frozen=True, slots=True)
class Fabric:
    """What a cloth weighs and how it resists."""

    density: float  # kg/m²
    stretch: float  # N/m, along the threads
    shear: float  # N/m, between them
    bend: float  # N m


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """A cloth that can be relaxed."""

    triangles: Indices  # (F, 3) vertices
    slopes: Doubles  # (F, 2, 2) inverse of the triangle's edges in the pattern, 1/m
    areas: Doubles  # (F,) m², in the pattern
    hinges: Indices  # (E, 4) the edge's two vertices, then those opposite to it
    weights: Doubles  # (E, 4) sum of weight · position is the hinge's bend
    spans: Doubles  # (E,) m², area of the hinge's two triangles
    inverse_mass: Doubles  # (V,) 1/kg, 0 where pinned
    fabric: Fabric


@dataclass(frozen=True, slots=True)
class Phase:
    """A stretch of time under the same conditions.

    A filled body is pushed outwards by `pressure` (Pa) · (`volume` / its volume - 1), never
    inwards. With `apart` vertices keep that distance (m) from each other, or that of the layout
    where it is less.
    """

    seconds: float
    step: float = 1 / 1200
    gravity: float = GRAVITY
    drag: float = 1.0  # 1/s
    pressure: float = 0.0
    volume: float = 0.0
    apart: float = 0.0


def make_body(
    triangles: Indices, pattern: Doubles, fabric: Fabric, pinned: NDArray[np.bool_]
) -> Body:
    """Return the body of `triangles` (F, 3) that lie in the pattern at `pattern` (F, 3, 2).

    `pinned` (V,) are the vertices that never move.
    """
    edges = np.stack((pattern[:, 1] - pattern[:, 0], pattern[:, 2] - pattern[:, 0]), axis=-1)
    (a, b), (c, d) = edges[:, 0].T, edges[:, 1].T
    areas = 0.5 * (a * d - b * c)
    if areas.min() <= 0:
        raise ValueError("a triangle is turned over in its pattern")
    mass = np.zeros(len(pinned))
    np.add.at(mass, triangles.ravel(), np.repeat(areas * fabric.density / 3, 3))
    inverse = np.where(pinned, 0.0, 1 / mass)
    # Written out: a library's inverse may differ in its last bit from one processor to the next.
    slopes = np.stack((d, -b, -c, a), axis=-1).reshape(-1, 2, 2) / (2 * areas)[:, None, None]
    hinges, weights, spans = _hinges(triangles, pattern, areas)
    return Body(triangles, slopes, areas, hinges, weights, spans, inverse, fabric)


def relax(
    body: Body, start: Doubles, phases: list[Phase], colliders: Colliders, friction: float = 0.4,
    layout: Doubles | None = None,
) -> Doubles:  # fmt: skip
    """Return the vertices (V, 3) after the phases, from rest at `start`.

    `layout` is where no two vertices are nearer than in the pattern; by default the start.
    """
    positions = start.copy()
    velocities = np.zeros_like(positions)
    for phase in phases:
        kernels.advance(
            positions, velocities, start if layout is None else layout,
            body.triangles, body.slopes, body.areas, body.hinges, body.weights, body.spans,
            body.inverse_mass, colliders.table, friction,
            np.array((body.fabric.stretch, body.fabric.shear, body.fabric.bend)),
            round(phase.seconds / phase.step), phase.step,
            np.array((phase.gravity, phase.drag, phase.pressure, phase.volume, phase.apart)),
        )  # fmt: skip
    return positions


def stretches(body: Body, positions: Doubles) -> Doubles:
    """Return the length (F, 2) of a metre of weft and of warp in each triangle."""
    corners = positions[body.triangles]
    edges = np.stack((corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)
    return np.linalg.norm(edges @ body.slopes, axis=1)


def energy(body: Body, positions: Doubles, gravity: float = GRAVITY) -> float:
    """Return weight, stretch, shear and bend of a body as one energy in joules."""
    corners = positions[body.triangles]
    edges = np.stack((corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)
    gradient = edges @ body.slopes
    stretch = np.sum((np.linalg.norm(gradient, axis=1) - 1) ** 2, axis=1)
    shear = np.sum(gradient[..., 0] * gradient[..., 1], axis=1) ** 2
    bends = np.einsum("ek,ekd->ed", body.weights, positions[body.hinges])
    bend = np.sum(bends**2, axis=1) / body.spans
    free = body.inverse_mass > 0
    weight = gravity * np.sum(positions[free, 1] / body.inverse_mass[free])
    fabric = body.fabric
    elastic = body.areas @ (fabric.stretch * stretch + fabric.shear * shear)
    return float(weight + 0.5 * elastic + 0.5 * fabric.bend * bend.sum())


def _hinges(
    triangles: Indices, pattern: Doubles, areas: Doubles
) -> tuple[Indices, Doubles, Doubles]:
    """Return vertices, weights and areas of the edges that two triangles share.

    A seam lies flat as well: the weights follow from angles alone, each from its own panel.
    """
    first = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    face = np.tile(np.arange(len(triangles)), 3)
    side = np.repeat(np.arange(3), len(triangles))
    low, high = first.min(axis=1), first.max(axis=1)
    order = np.lexsort((face, high, low))
    same = (low[order][1:] == low[order][:-1]) & (high[order][1:] == high[order][:-1])
    one, two = order[:-1][same], order[1:][same]
    hinges = np.empty((len(one), 4), np.int64)
    hinges[:, 0], hinges[:, 1] = first[one, 0], first[one, 1]
    weights = np.zeros((len(one), 4))
    for column, half in ((2, one), (3, two)):
        triangle, corner = face[half], side[half]
        hinges[:, column] = triangles[triangle, (corner + 2) % 3]
        ends = triangles[triangle, corner]
        for turn in (0, 1):
            at = pattern[triangle, (corner + turn) % 3]
            along = pattern[triangle, (corner + 1 - turn) % 3] - at
            away = pattern[triangle, (corner + 2) % 3] - at
            cross = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0]
            cotangent = np.sum(along * away, axis=1) / np.abs(cross)
            # The angle at one end weighs on the other end.
            mine = ends == hinges[:, 0]
            weights[:, 1] += np.where(mine == (turn == 0), cotangent, 0)
            weights[:, 0] += np.where(mine == (turn == 0), 0, cotangent)
            weights[:, column] -= cotangent
    return hinges, weights, areas[face[one]] + areas[face[two]]
