"""How the fit of a cloth reads in the vocabularies of the standard shaders."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from weaveusd.shading.material import StandardFit


@dataclass(frozen=True, slots=True)
class StandardShading:
    """Inputs of the standard shaders, their tangent being **across** the fibre.

    A standard shader stretches its highlight along its tangent: α is wide there and narrow on
    the other axis. A fibre's highlight is wide across the fibre, so the tangent is the normal
    times the fibre, never the fibre itself.
    """

    ior: float
    base: float
    preview_roughness: float
    openpbr_roughness: float
    openpbr_anisotropy: float
    standard_roughness: float
    standard_anisotropy: float


def standard_shading(fit: StandardFit) -> StandardShading:
    """Translate GGX roughnesses α into each shader's roughness and anisotropy.

    With α_t = `alpha_across` and α_b = `alpha_along`:

    - OpenPBR 1.1: ``α_t = r² sqrt(2 / (1 + (1 - a)²))`` and ``α_b = (1 - a) α_t``, hence
      ``a = 1 - α_b/α_t`` and ``r² = α_t sqrt((1 + (1 - a)²) / 2)``.
    - standard_surface 1.0.1: ``α_t = r²/s``, ``α_b = r² s`` with ``s² = 1 - a``, hence
      ``a = 1 - α_b/α_t`` and ``r² = sqrt(α_t α_b)``.
    - UsdPreviewSurface is isotropic: ``r² = sqrt(α_t α_b)``.

    The index of refraction has `f0` as its reflectance at normal incidence; `base` is the weight
    of the diffuse base in every shader.

    Raises
    ------
    ValueError
        Unless 0 < `alpha_along` ≤ `alpha_across` ≤ 1, 0 ≤ `f0` < 1 and 0 ≤ `base` ≤ 1.
    """
    along, across = fit.alpha_along, fit.alpha_across
    if not 0 < along <= across <= 1:
        raise ValueError(f"expected 0 < alpha_along ≤ alpha_across ≤ 1, got {along} and {across}")
    if not 0 <= fit.f0 < 1:
        raise ValueError(f"expected f0 in 0…1, got {fit.f0}")
    if not 0 <= fit.base <= 1:
        raise ValueError(f"expected base in 0…1, got {fit.base}")
    ratio = along / across
    mean = math.sqrt(along * across)
    root = math.sqrt(fit.f0)
    return StandardShading(
        ior=(1 + root) / (1 - root),
        base=fit.base,
        preview_roughness=math.sqrt(mean),
        openpbr_roughness=math.sqrt(across * math.sqrt((1 + ratio**2) / 2)),
        openpbr_anisotropy=1 - ratio,
        standard_roughness=math.sqrt(mean),
        standard_anisotropy=1 - ratio,
    )
