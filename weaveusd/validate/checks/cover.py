"""Whether the cloth is as open as the material states."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

COVER = Code("cover-disagrees", Status.FAIL, "The mean opacity is not the stated cover.")

TOLERANCE = 0.01


@check(
    id="agreement/cover",
    why="How much light falls through a cloth is a number that buyers ask for.",
    needs=("material", "textures"),
    codes=(COVER,),
)
class Cover:
    """The share of the light that yarns and their hairs catch is the cover that is stated."""

    def __init__(self, asset: OpenAsset) -> None:
        self._stated = asset.cloth("cover")
        self._caught = self._texels = 0

    def look(self, band: Band) -> None:
        """Add up the opacities."""
        opacity = band.pixels["opacity.png"]
        self._caught += int(opacity.sum(dtype=np.int64))
        self._texels += opacity.size

    def findings(self) -> Iterator[Finding]:
        """Compare their mean with the cover."""
        if not isinstance(self._stated, float):
            return  # attribute/cloth reports it
        found = self._caught / (255 * self._texels)
        if abs(found - self._stated) > TOLERANCE:
            yield COVER(
                f"the opacity is {found:.1%} on average, stated is {self._stated:.1%}",
                f"{TEXTURE_DIR}/opacity.png",
            )
