"""Whether the moment maps are those of the textures beside them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import KINDS, MOMENT_MAPS, SYSTEMS, moment_file
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.moment_maps import SystemMaps, gains_of, optics_of, system_maps
from weaveusd.validate.moments import OTHER_KIND, OTHER_SYSTEM, Remainder
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.validate.textures import Floats32

OTHER = Code(
    "moments-disagree", Status.FAIL, "A moment map is not the mean of the textures beside it."
)

TOLERANCE = 2.0**-8
"""Opacities of 8 bits, and frames and maps of half floats, move no mean by more."""


@check(
    id="agreement/moments",
    why="Maps of last week show another cloth to whoever stands far enough away, and nobody near.",
    needs=("material", "shader", "textures", "moments"),
    codes=(OTHER,),
)
class MomentAgreement:
    """The moment maps are the means of what the textures show below each of their texels."""

    def __init__(self, asset: OpenAsset) -> None:
        self._asset = asset
        header = asset.textures.header("yarn_id.png")
        self._height = header.height
        self._remainders: dict[str, Remainder] = {}
        self._open_kinds: dict[str, bool] = {}
        for system in SYSTEMS:
            maps = system_maps(asset, system)
            if maps is None:
                continue  # shader/moments or texture/moments reports it
            members = _members(asset, maps)
            values = _together(maps)
            if values.shape[0] > header.height or values.shape[1] > header.width:
                continue  # texture/moments reports it
            self._open_kinds[system] = OTHER_KIND in members
            self._remainders[system] = Remainder(
                values,
                is_weft=system == "weft",
                section=(maps.flatness, maps.curvature),
                members=members,
                gains=np.array([0.0, *gains_of(asset), *([0.0] * 255)])[:256],
            )

    def look(self, band: Band) -> None:
        """Take the texels off the maps."""
        for remainder in self._remainders.values():
            remainder.take_off(band, self._height)

    def findings(self) -> Iterator[Finding]:
        """Report the maps of which something is left."""
        for system, remainder in self._remainders.items():
            for first, (name, described) in enumerate(MOMENT_MAPS.items()):
                left = remainder.left[..., 4 * first : 4 * first + 4]
                if name == KINDS and self._open_kinds[system]:
                    left = np.minimum(left, 0)  # which component others add to is the maker's
                excess = np.abs(left) - remainder.loose[..., None]
                # What is no number agrees with nothing.
                wrong = ~(excess <= TOLERANCE)
                if wrong.any():
                    yield _finding(self._asset, system, name, described.components, excess, wrong)


def _finding(
    asset: OpenAsset,
    system: str,
    name: str,
    components: tuple[str, ...],
    excess: Floats32,
    wrong: NDArray[np.bool_],
) -> Finding:
    worst = int(np.argmax(np.where(np.isnan(excess), np.inf, excess)))
    row, column, component = np.unravel_index(worst, excess.shape)
    count = int(np.count_nonzero(wrong.any(axis=-1)))
    return OTHER(
        f"{count} of {wrong[..., 0].size} texels are off the mean of the textures; the worst at "
        f"column {column}, row {row} from the top, by {excess.flat[worst]:.3g} in "
        f"{components[component]}, expected at most {TOLERANCE:.2g}",
        asset.short(asset.textures.path(moment_file(system, name))),
    )


def _together(maps: SystemMaps) -> Floats32:
    """Return the maps side by side, (h, w, 4 for each that there can be)."""
    shape = next(iter(maps.pixels.values())).shape
    absent = np.zeros(shape, np.float16)
    return np.concatenate(
        [maps.pixels.get(name, absent) for name in MOMENT_MAPS], axis=-1, dtype=np.float32
    )


def _members(asset: OpenAsset, maps: SystemMaps) -> NDArray[np.int64]:
    """Return which component of the map of kinds the texels of each yarn id add to, (256,).

    `OTHER_KIND` where no yarn that stands for a kind scatters alike, or there is no such map.
    """
    listed = enumerate(maps.kinds if KINDS in maps.pixels else ())
    optics = optics_of(asset)
    of_kind = {
        optics[number - 1]: k for k, number in reversed([*listed]) if 1 <= number <= len(optics)
    }
    members = np.full(256, OTHER_SYSTEM, np.int64)
    for number, yarn in enumerate(asset.yarns, start=1):
        if asset.yarn(yarn, "system") == maps.system:
            own = of_kind.get(optics[number - 1]) if number <= len(optics) else None
            members[number] = OTHER_KIND if own is None else own
    return members
