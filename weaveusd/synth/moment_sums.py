"""Adding up the moment maps of a cloth, row by row of its textures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.synth.boxes import columns_of
from weaveusd.synth.kinds import kinds_of
from weaveusd.synth.moment_rows import ROOM, sum_rows
from weaveusd.synth.moments import ALBEDO, MOMENTS, SHARE, TEXTURES, MomentMaps, sections

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.cloth.model import Weave
    from weaveusd.synth.model import Band

    Doubles = NDArray[np.float64]


class MomentSums:
    """The moment maps of a cloth while its textures are added to them, from the top row down.

    Maps are of `width` × `height` texels, each the exact mean of the textures under it, which
    need not be a whole number of texels; `texture_size` is theirs, width and height. A is the base
    color times the yarn's factor, but at most 1, as the BSDF has it; `gains` are the factors of
    `weave.yarns`, by default 1. The same textures give the same bits for any bands. Memory is
    that of the maps. Raises ValueError unless the maps have at least one texel and no more than
    the textures either way.
    """

    __slots__ = (
        "_added",
        "_columns",
        "_done",
        "_kinds",
        "_sections",
        "_sums",
        "_tables",
        "_texels",
    )

    def __init__(
        self,
        weave: Weave,
        texture_size: tuple[int, int],
        *,
        width: int,
        height: int,
        gains: Sequence[float] | None = None,
    ) -> None:
        across, along = self._texels = texture_size
        if not (1 <= width <= across and 1 <= height <= along):
            raise ValueError(f"{width} × {height} texels, expected 1 × 1 to {across} × {along}")
        self._sections = sections(weave)
        self._kinds = kinds_of(weave, weft=False), kinds_of(weave, weft=True)
        of_yarn = np.maximum(*(np.array(kinds.of_yarn) for kinds in self._kinds))
        self._tables = (
            np.array([section.flatness for section in self._sections]),
            np.array([section.curvature for section in self._sections]),
            np.ones(len(of_yarn)) if gains is None else np.asarray(gains, float),
            of_yarn,
        )
        self._columns = columns_of(across, width)
        channels = SHARE + max(len(kinds.optics) for kinds in self._kinds)
        self._done = np.zeros((2, height, width, channels), np.float32)
        # The row of the maps that is open, and what a row of texels adds to it.
        self._sums = np.zeros((2, width, channels)), np.zeros((2, width, channels))
        self._added = 0

    def add(self, rows: Band) -> None:
        """Add the next rows, the highest y first, of the channels that `TEXTURES` names.

        Raises ValueError for more rows than the textures have, or others.
        """
        across, along = self._texels
        count = len(rows["opacity"])
        if self._added + count > along or rows["opacity"].shape[1] != across:
            raise ValueError(
                f"rows {self._added} to {self._added + count} of {rows['opacity'].shape[1]} "
                f"texels, expected at most {along} of {across}"
            )
        channels = (np.ascontiguousarray(rows[name]).reshape(count, -1) for name in TEXTURES)
        room = np.empty(ROOM)
        sum_rows(
            self._added, along, *channels, *self._tables, *self._columns, self._done,
            *self._sums, room,
        )  # fmt: skip
        self._added += count

    def maps(self) -> tuple[MomentMaps, MomentMaps]:
        """Return the maps of warp and weft; raises ValueError unless every row was added."""
        if self._added != self._texels[1]:
            raise ValueError(f"{self._added} rows, expected {self._texels[1]}")
        warp, weft = (self._maps(system) for system in range(2))
        return warp, weft

    def _maps(self, system: int) -> MomentMaps:
        done = self._done[system, ::-1]
        done.flags.writeable = False
        optics = self._kinds[system].optics
        return MomentMaps(
            bool(system),
            self._sections[system],
            done[..., :MOMENTS],
            done[..., ALBEDO:SHARE],
            done[..., SHARE : SHARE + len(optics)],
            optics,
        )
