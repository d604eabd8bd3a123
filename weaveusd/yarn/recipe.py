"""Recipes: TOML files that say what the yarns of a cloth are, and presets of ours."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path
from typing import cast, get_args

from weaveusd.errors import RecipeError
from weaveusd.yarn.model import RGB, Optics, Recipe, Spine, System, Twist, YarnSpec
from weaveusd.yarn.textile import FIBRE_DENSITY
from weaveusd.yarn.toml import Table, read_table

PRESETS = Path(__file__).parent / "presets"
MAX_SPECS = 64


def read_recipe(path: str | os.PathLike[str]) -> Recipe:
    """Return the recipe in the TOML file `path` (the format: docs/recipes.md).

    Raises RecipeError with file, line and key for a key that is missing, unknown or out of
    its limits.
    """
    return _recipe(read_table(Path(path), str(path)))


def preset_names() -> tuple[str, ...]:
    """Return the names of the presets, sorted."""
    return tuple(sorted(p.stem for p in PRESETS.glob("*.toml")))


def read_preset(name: str) -> Recipe:
    """Return the preset `name`; raises RecipeError that lists the presets there are."""
    if name not in preset_names():
        raise RecipeError(f"no preset {name!r}; there are {', '.join(preset_names())}")
    return _recipe(read_table(PRESETS / f"{name}.toml", f"preset {name}"))


def _recipe(root: Table) -> Recipe:
    sett = root.table("sett")
    recipe = Recipe(
        name=root.text("name"),
        title=root.text("title"),
        kind="fabric" if root.text("kind", "yarn", ("yarn", "fabric")) == "fabric" else "yarn",
        source=root.text("source"),
        certainty=root.text("certainty", ""),
        ends_per_cm=sett.number("ends_per_cm", 0.1, 1000),
        picks_per_cm=sett.number("picks_per_cm", 0.1, 1000),
        crimp_balance=sett.number("crimp_balance", 0, 1, 0.5),
        yarns=tuple(_yarn(t) for t in root.tables("yarn", MAX_SPECS)),
    )
    sett.close()
    root.close()
    return recipe


def _yarn(table: Table) -> YarnSpec:
    systems = table.take("systems", ["warp", "weft"])
    if (
        not isinstance(systems, list)
        or not systems
        or any(s not in get_args(System) for s in systems)
    ):
        raise table.error("systems", f'found {systems!r}, expected ["warp"], ["weft"] or both')
    palette = table.take("palette", [])
    if not isinstance(palette, list) or any(type(p) is not int or p < 1 for p in palette):
        raise table.error("palette", f"found {palette!r}, expected palette entries from 1 on")
    optics = table.table("optics")
    spec = YarnSpec(
        name=table.text("name"),
        systems=tuple(systems),
        palette=tuple(palette),
        fibre=table.text("fibre", choices=tuple(FIBRE_DENSITY)),
        tex=table.number("tex", 0.1, 100_000),
        plies=int(table.number("plies", 1, 16, 1)),
        twist_per_m=table.number("twist_per_m", 0, 10_000),
        twist_direction=cast("Twist", table.text("twist_direction", "Z", choices=get_args(Twist))),
        packing=table.number("packing", 0.2, 1),
        width_mm=table.number("width_mm", 0.001, 100) if table.has("width_mm") else None,
        flatness=table.number("flatness", 0.05, 2) if table.has("flatness") else None,
        twist_deviation=math.radians(table.number("twist_deviation_deg", 0, 45, 0)),
        twist_correlation_mm=table.number("twist_correlation_mm", 0.01, 1000, 5),
        spine=cast("Spine", table.text("spine", "circle", choices=get_args(Spine))),
        kappa=table.number("kappa", -0.95, 20, 0),
        color=_color(table),
        optics=Optics(
            eta=optics.number("eta", 1.01, 3),
            k_d=optics.number("k_d", 0, 1),
            k_s=optics.number("k_s", 0, 1, 1),
            gamma_s=math.radians(optics.number("gamma_s_deg", 0.5, 90)),
            gamma_v=math.radians(optics.number("gamma_v_deg", 0.5, 90)),
            tau=optics.number("tau", 0, 1, 0),
        ),
    )
    optics.close()
    table.close()
    return spec


def _color(table: Table) -> RGB | None:
    value = table.text("color", "draft")
    if value == "draft":
        return None
    if not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
        raise table.error("color", f'found {value!r}, expected "draft" or "#rrggbb"')
    r, g, b = (int(value[i : i + 2], 16) / 255 for i in (1, 3, 5))
    return r, g, b
