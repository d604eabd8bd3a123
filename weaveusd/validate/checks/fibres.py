"""Whether fibres run along their yarn: warp along y, weft along x."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.compiled import compiled
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import HALVES, Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.validate.textures import Floats32, Words

ACROSS = Code("fibre-across", Status.FAIL, "The fibres of a yarn run across it.")

LARGEST_TWIST = math.radians(40.0)
"""A yarn twisted more has no direction that this check could tell."""


@check(
    id="texture/fibres",
    why="The weft's frame is the warp's turned by 90°; forgetting it turns every highlight.",
    needs=("material", "textures"),
    codes=(ACROSS,),
)
class FibreDirections:
    """Fibres of the warp run along y and fibres of the weft along x, give or take the twist."""

    def __init__(self, asset: OpenAsset) -> None:
        self._yarns = [
            (yarn, asset.yarn(yarn, "system"), asset.yarn(yarn, "twistAngle"))
            for yarn in asset.yarns
        ]
        self._squares = np.zeros((2, 256))

    def look(self, band: Band) -> None:
        """Add up the squares of the tangents of each yarn, along x and along y."""
        _add_squares(band.pixels["yarn_id.png"], band.words("tangent.exr"), HALVES, self._squares)

    def findings(self) -> Iterator[Finding]:
        """Report the yarns whose fibres run more across than along."""
        for number, (yarn, system, twist) in enumerate(self._yarns, start=1):
            if system not in ("warp", "weft") or twist is None or abs(twist) > LARGEST_TWIST:
                continue
            along = self._squares[1 if system == "warp" else 0, number]
            across = self._squares[0 if system == "warp" else 1, number]
            if along < across:
                share = across / (along + across)
                yield ACROSS(
                    f"{share:.0%} of the direction of {yarn}, a {system} yarn, lies across it",
                    f"{TEXTURE_DIR}/tangent.exr",
                )


@compiled
def _add_squares(
    ids: NDArray[np.uint8], tangent: Words, table: Floats32, squares: NDArray[np.float64]
) -> None:
    for row in range(ids.shape[0]):
        for column in range(ids.shape[1]):
            number = ids[row, column, 0]
            for axis in range(2):
                component = np.float64(table[tangent[row, column, axis]])
                squares[axis, number] += component * component
