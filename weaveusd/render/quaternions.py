"""Quaternions and rotations, many at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


def rotations(quaternions: Doubles) -> Doubles:
    """Return the rotations (N, 3, 3) of quaternions (N, 4) as x, y, z, w; none for those of 0."""
    length = np.linalg.norm(quaternions, axis=1, keepdims=True)
    unit = np.where(length > 0, quaternions / np.where(length > 0, length, 1), (0.0, 0, 0, 1))
    x, y, z, w = unit.T
    matrix = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return np.moveaxis(np.array(matrix), 2, 0)


def quaternions(rotations: Doubles) -> Doubles:
    """Return unit quaternions (N, 4) as x, y, z, w of rotations (N, 3, 3).

    The products of a quaternion's components are sums of the matrix's; the row of the largest
    one is the quaternion but for its length.
    """
    m = rotations
    x, y, z = m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]
    products = np.empty((len(m), 4, 4))
    products[:, range(4), range(4)] = np.stack(
        (1 + x - y - z, 1 - x + y - z, 1 - x - y + z, 1 + x + y + z), axis=1
    )
    for i, j, value in (
        (0, 1, m[:, 1, 0] + m[:, 0, 1]),
        (0, 2, m[:, 2, 0] + m[:, 0, 2]),
        (1, 2, m[:, 2, 1] + m[:, 1, 2]),
        (0, 3, m[:, 2, 1] - m[:, 1, 2]),
        (1, 3, m[:, 0, 2] - m[:, 2, 0]),
        (2, 3, m[:, 1, 0] - m[:, 0, 1]),
    ):
        products[:, i, j] = products[:, j, i] = value
    largest = np.argmax(products[:, range(4), range(4)], axis=1)
    row = products[np.arange(len(m)), largest]
    return np.asarray(row / np.linalg.norm(row, axis=1, keepdims=True))
