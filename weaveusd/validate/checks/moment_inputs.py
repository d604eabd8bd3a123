"""Whether the exact shader names moment maps that it can use."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pxr import Sdf, UsdShade

from weaveusd.contract import (
    CLOTH_NAMESPACE,
    MAX_KINDS,
    SYSTEMS,
    kinds_input,
    moment_file,
    moment_input,
    moment_inputs,
    section_input,
)
from weaveusd.validate.checks.shader import input_value
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.moment_maps import expected_maps, kinds_of, optics_of, section_of
from weaveusd.validate.open_asset import OpenAsset, named_maps
from weaveusd.validate.registry import Code, check

INCOMPLETE = Code(
    "moments-incomplete", Status.FAIL, "The shader names some moment maps of a cloth, but not all."
)
TYPE = Code("moments-type", Status.FAIL, "An input for moment maps has another type.")
FILE = Code("moments-file", Status.FAIL, "An input for a moment map names another texture.")
SECTION = Code(
    "section-wrong", Status.FAIL, "The section of a system is not one that its yarns can have."
)
KINDS_WRONG = Code(
    "kinds-wrong", Status.FAIL, "The yarns that stand for the kinds of a system do not cover it."
)
NONE = Code(
    "moments-none", Status.SKIP, "The shader names no moment maps, as in assets of older versions."
)

ROUNDING = 1e-5
"""Relative difference between a mean in single precision and the numbers that it is the mean of."""


@check(
    id="shader/moments",
    why="Who sees the cloth from afar sees its moment maps alone; half a set is no cloth.",
    needs=("material", "shader"),
    codes=(INCOMPLETE, TYPE, FILE, SECTION, KINDS_WRONG, NONE),
)
def moments_named(asset: OpenAsset) -> Iterator[Finding]:
    """The exact shader names all moment maps, with sections and kinds that its yarns have."""
    path = str(asset.shader.GetPath())
    listed = asset.cloth("momentMaps")
    if not named_maps(asset.shader) and not listed:
        yield NONE("names no moment maps: from afar the cloth is shown by its texels", path)
        return
    if typed := list(_types(asset)):
        yield from typed
        return
    for system in SYSTEMS:
        yield from _judge(asset, system)
    expected = sorted(_anchored(asset))
    if sorted(file.path for file in listed or ()) != expected:
        where = f"{asset.material.GetPath()}.{CLOTH_NAMESPACE}:momentMaps"
        yield FILE(f"does not list the {len(expected)} maps, {', '.join(expected)}", where)


def _judge(asset: OpenAsset, system: str) -> Iterator[Finding]:
    names = expected_maps(asset, system)
    inputs = [section_input(system), kinds_input(system)]
    inputs += [moment_input(system, name) for name in names]
    lacking = [name for name in inputs if input_value(asset.shader, name) is None]
    path = asset.shader.GetPath()
    if lacking:
        yield INCOMPLETE(f"has no value for {', '.join(lacking)}", str(path))
    for name in names:
        if moment_input(system, name) not in lacking:
            yield from _file(asset, system, name)
    if section_input(system) not in lacking:
        for fault in _section_faults(asset, system):
            yield SECTION(fault, f"{path}.inputs:{section_input(system)}")
    if kinds_input(system) not in lacking:
        for fault in _kind_faults(asset, system):
            yield KINDS_WRONG(fault, f"{path}.inputs:{kinds_input(system)}")


def _anchored(asset: OpenAsset) -> Iterator[str]:
    """Yield the paths of all maps of the cloth."""
    for system in SYSTEMS:
        for name in expected_maps(asset, system):
            yield asset.texture_path(moment_file(system, name))


def _types(asset: OpenAsset) -> Iterator[Finding]:
    for name, kind in moment_inputs().items():
        found = UsdShade.Shader(asset.shader).GetInput(name)
        if found and str(found.GetTypeName()) != kind:
            where = f"{asset.shader.GetPath()}.inputs:{name}"
            yield TYPE(f"has type {found.GetTypeName()}, expected {kind}", where)


def _file(asset: OpenAsset, system: str, name: str) -> Iterator[Finding]:
    value: Any = input_value(asset.shader, moment_input(system, name))
    expected = asset.texture_path(moment_file(system, name))
    shown = value.path if isinstance(value, Sdf.AssetPath) else ""
    if not shown.endswith(expected[1:]):
        where = f"{asset.shader.GetPath()}.inputs:{moment_input(system, name)}"
        yield FILE(f"is @{shown}@, expected @{expected}@", where)


def _section_faults(asset: OpenAsset, system: str) -> Iterator[str]:
    section = section_of(asset, system)
    if section is None:
        stated = input_value(asset.shader, section_input(system))
        yield f"is {stated}, expected a thickness over width above 0 and a curvature of 0 or more"
        return
    stated_ratios = [_flatness(asset, yarn) for yarn in _yarns(asset, system).values()]
    ratios = [ratio for ratio in stated_ratios if ratio is not None]
    if len(ratios) != len(stated_ratios) or not ratios:
        return  # attribute/yarns reports it
    low, high = min(ratios) * (1 - ROUNDING), max(ratios) * (1 + ROUNDING)
    if not low <= section[0] <= high:
        yield (
            f"says that yarns are {section[0]:.6g} times as thick as wide, their attributes say "
            f"{low:.6g} to {high:.6g}"
        )


def _flatness(asset: OpenAsset, yarn: str) -> float | None:
    height, width = asset.yarn(yarn, "height"), asset.yarn(yarn, "width")
    return height / width if height and width else None


def _kind_faults(asset: OpenAsset, system: str) -> Iterator[str]:
    kinds, own, optics = kinds_of(asset, system), _yarns(asset, system), optics_of(asset)
    if not 1 <= len(kinds) <= MAX_KINDS:
        yield f"lists {len(kinds)} yarns, expected 1 to {MAX_KINDS}"
        return
    if strange := [number for number in kinds if number not in own]:
        yield f"lists {strange}, expected ids of yarns of the {system}: {[*own][:16]}"
        return
    if len(set(kinds)) != len(kinds):
        yield f"lists a yarn twice: {list(kinds)}"
    known = {optics[number - 1] for number in kinds if number <= len(optics)}
    for number, yarn in own.items():
        # With as many kinds as there can be, others count as the nearest of them.
        if len(kinds) < MAX_KINDS and number <= len(optics) and optics[number - 1] not in known:
            yield f"lists {list(kinds)}, but {yarn} scatters like none of them"


def _yarns(asset: OpenAsset, system: str) -> dict[int, str]:
    """Return id and name of the yarns of `system`."""
    return {
        number: yarn
        for number, yarn in enumerate(asset.yarns, start=1)
        if asset.yarn(yarn, "system") == system
    }
