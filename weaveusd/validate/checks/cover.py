"""Whether the cloth is as open as the material states."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

COVER = Code("cover-disagrees", Status.FAIL, "The share of opaque texels is not the stated cover.")

TOLERANCE = 0.01


@check(
    id="agreement/cover",
    why="How much light falls through a cloth is a number that buyers ask for.",
    needs=("material", "textures"),
    codes=(COVER,),
)
def cover(asset: OpenAsset) -> Iterator[Finding]:
    """The share of the area under yarn is the cover that is stated."""
    stated = asset.cloth("cover")
    if not isinstance(stated, float):
        return  # attribute/cloth reports it
    opaque = texels = 0
    for band in asset.textures.bands("opacity.png"):
        opaque += int(np.count_nonzero(band.pixels["opacity.png"]))
        texels += band.pixels["opacity.png"].size
    if abs(opaque / texels - stated) > TOLERANCE:
        yield COVER(
            f"{opaque / texels:.1%} of the texels are opaque, stated is {stated:.1%}",
            f"{TEXTURE_DIR}/opacity.png",
        )
