"""The moment maps of a cloth as textures: what an asset states of them, and their files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import KINDS, MOMENT_MAPS, SYSTEMS, Channel, moment_file, moment_names
from weaveusd.export.encode import encode
from weaveusd.export.textures import open_texture
from weaveusd.synth.kinds import kinds_of
from weaveusd.synth.moment_sums import MomentSums
from weaveusd.synth.moments import (
    FALLING,
    FLAT,
    MOMENTS,
    RISING,
    map_size,
    sections,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from weaveusd.cloth.model import Weave
    from weaveusd.contract import ColorSpace, Encoding
    from weaveusd.shading.material import ClothMaterial
    from weaveusd.synth.model import Floats32
    from weaveusd.synth.moments import MomentMaps

COMPONENTS = 4


@dataclass(frozen=True, slots=True)
class SystemMaps:
    """What an asset states of the moment maps of one system."""

    system: str
    names: tuple[str, ...]  # of `contract.MOMENT_MAPS`
    flatness: float
    curvature: float
    kinds: tuple[int, ...]  # ids, from 1, of the yarns that stand for the kinds; at least one

    @property
    def files(self) -> tuple[str, ...]:
        """The texture files, in the order of `names`."""
        return tuple(moment_file(self.system, name) for name in self.names)


def system_maps(weave: Weave) -> tuple[SystemMaps, SystemMaps]:
    """Return what is stated of the maps of warp and weft."""
    found = []
    for weft, (system, section) in enumerate(zip(SYSTEMS, sections(weave), strict=True)):
        kinds = tuple(yarn + 1 for yarn in kinds_of(weave, weft=bool(weft)).yarns)
        names = moment_names(len(kinds))
        found.append(SystemMaps(system, names, section.flatness, section.curvature, kinds))
    warp, weft_maps = found
    return warp, weft_maps


def moment_files(weave: Weave) -> tuple[str, ...]:
    """Return the names of all texture files that the maps of `weave` have."""
    return tuple(file for maps in system_maps(weave) for file in maps.files)


def moment_channel(system: str, name: str) -> Channel:
    """Return the map `name` of `system` as a channel of the textures."""
    encoding: Encoding = "color" if name == "albedo" else "scalar"
    meaning = f"{MOMENT_MAPS[name].meaning}, {system}"
    file = moment_file(system, name)
    return Channel(f"{system}_{name}", COMPONENTS, encoding, "1", (file,), meaning)


def moment_sums(material: ClothMaterial) -> MomentSums:
    """Return the sums of the maps of `material`, to which its textures are yet to be added."""
    size = material.textures.width, material.textures.height
    width, height = map_size(material.weave, size)
    gains = [measured.gain for measured in material.measured]
    return MomentSums(material.weave, size, width=width, height=height, gains=gains)


def write_moment_maps(
    maps: Sequence[MomentMaps],
    folder: Path,
    repeat_mm: tuple[float, float],
    color_space: ColorSpace = "lin_rec709",
) -> None:
    """Write the files of `maps`, one of each system, into `folder`.

    They are EXR of half floats with the components of `contract.MOMENT_MAPS` as RGBA, zip, the
    top row first, wrap modes periodic; the albedo is in `color_space`, all else is data. The same
    maps give the same bytes.

    Raises
    ------
    WeaveusdError
        A file could not be written.
    """
    for system, of_system in zip(SYSTEMS, maps, strict=True):
        for name, values in pictures(of_system).items():
            channel = moment_channel(system, name)
            height, width = values.shape[:2]
            path = folder / channel.files[0]
            with open_texture(path, channel, (width, height), repeat_mm, color_space) as out:
                out.write(encode(channel, path.suffix, values[::-1]))


def pictures(maps: MomentMaps) -> dict[str, Floats32]:
    """Return the maps by the names of the contract, (h, w, 4) each, row 0 at y = 0."""
    count = maps.share.shape[-1]
    flat, rising, falling = (maps.moments[..., [k]] for k in (FLAT, RISING, FALLING))
    found = dict(zip(MOMENT_MAPS, np.split(maps.moments, MOMENTS // COMPONENTS, -1), strict=False))
    found["albedo"] = np.concatenate([maps.albedo, flat + rising + falling], -1)
    if KINDS in moment_names(count):
        found[KINDS] = np.pad(maps.share, ((0, 0), (0, 0), (0, COMPONENTS - count)))
    return found
