"""Whether fibres lie in the surface of their yarn."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.validate.checks._texels import Tally
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

NOT_ORTHOGONAL = Code(
    "frame-not-orthogonal",
    Status.FAIL,
    "The tangent of a texel is not at right angles to its normal.",
)

TOLERANCE = 4e-3
"""Half floats of both vectors change their product by at most 1.7e-3."""


@check(
    id="texture/orthogonal",
    why="The highlight follows the tangent: one that leaves the surface lies.",
    needs=("textures",),
    codes=(NOT_ORTHOGONAL,),
)
def orthogonal_frames(asset: OpenAsset) -> Iterator[Finding]:
    """Tangents are at right angles to normals."""
    for suffix in (".exr", ".png"):
        normal, tangent = f"normal{suffix}", f"tangent{suffix}"
        tally = Tally()
        for band in asset.textures.bands(normal, tangent):
            product = np.einsum("rwc,rwc->rw", band.vectors(normal), band.vectors(tangent))
            tally.add(band.first, np.abs(product) > TOLERANCE, product)
        yield from tally.report(NOT_ORTHOGONAL, tangent, "not at right angles to the normal")
