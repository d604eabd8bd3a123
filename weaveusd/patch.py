"""The patch of cloth that a texture set shows: how many repeats, how many texels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from weaveusd.errors import InputError

if TYPE_CHECKING:
    from weaveusd.draft.model import Draft
    from weaveusd.yarn.model import Recipe

RESOLUTIONS = (8, 1 << 14)
"""Fewest and most texels along the longer side of a published texture."""

DEFAULT_RESOLUTION = 1024
MAX_REPEATS = 4096
MAX_PATCH_MM = 100_000.0
MAX_TEXELS_PER_MM = 10_000.0
MAX_DISTANCE_M = 10_000.0

PIXEL = 0.36e-3
"""Radians that a pixel of the reference camera sees: a lens of 40° on 1920 pixels."""

TEXELS_PER_CROSSING = 12
"""Fewest texels between two threads for a distance: texels are points of yarns, and the mean over
so many of them is within a few percent of the cloth's (docs/lod.md)."""


@dataclass(frozen=True, slots=True)
class Patch:
    """What a user asks for; each of the two sizes in at most one of its ways.

    `resolution` is texels along the longer side, or `texels_per_mm` their density, or
    `distance_m` from where the cloth is looked at: a texel is what a pixel sees there, but small
    enough that the cloth keeps its look. `repeats` of the draft across and along, or `size_mm`, to
    which the nearest whole numbers of repeats are taken. By default one repeat of
    `DEFAULT_RESOLUTION` texels. Irregularity runs through the patch and does not repeat inside it.
    """

    resolution: int | None = None
    texels_per_mm: float | None = None
    repeats: tuple[int, int] | None = None
    size_mm: tuple[float, float] | None = None
    distance_m: float | None = None

    def __post_init__(self) -> None:
        sizes = (self.resolution, self.texels_per_mm, self.distance_m)
        if sum(size is not None for size in sizes) > 1:
            raise InputError("expected a resolution, texels per mm or a distance, one of them")
        if self.repeats is not None and self.size_mm is not None:
            raise InputError("expected repeats or a patch in mm, not both")
        if self.resolution is not None:
            _check("resolution", self.resolution, *RESOLUTIONS)
        if self.texels_per_mm is not None:
            _check("texels per mm", self.texels_per_mm, 1e-3, MAX_TEXELS_PER_MM)
        if self.distance_m is not None:
            _check("distance in m", self.distance_m, 1e-3, MAX_DISTANCE_M)
        for count in self.repeats or ():
            _check("repeats", count, 1, MAX_REPEATS)
        for length in self.size_mm or ():
            _check("patch in mm", length, 1e-3, MAX_PATCH_MM)

    def cut(self, draft: Draft, recipe: Recipe) -> tuple[Draft, int]:
        """Return the draft of the whole patch, and the texels along its longer side.

        Raises InputError when either is out of bounds.
        """
        from weaveusd.draft.transform import repeat

        width = 10 * draft.ends / recipe.ends_per_cm
        height = 10 * draft.picks / recipe.picks_per_cm
        across, along = self.repeats or (1, 1)
        if self.size_mm is not None:
            across = max(1, round(self.size_mm[0] / width))
            along = max(1, round(self.size_mm[1] / height))
        resolution = self.resolution or DEFAULT_RESOLUTION
        density = self.texels_per_mm or self._seen(recipe)[0]
        if density:
            longest = max(across * width, along * height)
            exactly = longest * density
            resolution = round(exactly) if self.distance_m is None else math.ceil(exactly)
            _check(f"texels of a patch {longest:.4g} mm long", resolution, *RESOLUTIONS)
        return repeat(draft, across, along) if (across, along) != (1, 1) else draft, resolution

    def budget(self, recipe: Recipe) -> dict[str, float | str] | None:
        """Return why the texels are as small as they are, as JSON types; None without distance."""
        density, why = self._seen(recipe)
        if self.distance_m is None:
            return None
        return {
            "distance_m": self.distance_m,
            "pixel_rad": PIXEL,
            "texels_per_mm": round(density, 4),
            "why": why,
        }

    def _seen(self, recipe: Recipe) -> tuple[float, str]:
        """Return the texels a millimetre that the distance asks for, 0 without one, and why."""
        if self.distance_m is None:
            return 0.0, ""
        pixel_mm = self.distance_m * 1e3 * PIXEL
        fewest = TEXELS_PER_CROSSING * max(recipe.ends_per_cm, recipe.picks_per_cm) / 10
        if 1 / pixel_mm >= fewest:
            return 1 / pixel_mm, f"a texel is what a pixel sees, {pixel_mm:.3g} mm"
        return fewest, (
            f"a pixel sees {pixel_mm:.3g} mm, but {TEXELS_PER_CROSSING} texels from thread to "
            "thread keep the look"
        )


def _check(what: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise InputError(f"{what}: found {value:g}, expected {low:g} to {high:g}")
