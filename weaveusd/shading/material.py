"""The ClothMaterial: everything that an asset says about a cloth, before it is written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.contract import ColorSpace
    from weaveusd.shading.measured import Measured
    from weaveusd.synth.model import TextureSet


@dataclass(frozen=True, slots=True)
class StandardFit:
    """Parameters of the standard shaders for a yarn, or for the yarns of a cloth together.

    `alpha_along` and `alpha_across` are GGX roughnesses along the fibre and across it; the
    highlight is narrow along the fibre. `f0` is the reflectance at normal incidence.
    """

    alpha_along: float
    alpha_across: float
    f0: float


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a cloth comes from, for its attributes."""

    draft_title: str
    draft_sha256: str
    draft_wif: bytes  # the draft as clean WIF, without personal fields
    shafts: int
    recipe: str
    recipe_source: str
    tool_version: str


@dataclass(frozen=True, slots=True, eq=False)
class ClothMaterial:
    """A cloth ready for export.

    `normalization`, `measured` and `yarn_fits` hold N_V, the gain of the albedo and the standard
    shaders' parameters for each yarn of `weave.yarns`, in order; `fit` those of all together, for
    shaders without textures.
    """

    name: str
    weave: Weave
    textures: TextureSet
    normalization: tuple[float, ...]
    measured: tuple[Measured, ...]
    fit: StandardFit
    yarn_fits: tuple[StandardFit, ...]
    provenance: Provenance

    @property
    def color_space(self) -> ColorSpace:
        """Color space of the textures and of the yarns' colors."""
        return self.weave.color_space
