"""The ClothMaterial: everything that an asset says about a cloth, before it is written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.contract import ColorSpace
    from weaveusd.shading.measured import Measured
    from weaveusd.synth.model import TextureSet
    from weaveusd.yarn.model import System


@dataclass(frozen=True, slots=True)
class StandardFit:
    """Parameters of the standard shaders for a yarn, or for the yarns of a cloth together.

    `alpha_along` and `alpha_across` are GGX roughnesses along the fibre and across it; the
    highlight is narrow along the fibre. `f0` is the reflectance at normal incidence, `base` the
    weight of the diffuse base in the yarn's color.
    """

    alpha_along: float
    alpha_across: float
    f0: float
    base: float = 1.0


@dataclass(frozen=True, slots=True)
class FitErrors:
    """How far a shader's reflectance is from the exact cloth's: Σ |f̂ − f| / Σ f of the tile.

    Over pairs of directions that were not fitted. `openpbr` has a lobe for each yarn,
    `standard_surface` one for all yarns, `preview` one for each that knows no direction.
    `openpbr_afar` and `preview_afar` are of the lobes that stand for the whole tile.
    """

    openpbr: float
    standard_surface: float
    preview: float
    openpbr_afar: float
    preview_afar: float


@dataclass(frozen=True, slots=True)
class FitsAfar:
    """The lobes of a flat cloth in the mean color that stand for a tile which is but a texel.

    F0 and base are those of the yarns' lobes. The fibres of `openpbr` lie along the warp or the
    weft, as `fibres` says; `preview` knows no direction.
    """

    openpbr: StandardFit
    fibres: System
    preview: StandardFit


@dataclass(frozen=True, slots=True)
class StandardFits:
    """The fits of a cloth: `yarns` one a yarn, with `f0` and `base` in common; `together` one for
    all; `isotropic` one for all with `alpha_along` = `alpha_across`, and `isotropic_yarns` such
    ones a yarn, with its `f0` and `base`.

    Their lobes lie in the frame of each texel. `afar` are lobes about the cloth's own normal.
    """

    together: StandardFit
    yarns: tuple[StandardFit, ...]
    isotropic: StandardFit
    isotropic_yarns: tuple[StandardFit, ...]
    afar: FitsAfar
    errors: FitErrors


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a cloth comes from, for its attributes."""

    draft_title: str
    draft_sha256: str
    draft_wif: bytes  # the draft as clean WIF; personal fields only where asked for
    shafts: int
    recipe: str
    recipe_source: str
    tool_version: str
    recipe_toml: bytes = b""  # the recipe file as used
    repeats: tuple[int, int] = (1, 1)  # of the draft in the patch: across, along


@dataclass(frozen=True, slots=True, eq=False)
class ClothMaterial:
    """A cloth ready for export.

    `normalization` and `measured` hold N_V and the gain of the albedo for each yarn of
    `weave.yarns`, in order.
    """

    name: str
    weave: Weave
    textures: TextureSet
    normalization: tuple[float, ...]
    measured: tuple[Measured, ...]
    fits: StandardFits
    provenance: Provenance

    @property
    def color_space(self) -> ColorSpace:
        """Color space of the textures and of the yarns' colors."""
        return self.weave.color_space

    @property
    def fit(self) -> StandardFit:
        """The standard shaders' parameters of all yarns together, for a shader without maps."""
        return self.fits.together

    @property
    def yarn_fits(self) -> tuple[StandardFit, ...]:
        """The standard shaders' parameters of each yarn; F0 and the base are common to all."""
        return self.fits.yarns
