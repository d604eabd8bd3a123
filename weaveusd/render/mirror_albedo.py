"""How much a rough mirror reflects in all, tabulated: what its layers leave for those below."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]
    Doubles = NDArray[np.float64]

COSINES, ROUGHNESSES = 32, 32
_POINTS = 64
_LOWEST = 1e-3


@lru_cache(maxsize=1)
def ggx_albedo() -> Floats:
    """Return the shares of F0 and F90 in the albedo of a GGX mirror with Schlick's Fresnel term.

    With ``F = F0 (1 - s) + F90 s`` and ``s = (1 - wi·m)^5`` the directional albedo is
    ``F0 A + F90 B``. A and B are means of ``(1 - s) G2/G1`` and ``s G2/G1`` over visible normals
    (Heitz 2018, *Sampling the GGX distribution of visible normals*), with Smith's
    height-correlated shadowing; no light is scattered twice.

    Returns
    -------
    (32, 32, 2) float32
        A and B; rows are √α from 0 to 1, columns cos θ from 0 to 1, both at the centers of
        texels stretched so that the first and last lie on the ends.
    """
    table = np.empty((ROUGHNESSES, COSINES, 2), np.float32)
    cosines = np.maximum(np.linspace(0, 1, COSINES), _LOWEST)
    for row, root in enumerate(np.linspace(0, 1, ROUGHNESSES)):
        table[row] = _row(cosines, max(root * root, _LOWEST))
    table.setflags(write=False)
    return table


def _row(cosines: Doubles, alpha: float) -> Doubles:
    """Return A and B for every cosine of the view."""
    u1, u2 = (
        a.reshape(1, -1)
        for a in np.meshgrid(
            (np.arange(_POINTS) + 0.5) / _POINTS, (np.arange(_POINTS) + 0.5) / _POINTS
        )
    )
    z = cosines[:, None]
    x = np.sqrt(1 - z * z)
    normal = _visible_normals(x, z, alpha, u1, u2)
    along = normal[0] * x + normal[2] * z
    out_z = 2 * along * normal[2] - z
    weight = np.where(out_z > 0, _shadowing(z, out_z, alpha), 0)
    schlick = np.clip(1 - along, 0, 1) ** 5
    return np.stack([(weight * (1 - schlick)).mean(1), (weight * schlick).mean(1)], axis=1)


def _visible_normals(
    x: Doubles, z: Doubles, alpha: float, u1: Doubles, u2: Doubles
) -> tuple[Doubles, Doubles, Doubles]:
    """Return normals visible from (x, 0, z), x ≥ 0: Heitz 2018, listing 1."""
    length = np.sqrt((alpha * x) ** 2 + z**2)
    vx, vz = alpha * x / length, z / length
    radius, angle = np.sqrt(u1), 2 * np.pi * u2
    t1, t2 = radius * np.cos(angle), radius * np.sin(angle)
    s = (1 + vz) / 2
    t2 = (1 - s) * np.sqrt(np.maximum(1 - t1**2, 0)) + s * t2
    up = np.sqrt(np.maximum(1 - t1**2 - t2**2, 0))
    # The first axis is y, the second is (-vz, 0, vx).
    nx, ny, nz = alpha * (-vz * t2 + vx * up), alpha * t1, np.maximum(vx * t2 + vz * up, 1e-9)
    norm = np.sqrt(nx**2 + ny**2 + nz**2)
    return nx / norm, ny / norm, nz / norm


def _shadowing(z_in: Doubles, z_out: Doubles, alpha: float) -> Doubles:
    """Return G2/G1 of Smith's shadowing, height-correlated."""
    out = np.maximum(z_out, 1e-9)
    lambda_in, lambda_out = (
        (np.sqrt(1 + alpha**2 * (1 - c * c) / (c * c)) - 1) / 2 for c in (z_in, out)
    )
    return np.asarray((1 + lambda_in) / (1 + lambda_in + lambda_out))
