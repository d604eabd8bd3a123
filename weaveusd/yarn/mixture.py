"""How a recipe says that a yarn is uneven, and of which colors it is mixed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from weaveusd.yarn.color import YarnColor, linear_from_srgb, read_color, srgb_from_linear
from weaveusd.yarn.irregularity import RGB, Irregularity

if TYPE_CHECKING:
    from weaveusd.yarn.toml import Table

MAX_COLORS = 16
"""Colors of fibres that a mélange is mixed of."""


def read_irregularity(table: Table, folder: Path, plies: int) -> tuple[Irregularity, YarnColor]:
    """Return the unevenness and the color of a yarn of so many `plies`, from its table.

    A mélange mixes fibres of two colors and more by their shares; a mouliné twists as many
    strands as the yarn has plies, each of its color. The color of either is the mean of its
    colors, and stating another beside them is a RecipeError, like every other fault.
    """
    uneven = table.table("irregularity", {})
    melange = _melange(uneven, folder)
    strands = _strands(uneven, folder, plies)
    if melange and strands:
        raise uneven.error("strands", "found beside melange, expected one of them")
    parts = melange or strands
    if parts and table.has("color"):
        raise table.error("color", "found beside colors to mix, which give the mean")
    irregularity = Irregularity(
        thickness=uneven.number("thickness", 0, 0.5, 0),
        thickness_correlation_mm=uneven.number("thickness_correlation_mm", 0.1, 1000, 10),
        bend=uneven.number("bend", 0, 0.5, 0),
        color=uneven.number("color_delta_e", 0, 20, 0),
        color_correlation_mm=uneven.number("color_correlation_mm", 0.1, 1000, 20),
        hairiness=uneven.number("hairiness", 0, 1, 0),
        melange=tuple((part.linear, part.share) for part in melange),
        strands=tuple(part.linear for part in strands),
    )
    uneven.close()
    return irregularity, _mean(parts) if parts else read_color(table, folder)


class _Part(NamedTuple):
    """A color of a mixture: as stated, in linear Rec.709, and its share."""

    color: YarnColor
    linear: RGB
    share: float


def _melange(table: Table, folder: Path) -> list[_Part]:
    parts = [
        _part(part, folder, part.number("share", 0.001, 1)) for part in _parts(table, "melange")
    ]
    total = sum(part.share for part in parts)
    if parts and (len(parts) < 2 or abs(total - 1) > 1e-6):
        found = f"found {len(parts)} whose shares add up to {total:g}"
        raise table.error("melange", f"{found}, expected two or more that add up to 1")
    return parts


def _strands(table: Table, folder: Path, plies: int) -> list[_Part]:
    parts = [_part(part, folder, 1 / plies) for part in _parts(table, "strands")]
    if parts and (plies < 2 or len(parts) != plies):
        expected = "a color for each of two plies or more"
        raise table.error("strands", f"found {len(parts)} for {plies} plies, expected {expected}")
    return parts


def _parts(table: Table, key: str) -> list[Table]:
    return [] if table.take(key, None) is None else table.tables(key, MAX_COLORS)


def _part(table: Table, folder: Path, share: float) -> _Part:
    color = read_color(table, folder)
    table.close()
    if color.srgb is None:
        raise table.error("color", "found the draft's, expected a color of its own")
    return _Part(color, linear_from_srgb(color.srgb), share)


def _mean(parts: Sequence[_Part]) -> YarnColor:
    r, g, b = (math.fsum(part.share * part.linear[i] for part in parts) for i in range(3))
    return YarnColor(
        srgb=srgb_from_linear((r, g, b)),
        stated=" + ".join(f"{100 * part.share:.3g} % {part.color.stated}" for part in parts),
        outside=tuple(outside for part in parts for outside in part.color.outside),
    )
