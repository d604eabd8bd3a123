"""The moment maps that an asset publishes, read for the levels of its cloth.

Files and numbers are from outside: sizes are looked at before memory is taken, what cannot be meant
is refused, and what strays a little beyond what a mean can be is clipped and told.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdShade

from weaveusd import contract
from weaveusd.errors import StageError
from weaveusd.render.cloth_inputs import image, in_rec709, numbers, value, where
from weaveusd.render.distance_levels import Levels, SystemMaps, make_levels
from weaveusd.render.model import Losses

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

FLATTEST, ROUNDEST = 1e-3, 1e3
"""Limits of thickness over width of a yarn."""

MOST_BENT = 1e3
"""Limit of the thickness of a yarn over its bend."""

VISIBLE = 2e-3
"""Share of a texel from which on clipping is told: half floats near 1 are off by a quarter of it,
and six of them make a coverage."""

_FIRST = "slopes"
_MAP_INPUTS = tuple(
    contract.moment_input(system, name)
    for system in contract.SYSTEMS
    for name in contract.MOMENT_MAPS
)


def read_levels(
    shader: UsdShade.Shader, time: Usd.TimeCode, losses: Losses, yarns: int
) -> Levels | None:
    """Return the levels by the maps that a shader names; None where it names none, which is told.

    `yarns` is the number of yarns that the shader describes.

    Raises
    ------
    StageError
        One line naming the input: a file that is missing, broken, larger than the contract allows
        or of another size than the first, a section or a kind that no yarn has.
    """
    if not any(value(shader, name, time) is not None for name in _MAP_INPUTS):
        losses.approximated(
            shader.GetPrim(), "cloth is shown in full: it has no moment maps to be seen by"
        )
        return None
    warp, weft = (_read(shader, system, time, yarns) for system in contract.SYSTEMS)
    name = contract.moment_input(contract.SYSTEMS[1], _FIRST)
    _check_size(shader, name, weft.maps[_FIRST], warp.maps[_FIRST].shape)
    mended = _mend(warp.maps, weft.maps)
    if mended:
        losses.approximated(
            shader.GetPrim(), f"{mended} texels of the moment maps hold what no mean can be; mended"
        )
    return make_levels(warp, weft)


def _read(shader: UsdShade.Shader, system: str, time: Usd.TimeCode, yarns: int) -> SystemMaps:
    flatness, bend = _section(shader, system, time)
    kinds = _kinds(shader, system, time, yarns)
    maps: dict[str, Floats] = {}
    for name in contract.moment_names(len(kinds)):
        given = contract.moment_input(system, name)
        maps[name] = _map(shader, given, time)
        _check_size(shader, given, maps[name], maps[_FIRST].shape)
    # What is outside Rec.709 is so in the base color too, which tells of it.
    albedo = contract.moment_input(system, "albedo")
    opacity = np.clip(maps["albedo"][..., 3:], 0, 1)
    maps["albedo"][..., :3], _ = in_rec709(shader, albedo, maps["albedo"][..., :3], opacity)
    return SystemMaps(maps, flatness, bend, kinds)


def _map(shader: UsdShade.Shader, name: str, time: Usd.TimeCode) -> Floats:
    """Return a map (rows, columns, 4), row 0 at v = 0."""
    found = image(shader, name, time, 4, most_texels=contract.MAX_MOMENT_TEXELS)
    if not found.is_float:
        raise StageError(
            f"{where(shader, name)}: holds {found.bits}-bit integers, expected half or float"
        )
    return found.pixels[::-1].copy()


def _check_size(
    shader: UsdShade.Shader, name: str, found: Floats, expected: tuple[int, ...]
) -> None:
    if found.shape != expected:
        raise StageError(
            f"{where(shader, name)}: has {found.shape[1]} x {found.shape[0]} texels, "
            f"expected {expected[1]} x {expected[0]} as the other moment maps"
        )


def _section(shader: UsdShade.Shader, system: str, time: Usd.TimeCode) -> tuple[float, float]:
    """Return flatness ρ and bend k of a system's yarns."""
    name = contract.section_input(system)
    section = numbers(shader, name, time, "float2")
    if (
        len(section) != 2
        or not FLATTEST <= section[0] <= ROUNDEST
        or not 0 <= section[1] <= MOST_BENT
    ):
        raise StageError(
            f"{where(shader, name)}: is {_told(section)}, expected a flatness from "
            f"{FLATTEST:g} to {ROUNDEST:g} and a curvature from 0 to {MOST_BENT:g}"
        )
    return section[0], section[1]


def _kinds(shader: UsdShade.Shader, system: str, time: Usd.TimeCode, yarns: int) -> tuple[int, ...]:
    """Return the indices of the yarns that stand for the kinds of a system."""
    name = contract.kinds_input(system)
    kinds = numbers(shader, name, time, "int[]")
    if not 1 <= len(kinds) <= contract.MAX_KINDS or not all(
        k.is_integer() and 1 <= k <= yarns for k in kinds
    ):
        raise StageError(
            f"{where(shader, name)}: is {_told(kinds)}, expected 1 to "
            f"{contract.MAX_KINDS} yarn ids from 1 to {yarns}"
        )
    return tuple(int(k) - 1 for k in kinds)


def _told(found: list[float]) -> str:
    """Return numbers for a message, the first few of them."""
    return f"[{', '.join(f'{number:g}' for number in found[:8])}]"


def _mend(*systems: Mapping[str, Floats]) -> int:
    """Clip maps, in place, to what means can be; return of how many texels that can be seen."""
    changed = np.zeros(systems[0][_FIRST].shape[:2], bool)
    for maps in systems:
        slopes = maps["slopes"]
        _clip(slopes[..., :3], 0, 1, changed)
        rising, falling = slopes[..., 1], slopes[..., 2]
        a = slopes[..., :3].sum(-1)
        zero = np.zeros_like(a)
        _clip(slopes[..., 3], -a, a, changed)
        bounds = {
            "along": ((zero, zero, -falling, zero), (rising, rising, zero, falling)),
            "across": ((zero, zero, -a, zero), (a,) * 4),
            "albedo": ((zero,) * 4, (a,) * 4),
            contract.KINDS: ((zero,) * 4, (a,) * 4),
        }
        for name in maps.keys() & bounds:
            low, high = bounds[name]
            for k in range(4):
                _clip(maps[name][..., k], low[k], high[k], changed)
    covered = sum(maps["slopes"][..., :3].sum(-1) for maps in systems)
    changed |= covered > 1 + VISIBLE
    too_much = np.maximum(covered, 1)[..., None]
    for maps in systems:
        for name in maps:
            np.divide(maps[name], too_much, out=maps[name])
    return int(np.count_nonzero(changed))


def _clip(
    values: Floats, low: Floats | float, high: Floats | float, changed: NDArray[np.bool_]
) -> None:
    """Clip `values` in place, and mark in `changed` the texels of which that can be seen."""
    clipped = np.clip(values, low, high)
    moved = np.abs(clipped - values) > VISIBLE
    changed |= moved.any(-1) if moved.ndim > changed.ndim else moved
    values[...] = clipped
