"""The patch of cloth that a texture set shows: how many repeats, how many texels."""

from __future__ import annotations

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


@dataclass(frozen=True, slots=True)
class Patch:
    """What a user asks for; each of the two sizes in at most one of its ways.

    `resolution` is texels along the longer side, or `texels_per_mm` their density; `repeats` of
    the draft across and along, or `size_mm`, to which the nearest whole numbers of repeats are
    taken. By default one repeat of `DEFAULT_RESOLUTION` texels. Irregularity runs through the
    patch and does not repeat inside it.
    """

    resolution: int | None = None
    texels_per_mm: float | None = None
    repeats: tuple[int, int] | None = None
    size_mm: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.resolution is not None and self.texels_per_mm is not None:
            raise InputError("expected a resolution or texels per mm, not both")
        if self.repeats is not None and self.size_mm is not None:
            raise InputError("expected repeats or a patch in mm, not both")
        if self.resolution is not None:
            _check("resolution", self.resolution, *RESOLUTIONS)
        if self.texels_per_mm is not None:
            _check("texels per mm", self.texels_per_mm, 1e-3, MAX_TEXELS_PER_MM)
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
        if self.texels_per_mm is not None:
            longest = max(across * width, along * height)
            resolution = round(longest * self.texels_per_mm)
            _check(f"texels of a patch {longest:.4g} mm long", resolution, *RESOLUTIONS)
        return repeat(draft, across, along) if (across, along) != (1, 1) else draft, resolution


def _check(what: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise InputError(f"{what}: found {value:g}, expected {low:g} to {high:g}")
