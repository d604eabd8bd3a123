"""The TextureSet: the channels of a cloth, produced band by band."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats32 = NDArray[np.float32]

Band = Mapping[str, "Floats32"]
"""Channel name to (rows, width, components) float32; row 0 is the lowest y of the band."""


class BandSource(Protocol):
    """Whatever computes rows of texels; the same rows always come out the same."""

    def __call__(self, first: int, last: int) -> Band:
        """Return the channels of texel rows `first` to `last` - 1, row 0 at y = 0."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class TextureSet:
    """Textures of one repeat: row 0 at y = 0, the first pick; column 0 at x = 0, the first end.

    Channel names, components and meaning are those of `weaveusd.contract.CHANNELS`, without those
    that follow from the yarn alone. Labels count from 0, with `contract.GAP` where there is none.
    """

    width: int
    height: int
    repeat_mm: tuple[float, float]
    seed: int
    band: BandSource

    def whole(self) -> Band:
        """Return all rows at once: {channel: (height, width, components) float32}."""
        return self.band(0, self.height)
