"""Whether the MaterialX document says what the MaterialX network in the stage says."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Any

import MaterialX
from pxr import Sdf, Usd, UsdShade

from weaveusd.contract import LOBE_MAPS, MATERIALX_FILE
from weaveusd.errors import InputError
from weaveusd.stage import materialx_library
from weaveusd.validate.checks.materialx import read_document
from weaveusd.validate.checks.shader import input_value
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

VALUE = Code(
    "mtlx-disagrees", Status.FAIL, "The MaterialX document and the stage state different values."
)

TOLERANCE = 1e-5
"""Largest difference of numbers of both files, relative; both are written to seven digits."""

Value = tuple[float | str, ...]
Stated = dict[tuple[str, str], set[Value]]
"""What is stated for an input: values by node definition and input."""


@check(
    id="agreement/materialx",
    why="The document is the same cloth for renderers without USD: two truths are none.",
    needs=("material",),
    codes=(VALUE,),
)
def materialx_values(asset: OpenAsset) -> Iterator[Finding]:
    """Inputs that the document and the network in the stage both state have the same values.

    Of a lobe map the document may name the PNG, for loaders without EXR, and the stage the EXR.
    """
    name = asset.file_of_look(MATERIALX_FILE)
    try:
        document = read_document(asset.folder / name)
    except InputError:
        return  # materialx/document reports it
    document.setDataLibrary(materialx_library())
    in_document, in_stage = _of_document(document), _of_stage(asset.material)
    for key in sorted(in_document.keys() & in_stage.keys()):
        here = _apart(in_document[key], in_stage[key])
        there = _apart(in_stage[key], in_document[key])
        if here or there:
            yield VALUE(
                f"{key[1]} of {key[0]} is {_listed(here)}, in the stage {_listed(there)}", name
            )


def _apart(values: set[Value], others: set[Value]) -> list[Value]:
    """Return the `values` that are none of `others`."""
    return [value for value in values if not any(_same(value, other) for other in others)]


def _same(one: Value, other: Value) -> bool:
    return len(one) == len(other) and all(
        math.isclose(a, b, rel_tol=TOLERANCE, abs_tol=TOLERANCE)
        if isinstance(a, float) and isinstance(b, float)
        else a == b
        for a, b in zip(one, other, strict=True)
    )


def _of_document(document: Any) -> Stated:
    stated: Stated = {}
    for element in document.traverseTree():
        if not element.isA(MaterialX.Node) or element.getNodeDef() is None:
            continue
        for found in element.getInputs():
            if found.getValueString():
                key = element.getNodeDef().getName(), found.getName()
                stated.setdefault(key, set()).add(_parsed(found.getResolvedValueString()))
    return stated


def _of_stage(material: Usd.Prim) -> Stated:
    stated: Stated = {}
    for prim in Usd.PrimRange(material):
        identifier = str(UsdShade.Shader(prim).GetIdAttr().Get() or "")
        if not prim.IsA(UsdShade.Shader) or not identifier.startswith("ND_"):
            continue
        for found in UsdShade.Shader(prim).GetInputs(onlyAuthored=True):
            value = input_value(prim, found.GetBaseName())
            if value is not None:
                key = identifier, str(found.GetBaseName())
                stated.setdefault(key, set()).add(_parsed(value))
    return stated


def _parsed(value: Any) -> Value:
    """Return the components of a value of either file, numbers where they are some."""
    if isinstance(value, Sdf.AssetPath):
        value = value.path
    # Vectors of USD print as tuples.
    return tuple(_component(part.strip()) for part in str(value).strip("()").split(","))


def _component(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        if text.lower() in ("true", "false"):
            return text.lower()
        name = text.removeprefix("./")
        path = PurePosixPath(name)
        return str(path.with_suffix("")) if path.stem in LOBE_MAPS else name


def _listed(values: list[Value]) -> str:
    texts = (
        ", ".join(f"{c:.6g}" if isinstance(c, float) else c for c in value) for value in values
    )
    return "; ".join(sorted(texts)[:4]) or "not stated"
