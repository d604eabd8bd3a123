"""Whether fibres run along their yarn: warp along y, weft along x."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

ACROSS = Code("fibre-across", Status.FAIL, "The fibres of a yarn run across it.")

LARGEST_TWIST = math.radians(40.0)
"""A yarn twisted more has no direction that this check could tell."""


@check(
    id="texture/fibres",
    why="The weft's frame is the warp's turned by 90°; forgetting it turns every highlight.",
    needs=("material", "textures"),
    codes=(ACROSS,),
)
def fibre_directions(asset: OpenAsset) -> Iterator[Finding]:
    """Fibres of the warp run along y and fibres of the weft along x, give or take the twist."""
    squares = np.zeros((2, 256))
    for band in asset.textures.bands("tangent.exr", "yarn_id.png"):
        ids = band.pixels["yarn_id.png"].ravel()
        tangent = band.vectors("tangent.exr").reshape(-1, 3)
        for axis in (0, 1):
            weights = np.square(tangent[:, axis], dtype=np.float64)
            squares[axis] += np.bincount(ids, weights=weights, minlength=256)
    for number, yarn in enumerate(asset.yarns, start=1):
        system, twist = asset.yarn(yarn, "system"), asset.yarn(yarn, "twistAngle")
        if system not in ("warp", "weft") or twist is None or abs(twist) > LARGEST_TWIST:
            continue
        along = squares[1 if system == "warp" else 0, number]
        across = squares[0 if system == "warp" else 1, number]
        if along < across:
            share = across / (along + across)
            yield ACROSS(
                f"{share:.0%} of the direction of {yarn}, a {system} yarn, lies across it",
                f"{TEXTURE_DIR}/tangent.exr",
            )
