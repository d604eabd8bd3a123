"""Whether the maps for standard shaders are the yarns' lobes, near and far."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import LOBE_MAPS, TEXTURE_DIR, lobe_file
from weaveusd.errors import InputError
from weaveusd.validate.checks._levels import Chain, opened_chain
from weaveusd.validate.lobes import (
    HIGH,
    LENGTH,
    LOW,
    ROUGHNESS,
    Spans,
    across_fibres,
    directions,
    narrow_alpha,
)
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check
from weaveusd.validate.textures import Band

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.validate.checks._levels import Floats
    from weaveusd.validate.textures import Pixels

    Place = tuple[int, int]

NONE = Code("lobes-none", Status.SKIP, "There are no lobe maps, as in assets of older versions.")
BROKEN = Code("lobes-broken", Status.FAIL, "A lobe map is missing, does not open or is not tiled.")
LEVELS = Code("lobes-levels", Status.FAIL, "A lobe map lacks levels on the way to one texel.")
OTHER = Code("lobes-disagree", Status.FAIL, "The finest level of a lobe map is not its texture.")
MIXED = Code("lobes-mixed", Status.FAIL, "A yarn has several lobes, or its loose hairs have one.")
TURNED = Code("lobes-turned", Status.FAIL, "Highlights are wide in another direction than across.")
RANGE = Code("lobes-range", Status.FAIL, "A lobe map holds what no lobe can be.")
NARROW = Code("lobes-narrow", Status.FAIL, "From afar highlights are narrower than of any yarn.")

STEP = 1 / 255 / 2 + 2.0**-10
"""Rounding of 8 bits and of half floats."""

UNEVEN = 3.0
"""Levels of 8 bits by which directions of one length may differ in it."""

NARROWEST = 0.8
"""Least α along a highlight's narrow axis from afar, for one of the narrowest yarn."""

ALIGNED = 0.9
"""Least cosine between the rotation of a highlight and what lies across its fibre."""

STRETCHED, SURE = 0.1, 0.05
"""Length of a rotation, and share of a direction in the surface, below which it is not judged."""

FILES = (
    "yarn_id.png", "opacity.png", "roughness.png", "rotation.png", "normal.exr", "tangent.exr",
)  # fmt: skip


