"""A weave and its textures become a material."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.material import ClothMaterial, Provenance, StandardFit
from weaveusd.shading.normalization import normalization

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.synth.model import TextureSet

ALPHA_ACROSS = 0.8
"""GGX roughness across the fibre that suits every fibre best (materialx fits, all presets)."""


def shade(name: str, weave: Weave, textures: TextureSet, provenance: Provenance) -> ClothMaterial:
    """Return the material of `weave`: N_V of every yarn and the standard shaders' fit."""
    n_v = tuple(
        normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v)
        for o in (yarn.optics for yarn in weave.yarns)
    )
    return ClothMaterial(name, weave, textures, n_v, fit(weave), provenance)


def fit(weave: Weave) -> StandardFit:
    """Return parameters of an anisotropic GGX lobe that stands in for the cloth's yarns.

    By the rule that fits the exact model best with one lobe a texel, α along the fibre is
    1.4 tan γ_s, and the reflectance at normal incidence four times that of the fibre: what a
    cylinder spreads over its azimuths a flat texel has to reflect at once. Yarns weigh by the
    crossings on which they are on top.
    """
    on_top = np.concatenate(
        [
            np.bincount(weave.warp_yarn, weave.warp_up.sum(0), len(weave.yarns)),
            np.bincount(weave.weft_yarn, (~weave.warp_up).sum(1), len(weave.yarns)),
        ]
    )
    share = on_top.reshape(2, -1).sum(0) / weave.warp_up.size
    optics = [yarn.optics for yarn in weave.yarns]
    gamma = float(np.dot(share, [o.gamma_s for o in optics]))
    f0 = float(np.dot(share, [o.k_s * float(reflectance(1.0, o.eta)) for o in optics]))
    return StandardFit(
        alpha_along=float(np.clip(1.4 * math.tan(min(gamma, 1.0)), 0.02, ALPHA_ACROSS)),
        alpha_across=ALPHA_ACROSS,
        f0=min(4 * f0, 0.9),
    )
