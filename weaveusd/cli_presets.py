"""The command `presets`: what there is, with swatches, and every number of one preset."""

from __future__ import annotations

import json
import math
import sys
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Iterator

SWATCH = 16, 8
"""Columns and pixel rows of the swatch before a preset's name; two rows make a line."""


def register(app: typer.Typer) -> None:
    """Add the command `presets` to `app`."""
    app.command("presets")(_presets)


def _presets(
    name: Annotated[str | None, typer.Argument(help="One preset, with every number.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON list.")] = False,
) -> None:
    """List the presets, or show one with its numbers and their source."""
    from weaveusd import pipeline

    found = pipeline.presets(name)
    if as_json:
        sys.stdout.write(json.dumps(found, indent=2, ensure_ascii=False) + "\n")
    elif name is not None:
        _say("\n".join(_described(found[0])))
    elif sys.stdout.isatty():
        for preset in found:
            lines = pipeline.preset_swatch(preset["name"], *SWATCH).split("\n")
            beside = ["", f"  {preset['name']}", f"  {preset['title']}", f"  {preset['kind']}"]
            _say("\n".join(left + right for left, right in zip(lines, beside, strict=True)) + "\n")
    else:
        for preset in found:
            _say(f"{preset['name']:<15} {preset['kind']:<7} {preset['title']}")


def _described(preset: dict[str, Any]) -> Iterator[str]:
    """Yield the lines that say everything about a preset."""
    yield f"{preset['name']}: {preset['title']}"
    yield from _named(preset, "kind", "weave", "finish", "source", "certainty")
    yield f"  sett         {preset['ends_per_cm']:g} ends, {preset['picks_per_cm']:g} picks per cm"
    yield f"  crimp        {preset['crimp_balance']:.0%} of it in the warp"
    if preset["weight_g_m2"] is not None:
        yield f"  weight       {preset['weight_g_m2']:g} g/m² as its source gives it"
    for yarn in preset["yarns"]:
        yield f"\n  yarn {yarn['name']} ({' and '.join(yarn['systems'])})"
        for key, value in yarn.items():
            if key in ("name", "systems") or value in (None, "", [], ()):
                continue
            if isinstance(value, dict):
                for inner, number in value.items():
                    if number not in (None, [], ()):
                        yield f"    {key + '.' + inner:<34} {_shown(inner, number)}"
            else:
                yield f"    {key:<34} {_shown(key, value)}"


def _named(preset: dict[str, Any], *keys: str) -> Iterator[str]:
    for key in keys:
        if preset[key]:
            yield f"  {key:<12} {preset[key]}"


def _shown(key: str, value: Any) -> str:
    """Return a value with its unit; angles in degrees, which the recipe has them in."""
    if key in ("gamma_s", "gamma_v", "twist_deviation", "twist_angle", "u_max"):
        return f"{math.degrees(value):.4g}°"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (list, tuple)):
        return ", ".join(_shown("", item) for item in value)
    return str(value)


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
