"""What a flat swatch should measure, from yarn colors, cover and optics alone.

Geometry d/8°: lit evenly from all around, seen from 8° to the normal, specular included.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.color_space import texels_to_rec709
from weaveusd.validate.checks.energy import yarn_optics_of
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.scattering import YarnOptics, surface_above
from weaveusd.validate.textures import Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

TILT_DEG = 8.0
TURNS_DEG = (0.0, 90.0, 180.0, 270.0)

TEXELS = 128
"""Texels of each yarn whose surface lobe is integrated."""

_CANDIDATES = 64
"""Texels of each yarn that are kept of one band."""


@dataclass(slots=True, eq=False)
class Census:
    """What the textures show of each yarn: its share of the light, and frames of some texels.

    `shares` is the sum of opacities, by yarn id; frames are (N, 6), normal and tangent.
    """

    shares: Doubles = field(default_factory=lambda: np.zeros(256))
    frames: dict[int, list[Doubles]] = field(default_factory=dict)
    texels: int = 0

    def look(self, band: Band) -> None:
        """Take what is needed from a band."""
        ids, opacity = band.pixels["yarn_id.png"][..., 0], band.pixels["opacity.png"][..., 0]
        self.shares += np.bincount(ids.ravel(), opacity.ravel() / 255.0, minlength=256)[:256]
        self.texels += ids.size
        rng = np.random.default_rng(band.first)
        for number in np.unique(ids[ids > 0]).tolist():
            rows, columns = np.nonzero((ids == number) & (opacity > 127))
            if not len(rows):
                continue
            chosen = rng.choice(len(rows), min(_CANDIDATES, len(rows)), replace=False)
            at = rows[chosen], columns[chosen]
            vectors = [
                band.pixels[f"{name}.exr"][at].astype(float) for name in ("normal", "tangent")
            ]
            self.frames.setdefault(int(number), []).append(np.concatenate(vectors, axis=-1))


def swatch_color(asset: OpenAsset, census: Census) -> Doubles | None:
    """Return the mean color (3,) of a swatch on black, linear Rec.709; None where none follows.

    Each yarn counts by its cover: the color that its attribute says is reached, specular
    excluded, and what its surface lobe mirrors from all around.
    """
    total = np.zeros(3)
    for number, yarn in enumerate(asset.yarns, start=1):
        share = census.shares[number] / max(census.texels, 1)
        if not share:
            continue
        reached, optics = asset.yarn(yarn, "colorReached"), yarn_optics_of(asset, yarn)
        frames = census.frames.get(number)
        if reached is None or optics is None or frames is None:
            return None
        color = texels_to_rec709(np.array([*reached]), asset.color_space)
        total += share * (color + mirrored(optics, np.concatenate(frames)))
    return total


def mirrored(optics: YarnOptics, frames: Doubles) -> float:
    """Return the mean share of light that texels of these frames mirror in d/8°."""
    chosen = np.random.default_rng(0).permutation(len(frames))[:TEXELS]
    tilt = math.radians(TILT_DEG)
    found = []
    for normal, tangent in (np.split(frame, 2) for frame in frames[chosen]):
        n = normal / max(float(np.linalg.norm(normal)), 1e-6)
        t = tangent - n * (tangent @ n)
        t /= max(float(np.linalg.norm(t)), 1e-6)
        for turn in np.radians(TURNS_DEG):
            viewer = np.array(
                [math.sin(tilt) * math.sin(turn), -math.sin(tilt) * math.cos(turn), math.cos(tilt)]
            )
            found.append(surface_above(optics, n, t, viewer))
    return float(np.mean(found))
