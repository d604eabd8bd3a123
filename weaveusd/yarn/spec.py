"""One yarn of a recipe: its table becomes a YarnSpec."""

from __future__ import annotations

import math
from pathlib import Path
from typing import cast, get_args

from weaveusd.yarn.count import MAX_PLIES, Count, count_limits, parse_count, tex_of
from weaveusd.yarn.mixture import read_irregularity
from weaveusd.yarn.model import Optics, Spine, System, Twist, YarnSpec
from weaveusd.yarn.textile import FIBRE_DENSITY
from weaveusd.yarn.toml import Table, shown

MAX_PALETTE = 4096
_METRE_IN_INCHES = 1 / 0.0254


def read_spec(table: Table, folder: Path) -> YarnSpec:
    """Return the yarn that a ``[[yarn]]`` table states; files that it names are in `folder`.

    Raises RecipeError with file, line and key for a key that is missing, unknown or out of its
    limits, and for keys that say one thing twice.
    """
    count, stated = _count(table)
    irregularity, color = read_irregularity(table, folder, count.plies or 1)
    width, height, flatness = _section(table)
    direction = cast("Twist", table.text("twist_direction", "Z", choices=get_args(Twist)))
    spec = YarnSpec(
        name=table.text("name"),
        systems=_systems(table),
        palette=_palette(table),
        fibre=table.text("fibre", choices=tuple(FIBRE_DENSITY)),
        tex=count.tex,
        plies=count.plies or 1,
        twist_per_m=_twist(table),
        twist_direction=direction,
        packing=table.number("packing", 0.2, 1),
        width_mm=width,
        flatness=flatness,
        twist_deviation=math.radians(table.number("twist_deviation_deg", 0, 45, 0)),
        twist_correlation_mm=table.number("twist_correlation_mm", 0.01, 1000, 5),
        spine=cast("Spine", table.text("spine", "circle", choices=get_args(Spine))),
        kappa=table.number("kappa", -0.95, 20, 0),
        color=color.srgb,
        optics=_optics(table.table("optics")),
        count=stated,
        height_mm=height,
        twist_angle=_twist_angle(table, direction),
        crimp=table.optional("crimp", 0, 1),
        u_max=_radians(table.optional("u_max_deg", 0, 85)),
        color_stated=color.stated,
        colors_outside=color.outside,
        irregularity=irregularity,
    )
    table.close()
    return spec


def _count(table: Table) -> tuple[Count, str]:
    """Return the count, plies filled in, and what the recipe says of it."""
    key = table.one_of("tex", "denier", "Ne", "Nm", "lea", "count")
    if key == "count":
        stated = table.text("count")
        try:
            count = parse_count(stated)
        except ValueError as error:
            raise table.error("count", str(error)) from error
    else:
        number = table.number(key, *count_limits(key))
        stated = f"{number:g} {key}"
        count = Count(tex_of(number, key))
    if count.plies is not None and table.has("plies"):
        found = f"found beside a count of {count.plies} plies"
        raise table.error("plies", f"{found}, expected the plies to be stated once")
    return Count(count.tex, count.plies or table.whole("plies", 1, MAX_PLIES, 1)), stated


def _systems(table: Table) -> tuple[System, ...]:
    value = table.take("systems", ["warp", "weft"])
    known = get_args(System)
    if not isinstance(value, list) or not value or any(v not in known for v in value):
        found = shown(value)
        raise table.error("systems", f'found {found}, expected ["warp"], ["weft"] or both')
    return tuple(s for s in known if s in value)


def _palette(table: Table) -> tuple[int, ...]:
    value = table.take("palette", [])
    if not isinstance(value, list) or any(
        type(entry) is not int or not 1 <= entry <= MAX_PALETTE for entry in value
    ):
        raise table.error("palette", f"found {shown(value)}, expected palette entries from 1 on")
    return tuple(value)


def _section(table: Table) -> tuple[float | None, float | None, float | None]:
    """Return width and height in mm and flatness; two of them state the third."""
    width = table.optional("width_mm", 0.001, 100)
    height = table.optional("height_mm", 0.001, 100)
    flatness = table.optional("flatness", 0.05, 2)
    if height is not None and flatness is not None:
        expected = "one of height_mm and flatness"
        raise table.error("flatness", f"found beside height_mm, expected {expected}")
    return width, height, flatness


def _twist(table: Table) -> float:
    """Return the turns in a metre, stated as `twist_per_m` or `twist_per_inch`."""
    if table.one_of("twist_per_m", "twist_per_inch") == "twist_per_m":
        return table.number("twist_per_m", 0, 10_000)
    return table.number("twist_per_inch", 0, 250) * _METRE_IN_INCHES


def _twist_angle(table: Table, direction: Twist) -> float | None:
    angle = _radians(table.optional("twist_angle_deg", 0, 80))
    if angle is None or direction == "S":
        return angle
    return -angle


def _radians(degrees: float | None) -> float | None:
    return None if degrees is None else math.radians(degrees)


def _optics(table: Table) -> Optics:
    optics = Optics(
        eta=table.number("eta", 1.01, 3),
        k_d=table.number("k_d", 0, 1),
        k_s=table.number("k_s", 0, 1, 1),
        gamma_s=math.radians(table.number("gamma_s_deg", 0.5, 90)),
        gamma_v=math.radians(table.number("gamma_v_deg", 0.5, 90)),
        tau=table.number("tau", 0, 1, 0),
    )
    table.close()
    return optics
