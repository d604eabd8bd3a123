"""Whether normals and tangents are unit vectors on the right side of the cloth."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.validate.checks._texels import Tally
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import TEXTURE_FILES, OpenAsset
from weaveusd.validate.registry import Code, check

LENGTH = Code("vector-not-unit", Status.FAIL, "A normal or tangent is not of unit length.")
SIDE = Code("normal-below", Status.FAIL, "A normal points below the cloth.")

TOLERANCE = 2e-3
"""Rounding each component to a half float changes the length by at most 8.5e-4."""


@check(
    id="texture/unit-vectors",
    why="A vector of another length was filtered, gamma-encoded or stored in other limits.",
    needs=("textures",),
    codes=(LENGTH, SIDE),
)
def unit_vectors(asset: OpenAsset) -> Iterator[Finding]:
    """Normals and tangents have unit length, and normals point out of the face."""
    for file, channel in TEXTURE_FILES.items():
        if channel.encoding != "vector":
            continue
        length, side = Tally(), Tally()
        for band in asset.textures.bands(file):
            vectors = band.vectors(file)
            squared = np.einsum("rwc,rwc->rw", vectors, vectors)
            # Not-a-number is no length at all, but texture/finite reports it.
            length.add(band.first, np.abs(squared - 1) > 2 * TOLERANCE, vectors)
            if channel.name == "normal":
                side.add(band.first, vectors[..., 2] < -TOLERANCE, vectors)
        yield from length.report(LENGTH, file, "no unit vector")
        yield from side.report(SIDE, file, "below the cloth")
