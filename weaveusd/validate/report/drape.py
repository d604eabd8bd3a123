"""The asset on a draped cloth, in the example scene."""

from __future__ import annotations

import tempfile
from pathlib import Path

from weaveusd.validate.exhibits import Exhibit, of_linear
from weaveusd.validate.open_asset import OpenAsset

SCENE = "cornell_drape"
SHARE = 3
"""Pixels along a side of the picture for one of the profile's, and samples the other way."""


def drape_picture(asset: OpenAsset) -> list[Exhibit]:
    """Return the picture of the scene that wears the asset, with what the translator lost.

    Raises
    ------
    StageError
        The asset cannot be worn, or its cloth is broken.
    RendererUnavailableError
        Nothing renders here.
    """
    from weaveusd.render.run import render
    from weaveusd.render.scenes import dress, scene_path

    profile = asset.profile
    with tempfile.TemporaryDirectory(prefix="weaveusd-") as folder:
        dressed = dress(scene_path(SCENE), asset.entry, Path(folder) / "drape.usda")
        result = render(dressed, width=SHARE * profile.size, spp=max(4, profile.spp // 2))
    losses = "; ".join(str(loss) for loss in result.losses) or "nothing lost in translation"
    return [Exhibit("Renders", "Drape", losses, of_linear(result.image))]
