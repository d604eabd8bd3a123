"""What a drawdown is like: its floats, its faces, and the name of its weave."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.draft.model import Draft, drawdown_sha256
from weaveusd.draft.structure import smallest_repeat, structure_name

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.draft.model import Bools

SNAG_THREADS = 12
"""A float over more threads is warned about where the draft states no pitch."""

SNAG_MM = 12.0
"""A float longer than this is warned about where the draft states its pitch: half an inch."""

Histogram = dict[int, int]
"""Length of a float in threads to the number of such floats."""


@dataclass(frozen=True, slots=True)
class Description:
    """A draft in numbers and words.

    Shares are 0…1. `repeat_ends` and `repeat_picks` are those of the smallest repeat of the
    drawdown, which the structure's name describes. A thread that never interlaces counts as one
    float over the whole draft.
    """

    title: str
    ends: int
    picks: int
    shafts: int
    repeat_ends: int
    repeat_picks: int
    structure: str | None
    drawdown_sha256: str
    longest_float: int
    longest_warp_float: int
    longest_weft_float: int
    face_floats: dict[str, Histogram]  # "warp" and "weft": floats seen on the face
    back_floats: dict[str, Histogram]
    warp_face: float  # share of crossings with warp on top
    warp_interlacing: float  # share of neighbours along an end where it changes sides
    weft_interlacing: float
    never_interlacing: int  # ends and picks that stay on one side
    colors: list[str]  # of the threads, "#rrggbb", in the palette's order
    yarns: list[str]  # what the file says of its yarns
    warnings: list[str]

    def as_dict(self) -> dict[str, Any]:
        """Return the description as JSON types; float lengths become strings."""
        record = asdict(self)
        for face in ("face_floats", "back_floats"):
            record[face] = {
                system: {str(n): count for n, count in floats.items()}
                for system, floats in record[face].items()
            }
        return record


def describe(draft: Draft) -> Description:
    """Return the statistics of a draft, with its warnings and those on its floats."""
    up = draft.drawdown()
    warp_up, warp_down = float_lengths(up.T)
    weft_down, weft_up = float_lengths(up)
    longest_warp = max(_longest(warp_up), _longest(warp_down))
    longest_weft = max(_longest(weft_up), _longest(weft_down))
    repeat_picks, repeat_ends = smallest_repeat(up)
    still = int((up.all(axis=0) | ~up.any(axis=0)).sum() + (up.all(axis=1) | ~up.any(axis=1)).sum())
    warnings = [str(warning) for warning in draft.warnings]
    warnings += _snags("warp", longest_warp, draft.weft_pitch_mm)
    warnings += _snags("weft", longest_weft, draft.warp_pitch_mm)
    if still:
        warnings.append(f"{still} threads never interlace: they lie loose on the cloth")
    return Description(
        title=draft.title,
        ends=draft.ends,
        picks=draft.picks,
        shafts=draft.shafts,
        repeat_ends=repeat_ends,
        repeat_picks=repeat_picks,
        structure=structure_name(up[:repeat_picks, :repeat_ends]),
        drawdown_sha256=drawdown_sha256(draft),
        longest_float=max(longest_warp, longest_weft),
        longest_warp_float=longest_warp,
        longest_weft_float=longest_weft,
        face_floats={"warp": _histogram(warp_up), "weft": _histogram(weft_up)},
        back_floats={"warp": _histogram(warp_down), "weft": _histogram(weft_down)},
        warp_face=float(up.mean()),
        warp_interlacing=float((up != np.roll(up, 1, axis=0)).mean()),
        weft_interlacing=float((up != np.roll(up, 1, axis=1)).mean()),
        never_interlacing=still,
        colors=used_colors(draft),
        yarns=list(draft.yarns),
        warnings=warnings,
    )


def float_lengths(rows: Bools) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the lengths of the cyclic runs of True, and of False, in the rows of a matrix.

    A run that leaves a row at its end goes on at its start; a row without change is one run of
    its whole length. Floats of the warp are runs in the columns of a drawdown.
    """
    rows = np.ascontiguousarray(rows)
    length = rows.shape[1]
    changes = rows != np.roll(rows, 1, axis=1)
    start = np.flatnonzero(changes)
    run = np.empty_like(start)
    np.subtract(start[1:], start[:-1], out=run[:-1])
    # The last run of a row ends at its first change, one length later.
    many = changes.sum(axis=1)
    behind = np.cumsum(many)[many > 0]
    first = behind - many[many > 0]
    run[behind - 1] = start[first] + length - start[behind - 1]
    value = rows.ravel()[start]
    still = rows[many == 0, 0]
    whole = np.full(still.size, length)
    return (
        np.concatenate([run[value], whole[still]]),
        np.concatenate([run[~value], whole[~still]]),
    )


def used_colors(draft: Draft) -> list[str]:
    """Return the palette colors that threads take, as "#rrggbb", in the palette's order."""
    used = np.union1d(draft.warp_color, draft.weft_color)
    eight_bit = np.rint(draft.palette[used] * 255).astype(np.uint8)
    return [f"#{bytes(color).hex()}" for color in eight_bit]


def _longest(lengths: NDArray[np.intp]) -> int:
    return int(lengths.max()) if lengths.size else 0


def _histogram(lengths: NDArray[np.intp]) -> Histogram:
    counts = np.bincount(lengths)
    return {n: int(counts[n]) for n in np.flatnonzero(counts).tolist()}


def _snags(system: str, longest: int, pitch_mm: NDArray[np.float64] | None) -> list[str]:
    """Return a warning when the longest float of a system would catch on things."""
    if pitch_mm is None:
        if longest <= SNAG_THREADS:
            return []
        return [f"the longest {system} float passes {longest} threads and may snag"]
    length = longest * float(pitch_mm.mean())
    if length <= SNAG_MM:
        return []
    return [f"the longest {system} float is {length:.1f} mm long and may snag"]
