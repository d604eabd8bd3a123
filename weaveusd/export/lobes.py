"""Lobes as matrices: those of a cloth's yarns, and what leads from their mean to the tile's fit.

A lobe with the roughnesses α_t towards φ and α_b beside it is the symmetric matrix
``A = R diag(α_t, α_b) Rᵀ``, R turning by φ. Means of such matrices are linear and no angle wraps
in them: a warp and a weft of equal lobes have a round one between them, not a sharp one along
the diagonal.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from weaveusd.export.lobe_texels import (
    EVEN,
    MEAN,
    SQUARES,
    TILT_X,
    TILT_Y,
    TILTS,
    TURN_X,
    TURN_Y,
    WEIGHT,
)
from weaveusd.export.standard import standard_shading

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.shading.material import FitsAfar, StandardFits

    Floats = NDArray[np.float32]


ALIKE = 1e-5
"""Variance of lobes that is none: a difference of floats."""


class Matrix(NamedTuple):
    """A symmetric matrix of two rows that is positive definite."""

    xx: float
    xy: float
    yy: float

    @property
    def det(self) -> float:
        """The determinant."""
        return self.xx * self.yy - self.xy**2


class YarnLobes(NamedTuple):
    """What the lobe maps say of each yarn, (yarns,) each."""

    roughness: Floats  # of OpenPBR
    mean: Floats  # (α_t + α_b) / 2
    stretch: Floats  # (α_t − α_b) / (α_t + α_b)
    even: Floats  # α of the lobe that knows no direction
    preview_roughness: Floats  # of that lobe


def yarn_lobes(fits: StandardFits) -> YarnLobes:
    """Return the lobes of each yarn in `fits`.

    Raises
    ------
    ValueError
        A fit is out of range.
    """
    rows = []
    for fit, even in zip(fits.yarns, fits.isotropic_yarns, strict=True):
        shading, mean = standard_shading(fit), (fit.alpha_across + fit.alpha_along) / 2
        # With a = 1 − α_b/α_t.
        stretch = shading.openpbr_anisotropy / (2 - shading.openpbr_anisotropy)
        rough = shading.openpbr_roughness, standard_shading(even).preview_roughness
        rows.append((rough[0], mean, stretch, even.alpha_across, rough[1]))
    return YarnLobes(*np.array(rows, np.float32).T.copy())


def towards(top: Floats, fits: StandardFits) -> Floats:
    """Return what `lobe_texels.fill_lobes` needs to reach the fit of the tile, (7,).

    `top` are the moments of the whole tile. With A the mean lobe of its texels and F the fitted
    one, G is the symmetric matrix for which ``G A G = F``, the geometric mean of A⁻¹ and F.
    """
    weight = float(top[WEIGHT])
    mean, turn_x, turn_y, even = (float(top[k]) / weight for k in (MEAN, TURN_X, TURN_Y, EVEN))
    tilt_x, tilt_y, tilts = (float(top[k]) / weight for k in (TILT_X, TILT_Y, TILTS))
    found = Matrix(mean + turn_x, turn_y, mean - turn_x)
    g = geometric_mean(inverse(found), fitted(fits.afar))
    of_normals = max(0.0, tilts - tilt_x**2 - tilt_y**2)
    squares = float(top[SQUARES]) / weight
    of_lobes = squares - mean**2 - turn_x**2 - turn_y**2
    least = min(fit.alpha_along for fit in (*fits.yarns, *fits.isotropic_yarns, fits.afar.openpbr))
    factor = fits.afar.preview.alpha_across / even
    return np.array(
        [*g, of_normals, of_lobes if of_lobes > ALIKE else 0.0, factor, least], np.float32
    )


def fitted(afar: FitsAfar) -> Matrix:
    """Return the lobe that stands for the tile: wide across the fibres of its system."""
    along, across = afar.openpbr.alpha_along, afar.openpbr.alpha_across
    return Matrix(across, 0.0, along) if afar.fibres == "warp" else Matrix(along, 0.0, across)


def inverse(m: Matrix) -> Matrix:
    """Return M⁻¹."""
    return Matrix(m.yy / m.det, -m.xy / m.det, m.xx / m.det)


def geometric_mean(a: Matrix, b: Matrix) -> Matrix:
    """Return the symmetric matrix G for which ``G A⁻¹ G = B``.

    Of matrices of two rows it is ``sqrt(α β) (A/α + B/β) / sqrt(det(A/α + B/β))`` with α and β the
    roots of their determinants (Bhatia 2007, Positive Definite Matrices, 4.1.12).
    """
    alpha, beta = math.sqrt(a.det), math.sqrt(b.det)
    total = Matrix(*(x / alpha + y / beta for x, y in zip(a, b, strict=True)))
    scale = math.sqrt(alpha * beta / total.det)
    return Matrix(*(scale * x for x in total))
