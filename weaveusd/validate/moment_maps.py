"""The moment maps of an asset: which its shader names, and what their files hold.

Files are judged by their headers before memory is taken, pixels as they are stored.
"""

from __future__ import annotations

import math
from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.contract import (
    MAX_KINDS,
    MAX_MOMENT_TEXELS,
    MOMENT_MAPS,
    SHADER_ALBEDO_GAIN,
    SHADER_YARN_INPUTS,
    SYSTEMS,
    kinds_input,
    moment_file,
    moment_names,
    section_input,
)
from weaveusd.errors import InputError
from weaveusd.validate.checks.shader import input_value
from weaveusd.validate.open_asset import OpenAsset

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from weaveusd.validate.textures import Header

    Halves = NDArray[np.float16]

COMPONENTS = 4

MAP_FILES = {moment_file(system, name): name for system in SYSTEMS for name in MOMENT_MAPS}
"""Every texture file of a moment map that there can be, and the name of the map."""


@dataclass(frozen=True, slots=True, eq=False)
class SystemMaps:
    """The maps of a system, all of one size, and how they are to be read.

    `kinds` are ids of yarns, from 1, each of which stands for a kind: for a component of the map
    of kinds, where there is more than one. Row 0 is the image's top row.
    """

    system: str
    flatness: float
    curvature: float
    kinds: tuple[int, ...]
    pixels: Mapping[str, Halves]  # (h, w, 4) by the names of the contract


def expected_maps(asset: OpenAsset, system: str) -> tuple[str, ...]:
    """Return the names of the maps that `system` has to have, by the kinds that it states."""
    return moment_names(len(kinds_of(asset, system)))


def section_of(asset: OpenAsset, system: str) -> tuple[float, float] | None:
    """Return flatness, above 0, and curvature, 0 or more, of `system`, None unless so stated."""
    value = input_value(asset.shader, section_input(system))
    try:
        flatness, curvature = (float(number) for number in value)
    except (TypeError, ValueError):
        return None
    is_sound = math.isfinite(flatness) and flatness > 0 and math.isfinite(curvature)
    return (flatness, curvature) if is_sound and curvature >= 0 else None


def kinds_of(asset: OpenAsset, system: str) -> tuple[int, ...]:
    """Return the ids of yarns that stand for the kinds of `system`; none unless so stated."""
    value = input_value(asset.shader, kinds_input(system))
    try:
        return tuple(int(number) for number in value)[: MAX_KINDS + 1]
    except (TypeError, ValueError):
        return ()


def optics_of(asset: OpenAsset) -> tuple[tuple[float, ...], ...]:
    """Return what the exact shader says of each yarn's scattering, in the order of the ids."""
    values = [_numbers(input_value(asset.shader, name)) for name in SHADER_YARN_INPUTS]
    return tuple(zip(*values, strict=False))


def gains_of(asset: OpenAsset) -> tuple[float, ...]:
    """Return the factors from base color to albedo, of each yarn; 1 where none is stated."""
    stated = _numbers(input_value(asset.shader, SHADER_ALBEDO_GAIN))
    return stated + (1.0,) * (len(asset.yarns) - len(stated))


def map_header(asset: OpenAsset, file: str) -> Header:
    """Return the header of the map `file`.

    Raises
    ------
    InputError
        It is missing, no image, or has more texels than any map; the message is without a path.
    """
    try:
        header = asset.textures.header(file)
    except InputError as error:
        raise InputError(str(error).removeprefix(f"{asset.textures.path(file)}: ")) from None
    if header.width * header.height > MAX_MOMENT_TEXELS:
        raise InputError(
            f"{header.width} x {header.height} texels, expected at most {MAX_MOMENT_TEXELS}"
        )
    return header


def format_fault(header: Header) -> str | None:
    """Return what is wrong with the channels or the type of numbers of a map, None if nothing."""
    if (header.channels, header.dtype) == (COMPONENTS, "float16"):
        return None
    return f"has {header.channels} channels of {header.dtype}, expected 4 of float16"


def read_map(asset: OpenAsset, file: str) -> Halves:
    """Return the texels (h, w, 4) of the map `file`, which is decoded once.

    Raises
    ------
    InputError
        It is none, or does not decode.
    """
    if file not in asset.kept:
        header = map_header(asset, file)
        if fault := format_fault(header):
            raise InputError(fault)
        with ExitStack() as stack:
            asset.kept[file] = asset.textures.open(file, stack).read(0, header.height)
    return asset.kept[file]


def system_maps(asset: OpenAsset, system: str) -> SystemMaps | None:
    """Return the maps of `system`, or None where they cannot be judged together.

    What hinders it is for the checks of shader and files to say.
    """
    section, kinds = section_of(asset, system), kinds_of(asset, system)
    if section is None or len(kinds) > MAX_KINDS:
        return None
    try:
        pixels = {
            name: read_map(asset, moment_file(system, name))
            for name in expected_maps(asset, system)
        }
    except InputError:
        return None
    if len({values.shape for values in pixels.values()}) != 1:
        return None
    return SystemMaps(system, *section, kinds, pixels)


def _numbers(value: Any) -> tuple[float, ...]:
    try:
        return tuple(float(number) for number in value)
    except (TypeError, ValueError):
        return ()
