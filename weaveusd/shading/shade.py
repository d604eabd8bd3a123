"""A weave and its textures become a material."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.material import ClothMaterial, Provenance, StandardFit
from weaveusd.shading.measured import measured
from weaveusd.shading.normalization import normalization

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.synth.model import TextureSet
    from weaveusd.yarn.model import Optics

ALPHA_ACROSS = 0.8
"""GGX roughness across the fibre that suits every fibre best (materialx fits, all presets)."""


def shade(name: str, weave: Weave, textures: TextureSet, provenance: Provenance) -> ClothMaterial:
    """Return the material of `weave`: N_V and gain of every yarn and the standard shaders' fit."""
    n_v = tuple(
        normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v)
        for o in (yarn.optics for yarn in weave.yarns)
    )
    fits = tuple(fit(yarn.optics) for yarn in weave.yarns)
    return ClothMaterial(
        name,
        weave,
        textures,
        n_v,
        measured(weave, textures),
        together(fits, shares(weave)),
        fits,
        provenance,
    )


def fit(optics: Optics) -> StandardFit:
    """Return parameters of an anisotropic GGX lobe that stands in for a yarn's fibres.

    By the rule that fits the exact model best with one lobe a texel, α along the fibre is
    1.4 tan γ_s, and the reflectance at normal incidence four times that of the fibre: what a
    cylinder spreads over its azimuths a flat texel has to reflect at once.
    """
    f0 = optics.k_s * float(reflectance(1.0, optics.eta))
    return StandardFit(
        alpha_along=float(np.clip(1.4 * math.tan(min(optics.gamma_s, 1.0)), 0.02, ALPHA_ACROSS)),
        alpha_across=ALPHA_ACROSS,
        f0=min(4 * f0, 0.9),
    )


def together(fits: tuple[StandardFit, ...], share: Sequence[float]) -> StandardFit:
    """Return one fit for all yarns, each weighing by its share of the face."""
    rows = np.array([(f.alpha_along, f.alpha_across, f.f0) for f in fits])
    along, across, f0 = np.asarray(share) @ rows / np.sum(share)
    return StandardFit(float(min(along, across)), float(across), float(f0))


def shares(weave: Weave) -> tuple[float, ...]:
    """Return the share of all crossings at which each yarn is on top."""
    count = len(weave.yarns)
    warp = np.bincount(weave.warp_yarn, weave.warp_up.sum(0), count)
    weft = np.bincount(weave.weft_yarn, (~weave.warp_up).sum(1), count)
    return tuple(float(s) for s in (warp + weft) / weave.warp_up.size)
