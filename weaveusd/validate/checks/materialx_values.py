"""Whether the MaterialX document says what the MaterialX network in the stage says."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import MaterialX
from pxr import Sdf, Usd, UsdShade

from weaveusd.contract import MATERIALX_FILE
from weaveusd.stage import materialx_library
from weaveusd.validate.checks.materialx import MAX_BYTES
from weaveusd.validate.checks.shader import input_value
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

VALUE = Code(
    "mtlx-disagrees", Status.FAIL, "The MaterialX document and the stage state different values."
)

DIGITS = 6
"""Significant digits to which numbers of both files are compared."""

Stated = dict[tuple[str, str], set[str]]
"""What is stated for an input: values, as text, by node definition and input."""


@check(
    id="agreement/materialx",
    why="The document is the same cloth for renderers without USD: two truths are none.",
    needs=("material",),
    codes=(VALUE,),
)
def materialx_values(asset: OpenAsset) -> Iterator[Finding]:
    """Inputs that the document and the network in the stage both state have the same values."""
    name = asset.file_of_look(MATERIALX_FILE)
    path = asset.folder / name
    if not path.is_file() or path.stat().st_size > MAX_BYTES:
        return  # materialx/document reports it
    document = MaterialX.createDocument()
    options = MaterialX.XmlReadOptions()
    options.readXIncludeFunction = None
    try:
        text = path.read_text(encoding="utf-8")
        MaterialX.readFromXmlString(document, text, MaterialX.FileSearchPath(), options)
    except (MaterialX.ExceptionParseError, UnicodeDecodeError):
        return
    document.setDataLibrary(materialx_library())
    in_document, in_stage = _of_document(document), _of_stage(asset.material)
    for key in sorted(in_document.keys() & in_stage.keys()):
        here, there = in_document[key], in_stage[key]
        if here != there:
            yield VALUE(
                f"{key[1]} of {key[0]} is {_listed(here - there)}, in the stage "
                f"{_listed(there - here)}",
                name,
            )


def _of_document(document: Any) -> Stated:
    stated: Stated = {}
    for element in document.traverseTree():
        if not element.isA(MaterialX.Node) or element.getNodeDef() is None:
            continue
        for found in element.getInputs():
            if found.getValueString():
                key = element.getNodeDef().getName(), found.getName()
                stated.setdefault(key, set()).add(_text(found.getResolvedValueString()))
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
                stated.setdefault(key, set()).add(_text(value))
    return stated


def _text(value: Any) -> str:
    """Return a value of either file as text that compares equal where it means the same."""
    if isinstance(value, Sdf.AssetPath):
        value = value.path
    # Vectors of USD print as tuples.
    parts = str(value).strip("()").split(",")
    return ", ".join(_number(part.strip().removeprefix("./")) for part in parts)


def _number(text: str) -> str:
    try:
        return f"{float(text):.{DIGITS}g}"
    except ValueError:
        return text.lower() if text.lower() in ("true", "false") else text


def _listed(values: set[str]) -> str:
    return "; ".join(sorted(values)[:4]) or "not stated"
