"""Whether the renderer draws the light of these yarns as its density says."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict

from weaveusd.validate.checks.energy import yarns_by_optics
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

DENSITY = Code("pdf-not-one", Status.FAIL, "The density of sampling a yarn's light is not one.")
SAMPLES = Code(
    "sampling-off", Status.FAIL, "Samples of a yarn's light do not follow their density."
)

ANGLES_DEG = (10.0, 65.0)
"""Angles of the viewer to the normal, between the fibre's direction and across it."""

MOST = 4
"""Kinds of yarn that are tested; others are told from them by numbers alone."""

WHOLE = 0.02
"""Largest difference of ∫ pdf from 1, on the cells of the test."""

SIGNIFICANCE = 1e-4


@check(
    id="optics/sampling",
    why="A sampler that is off renders every picture too bright or too dark, and never ends noisy.",
    needs=("material", "renderer"),
    codes=(DENSITY, SAMPLES),
)
def sampling(asset: OpenAsset) -> Iterator[Finding]:
    """The density of each yarn's sampling is one in all, and its samples follow it."""
    from weaveusd.render import probe

    names = yarns_by_optics(asset)
    where = str(asset.material.GetPath())
    trials = min(len(names), MOST) * len(ANGLES_DEG)
    for optics, yarns in list(names.items())[:MOST]:
        try:
            bsdf = probe.one_texel({name: [value] for name, value in asdict(optics).items()})
        except ValueError:
            continue  # the renderer refuses these numbers: render/swatch reports it
        for angle in ANGLES_DEG:
            tilt, turn = math.radians(angle), math.radians(30)
            wi = (math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), math.cos(tilt))
            found = probe.chi_square(bsdf, wi, samples=asset.profile.samples)
            who = f"{', '.join(yarns[:8])} at {angle:g}°"
            if not abs(found.density - 1) <= WHOLE:
                yield DENSITY(f"of {who} is {found.density:.4f}", where)
            if not found.p_value >= SIGNIFICANCE / trials:
                yield SAMPLES(f"of {who} agree with p = {found.p_value:.2g}", where)
