"""A weave and its textures become a material."""

from __future__ import annotations

from typing import TYPE_CHECKING

from weaveusd.shading.fits import fit_standard
from weaveusd.shading.material import ClothMaterial, Provenance
from weaveusd.shading.measured import measured, texels_of
from weaveusd.shading.normalization import normalization

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.synth.model import TextureSet


def shade(name: str, weave: Weave, textures: TextureSet, provenance: Provenance) -> ClothMaterial:
    """Return the material of `weave`: N_V and gain of every yarn and the standard shaders' fit."""
    n_v = tuple(
        normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v)
        for o in (yarn.optics for yarn in weave.yarns)
    )
    texels = texels_of(weave, textures)
    gains = measured(weave, texels)
    fits = fit_standard(weave, texels, gains)
    return ClothMaterial(name, weave, textures, n_v, gains, fits, provenance)
