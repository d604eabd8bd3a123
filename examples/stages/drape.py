"""A square of cloth that falls over a ball: position-based dynamics in NumPy.

After Müller et al. 2007. Lengths in centimetres, seconds for time.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

GRAVITY = 981.0
STEP = 1 / 240
DRAG = 0.995
THICKNESS = 0.02
FRICTION = 0.6

# (rows, columns) from a vertex to its partner, and how much of an error one sweep mends: threads
# hardly stretch, shear gives way, bending is soft.
_LINKS = (((0, 1), 1.0), ((1, 0), 1.0), ((1, 1), 0.25), ((1, -1), 0.25), ((0, 3), 0.06),
          ((3, 0), 0.06))  # fmt: skip


def drape(
    side: float, count: int, center: tuple[float, float, float], radius: float, steps: int
) -> Doubles:
    """Return the vertices (count, count, 3) of a square cloth at rest on a ball.

    The cloth starts flat above the ball, turned a little so that its corners do not fall alike;
    y is up and the floor is y = 0.
    """
    turn = np.radians(17.0)
    line = (np.arange(count) / (count - 1) - 0.5) * side
    x, z = np.meshgrid(line, -line)
    flat = np.stack((x, np.zeros_like(x), z), axis=-1)
    cosine, sine = np.cos(turn), np.sin(turn)
    rotation = np.array(((cosine, 0, sine), (0, 1, 0), (-sine, 0, cosine)))
    middle = np.asarray(center)
    # A ripple of a hundredth of a millimetre lets the cloth decide where to buckle.
    ripple = 1e-3 * np.sin(5 * x + 2 * z) * np.cos(3 * z - x)
    p = flat @ rotation.T + middle + (0, radius + THICKNESS, 0)
    p[..., 1] += ripple
    spacing = side / (count - 1)
    v = np.zeros_like(p)
    for step in range(steps):
        # A shape at rest does not depend on gravity, but what a sweep leaves of a stretch does:
        # the last third hangs in a weak field, slides on the ball and is swept more often.
        settling = step >= 2 * steps // 3
        v[..., 1] -= (0.1 if settling else 1.0) * GRAVITY * STEP
        before = p
        p = p + v * STEP
        for _ in range(40 if settling else 12):
            for (down, right), stiffness in _LINKS:
                _pull(p, down, right, spacing * float(np.hypot(down, right)), stiffness)
            _collide(p, before, middle, radius, 0.02 if settling else FRICTION)
        v = (p - before) / STEP * DRAG
    return p


def _pull(p: Doubles, down: int, right: int, rest: float, stiffness: float) -> None:
    """Bring all vertices that lie (down, right) apart to the distance `rest`, in place.

    Partners are taken in two turns, so that no vertex moves twice at once.
    """
    rows, columns = p.shape[0] - down, p.shape[1] - abs(right)
    first = p[:rows, :columns] if right >= 0 else p[:rows, -right:]
    second = p[down : down + rows, right : right + columns] if right >= 0 else p[down:, :columns]
    reach = max(down, abs(right))
    index = np.arange(rows)[:, None] if down else np.arange(columns)[None, :]
    for turn in (0, 1):
        mine = ((index // reach) % 2 == turn)[..., None]
        gap = second - first
        length = np.sqrt(np.sum(gap * gap, axis=-1, keepdims=True))
        move = gap * (0.5 * stiffness * (length - rest) / np.maximum(length, 1e-9))
        move = np.where(mine, move, 0.0)
        first += move
        second -= move


def _collide(p: Doubles, before: Doubles, center: Doubles, radius: float, friction: float) -> None:
    """Push vertices out of ball and floor, in place, and hold them back where they touch."""
    away = p - center
    distance = np.sqrt(np.sum(away * away, axis=-1, keepdims=True))
    touching = distance < radius + THICKNESS
    outside = center + away * ((radius + THICKNESS) / np.maximum(distance, 1e-9))
    normal = away / np.maximum(distance, 1e-9)
    slip = outside - before
    slip = slip - normal * np.sum(slip * normal, axis=-1, keepdims=True)
    p[...] = np.where(touching, outside - friction * slip, p)
    np.maximum(p[..., 1], THICKNESS, out=p[..., 1])
