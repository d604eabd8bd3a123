"""Whether the asset makes light in a white furnace."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.errors import StageError
from weaveusd.validate.exhibits import Exhibit, of_linear
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

ABOVE = Code("furnace-above", Status.FAIL, "A pixel of a white furnace is brighter than its light.")

TILTS_DEG = (0.0, 60.0)

LIMIT = 1.01
"""Brightness that a pixel must not pass in both of two renders, so that noise does not count."""


@check(
    id="render/furnace",
    why="Light that is made somewhere shows as a glow that no grading takes away.",
    needs=("material", "shader", "textures", "renderer"),
    codes=(ABOVE,),
)
def white_furnace(asset: OpenAsset) -> Iterator[Finding]:
    """In an even white light from all sides, no pixel of the cloth is above one."""
    from weaveusd.validate.trial import Setting, trials

    brightest = 0.0
    picture = None
    try:
        with trials(asset) as trial:
            for tilt in TILTS_DEG:
                setting = Setting(tilt, bed=False)
                both = [
                    trial.render(setting, spp=asset.profile.spp, seed=seed).image for seed in (0, 1)
                ]
                brightest = max(brightest, float(np.min(both, axis=0).max()))
                picture = both[0] if picture is None else picture
    except StageError:
        return  # render/swatch reports it
    assert picture is not None
    told = f"the brightest pixel is {brightest:.3f} of the light"
    asset.shown["furnace"] = Exhibit("Renders", "White furnace", told, of_linear(picture))
    if brightest > LIMIT:
        yield ABOVE(f"{told}, expected at most {LIMIT:g}", str(asset.material.GetPath()))
