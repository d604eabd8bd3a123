"""Whether the optics of every yarn are such that the exact model is defined."""

from __future__ import annotations

import math
from collections.abc import Iterator

from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

OPTICS = Code("optics", Status.FAIL, "An optical number of a yarn leaves the model undefined.")

OPEN_LIMITS: dict[str, tuple[float, float]] = {
    "eta": (1.0, math.inf),
    "gammaS": (0.0, math.pi / 2),
    "gammaV": (0.0, math.pi / 2),
    "normalization": (0.0, math.inf),
    "albedoGain": (0.0, math.inf),
}
"""Limits that a number may not even touch: at an index of 1 nothing reflects, a lobe of no
width is a mirror, and a volume lobe of no weight has no color."""


@check(
    id="attribute/optics",
    why="Beyond these limits the reflectance divides by zero or turns negative.",
    needs=("material",),
    codes=(OPTICS,),
)
def yarn_optics(asset: OpenAsset) -> Iterator[Finding]:
    """Every yarn has an index above 1, lobes of some width and a positive normalization."""
    for yarn in asset.yarns:
        for name, (low, high) in OPEN_LIMITS.items():
            value = asset.yarn(yarn, name)
            if isinstance(value, float) and not low < value < high:
                yield OPTICS(
                    f"{name} of {yarn} is {value:g}, expected more than {low:g}"
                    + (f" and less than {high:g}" if math.isfinite(high) else ""),
                    str(asset.material.GetPath()),
                )
