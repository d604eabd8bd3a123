"""Whether the cloth is as open as the material states."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

COVER = Code("cover-disagrees", Status.FAIL, "The mean opacity is not the stated cover.")

TOLERANCE = 0.01


@check(
    id="agreement/cover",
    why="How much light falls through a cloth is a number that buyers ask for.",
    needs=("material", "textures"),
    codes=(COVER,),
)
def cover(asset: OpenAsset) -> Iterator[Finding]:
    """The share of the light that yarns and their hairs catch is the cover that is stated."""
    stated = asset.cloth("cover")
    if not isinstance(stated, float):
        return  # attribute/cloth reports it
    caught = texels = 0
    for band in asset.textures.bands("opacity.png"):
        caught += int(band.pixels["opacity.png"].sum(dtype=np.int64))
        texels += band.pixels["opacity.png"].size
    found = caught / (255 * texels)
    if abs(found - stated) > TOLERANCE:
        yield COVER(
            f"the opacity is {found:.1%} on average, stated is {stated:.1%}",
            f"{TEXTURE_DIR}/opacity.png",
        )