@check(
    id="texture/lobes",
    why="A standard shader reads coarse levels from afar: where angles were averaged, it glitters "
    "in a direction that no yarn has.",
    needs=("material", "textures"),
    codes=(NONE, BROKEN, LEVELS, OTHER, MIXED, TURNED, RANGE, NARROW),
)
class Lobes:
    """Lobe maps hold each yarn's lobe, across its fibres, and none that is narrower from afar."""

    def __init__(self, asset: OpenAsset) -> None:
        self._asset = asset
        self._paths = {name: asset.textures.path(lobe_file(name)) for name in LOBE_MAPS}
        listed = {PurePosixPath(file.path).name for file in asset.cloth("textures") or ()}
        self._is_old = listed.isdisjoint(map(lobe_file, LOBE_MAPS)) or not (
            asset.texture_files.keys() >= set(FILES)
        )
        self._spans = Spans()
        self._places: dict[str, list[Place]] = {}
        for name, path in self._paths.items():
            with suppress(InputError), opened_chain(path) as chain:
                self._places[name] = chain.places()
        self._kept: dict[Place, list[Mapping[str, Pixels]]] = {
            place: [] for places in self._places.values() for place in places
        }

    def look(self, band: Band) -> None:
        """Take the lobes of each yarn, and keep the rows that levels are compared with."""
        if self._is_old:
            return
        self._spans.add(*(band.pixels[file] for file in FILES[:4]))
        for (first, end), pieces in self._kept.items():
            rows = slice(max(first - band.first, 0), max(end - band.first, 0))
            pieces.append({file: band.pixels[file][rows].copy() for file in FILES})

    def findings(self) -> Iterator[Finding]:
        """Report maps that are broken, of other yarns, or of no lobes."""
        if self._is_old:
            yield NONE("no lobe maps are listed: standard shaders filter as they may", TEXTURE_DIR)
            return
        yield from self._of_yarns()
        with ExitStack() as stack:
            chains = {}
            for name, path in self._paths.items():
                chain = _opened(path, stack)
                if isinstance(chain, InputError):
                    yield BROKEN(str(chain), self._where(lobe_file(name)))
                    continue
                faults = list(self._judge(name, chain))
                yield from faults
                if not faults:
                    chains[name] = chain
            if len(chains) == len(self._paths):
                yield from self._from_afar(chains)

    def _of_yarns(self) -> Iterator[Finding]:
        """Judge the textures of which the maps are the levels."""
        for number, name in enumerate(self._asset.yarns, start=1):
            roughness, length = self._spans.of_yarn[number]
            if roughness[HIGH] > roughness[LOW] or length[HIGH] > length[LOW] + UNEVEN:
                told = f"roughnesses of {roughness[LOW] / 255:.3f} to {roughness[HIGH] / 255:.3f}"
                told += f", directions {length[LOW] / 127.5:.3f} to {length[HIGH] / 127.5:.3f} long"
                yield MIXED(f"{name} has {told}", self._where("roughness.png"))
        if self._spans.loose:
            message = f"{self._spans.loose} texels that are not opaque have a lobe"
            yield MIXED(message, self._where("roughness.png"))
        turned = sum(_turned(self._rows(place)) for place in self._kept)
        if turned:
            message = f"{turned} texels of those looked at are not wide across their fibre"
            yield TURNED(message, self._where("rotation.png"))

    def _judge(self, name: str, chain: Chain) -> Iterator[Finding]:
        """Judge the levels of one map by themselves."""
        where = self._where(lobe_file(name))
        header = self._asset.textures.header("yarn_id.png")
        size, components = (header.width, header.height), LOBE_MAPS[name].components
        if (chain.sizes[0], chain.channels) != (size, components):
            yield OTHER(
                f"is {chain.sizes[0]} of {chain.channels} channels, expected {size} of "
                f"{components}",
                where,
            )
            return
        if fault := chain.fault():
            yield LEVELS(fault, where)
        worst = 0.0
        for place in self._places.get(name, ()):
            found = chain.rows(0, *place)
            expected = _finest(name, self._rows(place), found)
            apart = np.abs(found - expected).max() if found.size else np.nan
            worst = max(worst, float(apart)) if np.isfinite(apart) else np.inf
        if worst > STEP * components:
            yield OTHER(f"is off by {worst:.3g} on the finest level", where)
        for level, texels in chain.small():
            size = np.linalg.norm(texels.astype(np.float64), axis=-1)
            if texels.size == 0 or not ((size > 0) & (size <= 1 + STEP)).all():
                yield RANGE(f"level {level} has values outside 0 to 1", where)

    def _from_afar(self, chains: Mapping[str, Chain]) -> Iterator[Finding]:
        """Judge how wide the coarse lobes are, by the narrowest yarn."""
        spans = self._spans.seen()
        narrowest = narrow_alpha(
            spans[:, ROUGHNESS, LOW] / 255, spans[:, LENGTH, HIGH] / 127.5
        ).min(initial=1.0)
        for (level, rough), (_, turn) in zip(
            chains["roughness"].small(), chains["rotation"].small(), strict=False
        ):
            if rough.shape[:2] != turn.shape[:2]:
                return
            length = np.linalg.norm(turn[..., :2].astype(np.float64), axis=-1)
            found = narrow_alpha(rough[..., 0].astype(np.float64), length).min(initial=1.0)
            if not found >= NARROWEST * narrowest:
                yield NARROW(
                    f"on level {level} there are lobes of α {found:.3g}, of the narrowest yarn it "
                    f"is {narrowest:.3g}",
                    self._where(lobe_file("roughness")),
                )
                return

    def _rows(self, place: Place) -> Mapping[str, Pixels]:
        pieces = self._kept[place]
        return {file: np.concatenate([piece[file] for piece in pieces]) for file in FILES}

    def _where(self, file: str) -> str:
        return self._asset.short(self._asset.textures.path(file))


def _opened(path: Path, stack: ExitStack) -> Chain | InputError:
    try:
        return stack.enter_context(opened_chain(path))
    except InputError as error:
        return error


def _finest(name: str, rows: Mapping[str, Pixels], found: Floats) -> NDArray[np.float64]:
    """Return what `found`, rows of the finest level of a map, should be."""
    if name == "roughness":
        return np.asarray(rows["roughness.png"] / 255)
    if name == "rotation":
        return directions(rows["rotation.png"])
    # No texture holds the even lobes: the first texel of each yarn says what its others are.
    opaque = rows["opacity.png"][..., 0] == 255
    ids = np.where(opaque, rows["yarn_id.png"][..., 0], 0)
    numbers, first, of_texel = np.unique(ids, return_index=True, return_inverse=True)
    of_yarn = np.where(numbers > 0, found.ravel()[first] if found.size else 0.0, 1.0)
    expected = of_yarn[of_texel].reshape(*ids.shape, 1)
    # An opaque gap is for texture/gaps to report.
    return np.where((opaque & (ids == 0))[..., None] & bool(found.size), found, expected)


def _turned(rows: Mapping[str, Pixels]) -> int:
    """Return how many opaque texels are not wide across their fibre."""
    rotation = directions(rows["rotation.png"])[..., :2]
    frames = (rows[file].astype(np.float64) for file in ("normal.exr", "tangent.exr"))
    across, sure = across_fibres(*frames)
    length = np.linalg.norm(rotation, axis=-1)
    judged = (rows["opacity.png"][..., 0] == 255) & (length > STRETCHED) & (sure > SURE)
    cosine = (rotation * across).sum(axis=-1) / np.maximum(length, STRETCHED)
    return int(np.count_nonzero(judged & ~(cosine >= ALIGNED)))
