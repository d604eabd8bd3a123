"""Whether the moment maps are whole, and hold what means of yarn can be."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import KINDS, SYSTEMS, TEXTURE_DIR, moment_file
from weaveusd.errors import InputError
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.moment_maps import (
    expected_maps,
    format_fault,
    kinds_of,
    map_header,
    read_map,
)
from weaveusd.validate.moments import STRAIGHT
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Mask = NDArray[np.bool_]
    Maps = Mapping[str, Doubles]

UNREADABLE = Code(
    "moments-unreadable", Status.FAIL, "A moment map is missing, too large or does not decode."
)
FORMAT = Code(
    "moments-format", Status.FAIL, "A moment map has another format, or another size than others."
)
RANGE = Code("moments-range", Status.FAIL, "A moment map holds what no mean of yarn can be.")

RELATIVE, TINY = 2.0**-10, 2.0**-24
"""Half floats are off by half of this, of their value and where they are too small for that."""


@check(
    id="texture/moments",
    why="A mean that no yarn can have is light from nowhere, seen only from afar.",
    needs=("material", "shader", "moments"),
    codes=(UNREADABLE, FORMAT, RANGE),
)
def moment_ranges(asset: OpenAsset) -> Iterator[Finding]:
    """Every moment map decodes, those of a system in one size, and holds means of yarns."""
    covered: list[Doubles] = []
    for system in SYSTEMS:
        faults = list(_faults(asset, system))
        yield from faults
        if faults:
            continue
        maps = {
            name: read_map(asset, moment_file(system, name)).astype(np.float64)
            for name in expected_maps(asset, system)
        }
        covered.append(maps["albedo"][..., 3])
        with np.errstate(invalid="ignore"):
            laws = list(_laws(maps, len(kinds_of(asset, system))))
        for name, law, kept in laws:
            yield from _finding(asset, moment_file(system, name), law, kept)
    if len(covered) == len(SYSTEMS):
        warp, weft = covered
        if warp.shape != weft.shape:
            yield FORMAT(
                "the maps of the weft have another size than those of the warp", TEXTURE_DIR
            )
            return
        kept = _least(warp) + _least(weft) <= 1
        yield from _finding(asset, moment_file("weft", "albedo"), "with the warp above 1", kept)


def _faults(asset: OpenAsset, system: str) -> Iterator[Finding]:
    """Yield why the maps of `system` cannot be looked at together."""
    sizes = {}
    for name in expected_maps(asset, system):
        file = moment_file(system, name)
        where = asset.short(asset.textures.path(file))
        try:
            header = map_header(asset, file)
            if fault := format_fault(header):
                yield FORMAT(fault, where)
                continue
            read_map(asset, file)
        except InputError as error:
            yield UNREADABLE(str(error).removeprefix(f"{asset.textures.path(file)}: "), where)
            continue
        sizes[file] = header.width, header.height
    if len(set(sizes.values())) > 1:
        told = ", ".join(f"{file} {w} x {h}" for file, (w, h) in sizes.items())
        yield FORMAT(f"the maps of the {system} differ in size: {told}", TEXTURE_DIR)
    elif sizes:
        yield from _size_faults(asset, system, next(iter(sizes.values())))


def _size_faults(asset: OpenAsset, system: str, size: tuple[int, int]) -> Iterator[Finding]:
    stated = asset.cloth("momentWidth"), asset.cloth("momentHeight")
    if None not in stated and stated != size:
        yield FORMAT(
            f"the maps of the {system} have {size[0]} x {size[1]} texels, weave:momentWidth and "
            f"momentHeight say {stated[0]} x {stated[1]}",
            TEXTURE_DIR,
        )
    with suppress(InputError):  # texture/files reports it
        texture = asset.textures.header("yarn_id.png")
        if size[0] > texture.width or size[1] > texture.height:
            yield FORMAT(f"the maps of the {system} are larger than the textures", TEXTURE_DIR)


def _laws(maps: Maps, kinds: int) -> Iterator[tuple[str, str, Mask]]:
    """Yield the map that a law is about, what it is where it is broken, and where it is kept."""
    x = maps["slopes"][..., 3]
    rising, falling = maps["slopes"][..., 1], maps["slopes"][..., 2]
    rising_s, rising_ss, falling_s, falling_ss = np.moveaxis(maps["along"], -1, 0)
    abs_x, square_x, p, square_p = np.moveaxis(maps["across"], -1, 0)
    colors, a = maps["albedo"][..., :3], maps["albedo"][..., 3]

    kept = ((colors >= 0) & (_least(colors) <= _most(a)[..., None])).all(axis=-1)
    yield "albedo", "outside 0 to 1 of their opacity", kept & (a >= 0) & (_least(a) <= 1)
    yield "slopes", "shares of no whole", _are_shares(maps["slopes"][..., :3], a)
    yield "slopes", "further across than from the middle", _least(x) <= _most(abs_x)
    yield "along", "of no yarn that rises", _is_slope(rising, rising_s, rising_ss)
    yield "along", "of no yarn that falls", _is_slope(falling, -falling_s, falling_ss)
    kept = (abs_x >= 0) & _spread(a, abs_x, square_x) & (square_x <= _most(abs_x))
    yield "across", "of no place on a yarn", kept
    yield "across", "of no twist", _spread(a, p, square_p)
    if KINDS in maps:
        unused = (maps[KINDS][..., kinds:] == 0).all(axis=-1)
        yield KINDS, "shares of no whole", _are_shares(maps[KINDS], a) & unused


def _are_shares(shares: Doubles, whole: Doubles) -> Mask:
    """Where `shares`, (…, n), are none below 0 and add up to `whole`."""
    total = shares.sum(axis=-1)
    slack = RELATIVE * (np.abs(total) + np.abs(whole)) + 4 * TINY
    return np.asarray((shares >= 0).all(axis=-1) & (np.abs(total - whole) <= slack))


def _is_slope(share: Doubles, mean: Doubles, square: Doubles) -> Mask:
    """Where `mean` and `square` are of places above `STRAIGHT` on a `share` of the texel."""
    steep = (_most(mean) >= STRAIGHT * share) & (mean >= 0)
    return np.asarray(steep & _spread(share, mean, square) & (square <= _most(mean)))


def _spread(weight: Doubles, mean: Doubles, square: Doubles) -> Mask:
    """Where `mean` and `square` are w·E[v] and w·E[v²] of numbers v within ±1, w = `weight`.

    E[v]² ≤ E[v²] ≤ 1, after Cauchy and Schwarz.
    """
    return np.asarray(
        (square >= 0)
        & (_least(square) <= _most(weight))
        & (_least(mean) ** 2 <= _most(square) * _most(weight))
    )


def _least(values: Doubles) -> Doubles:
    """Return the least absolute value that rounds to `values`."""
    return np.maximum(np.abs(values) * (1 - RELATIVE) - TINY, 0)


def _most(values: Doubles) -> Doubles:
    """Return the largest absolute value that rounds to `values`."""
    return np.abs(values) * (1 + RELATIVE) + TINY


def _finding(asset: OpenAsset, file: str, law: str, kept: Mask) -> Iterator[Finding]:
    """Yield a finding where `kept` does not hold; comparisons with what is no number do not."""
    count = int(np.count_nonzero(~kept))
    if count:
        row, column = np.argwhere(~kept)[0]
        texels = "texel is" if count == 1 else "texels are"
        where = asset.short(asset.textures.path(file))
        yield RANGE(
            f"{count} {texels} {law}; the first at column {column}, row {row} from the top", where
        )
