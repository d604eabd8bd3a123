"""Whether a rendered swatch has the color that its yarns predict."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from weaveusd.errors import StageError
from weaveusd.validate.color_difference import delta_e_2000
from weaveusd.validate.exhibits import Exhibit, of_linear
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.prediction import TILT_DEG, TURNS_DEG, Census, swatch_color
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

COLOR = Code("swatch-color", Status.FAIL, "A flat swatch renders in another color than predicted.")
REFUSED = Code("render-refused", Status.FAIL, "The translator refuses the asset.")


@check(
    id="render/swatch",
    why="What is signed is a color: the published files have to render in it, not near it.",
    needs=("material", "shader", "textures", "renderer"),
    codes=(COLOR, REFUSED),
)
class Swatch:
    """Lit from all around, a flat swatch has the mean color of its yarns, cover and gloss."""

    def __init__(self, asset: OpenAsset) -> None:
        self._asset = asset
        self._census = Census()

    def look(self, band: Band) -> None:
        """Take stock of the yarns."""
        self._census.look(band)

    def findings(self) -> Iterator[Finding]:
        """Render the swatch and compare its mean color."""
        from weaveusd.validate.trial import Setting, trials

        expected = swatch_color(self._asset, self._census)
        if expected is None:
            return  # attribute/yarns and attribute/optics report it
        profile = self._asset.profile
        where = str(self._asset.material.GetPath())
        try:
            with trials(self._asset) as trial:
                pictures = [
                    trial.render(Setting(TILT_DEG, turn), spp=profile.spp, seed=k).image
                    for k, turn in enumerate(TURNS_DEG)
                ]
        except StageError as error:
            yield REFUSED(str(error), where)
            return
        found = np.mean([picture.mean(axis=(0, 1)) for picture in pictures], axis=0)
        apart = float(delta_e_2000(found, expected))
        told = f"renders as {_text(found)}, predicted is {_text(expected)}: ΔE2000 {apart:.2f}"
        self._asset.shown["swatch"] = Exhibit(
            "Renders", "Swatch, lit from all around, seen from 8°", told, of_linear(pictures[0])
        )
        if apart > profile.delta_e:
            yield COLOR(f"{told}, expected at most {profile.delta_e:g}", where)


def _text(color: np.ndarray) -> str:
    return "(" + ", ".join(f"{component:.3f}" for component in color) + ")"
