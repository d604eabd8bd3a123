"""Whether the MaterialX document beside the asset is one that others can load."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import MaterialX

from weaveusd.contract import CLOTH_SHADER_ID, EXACT_FILE, MATERIALX_FILE, MATERIALX_NODE_DIR
from weaveusd.errors import InputError
from weaveusd.stage import materialx_library, schema_dir
from weaveusd.validate.checks.color_spaces import MATERIALX_NAMES
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

BROKEN = Code("mtlx-broken", Status.FAIL, "The MaterialX document is missing or invalid.")
NODE = Code("mtlx-node", Status.FAIL, "A node of the document is none of the standard ones.")
SPACE = Code("mtlx-color-space", Status.FAIL, "The document states no, or an unknown, color space.")
FILE = Code("mtlx-file", Status.FAIL, "A file that the document names is missing or outside.")

MAX_BYTES = 8 << 20


@check(
    id="materialx/document",
    why="MaterialX loaders skip unknown nodes and undecoded colors without a word, and "
    "mxvalidate lets them pass.",
    codes=(BROKEN, NODE, SPACE, FILE),
)
def materialx_document(asset: OpenAsset) -> Iterator[Finding]:
    """MaterialX documents are valid, find textures, and have standard nodes; the exact one ours."""
    yield from _document(asset.folder, asset.file_of_look(MATERIALX_FILE), materialx_library())
    exact = asset.file_of_look(EXACT_FILE)
    if (asset.folder / exact).exists():
        yield from _document(asset.folder, exact, _library_with_ours())
        node = f"{MATERIALX_NODE_DIR}/{CLOTH_SHADER_ID}.mtlx"
        if not (asset.folder / node).is_file():
            yield FILE(f"{node!r} is no file of the asset", exact)


@cache
def _library_with_ours() -> Any:
    """Return the standard definitions and that of our node, which the asset's copy says too."""
    library = MaterialX.createDocument()
    library.importLibrary(materialx_library())
    ours = schema_dir() / MATERIALX_NODE_DIR / f"{CLOTH_SHADER_ID}.mtlx"
    MaterialX.readFromXmlFile(library, str(ours))
    return library


def read_document(path: Path) -> Any:
    """Return the MaterialX document at `path`, what it includes left out.

    Raises
    ------
    InputError
        When it is missing, too large or no XML; the message does not name the file.
    """
    if not path.is_file() or path.stat().st_size > MAX_BYTES:
        raise InputError(f"expected a file of at most {MAX_BYTES} bytes")
    document = MaterialX.createDocument()
    options = MaterialX.XmlReadOptions()
    options.readXIncludeFunction = None
    try:
        text = path.read_text(encoding="utf-8")
        MaterialX.readFromXmlString(document, text, MaterialX.FileSearchPath(), options)
    except (MaterialX.ExceptionParseError, UnicodeDecodeError) as error:
        raise InputError(" ".join(str(error).split())) from None
    return document


def _document(folder: Path, name: str, library: Any) -> Iterator[Finding]:
    try:
        document = read_document(folder / name)
    except InputError as error:
        yield BROKEN(str(error), name)
        return
    spaces = {document.getColorSpace(), *_authored_spaces(document)}
    for space in sorted(spaces - set(MATERIALX_NAMES)):
        yield SPACE(f"{space or 'unstated'}, expected {' or '.join(MATERIALX_NAMES)}", name)
    yield from _files(document, folder)

    document.setDataLibrary(library)
    valid, message = document.validate()
    if not valid:
        yield BROKEN(" ".join(message.split()), name)
    for element in document.traverseTree():
        if element.isA(MaterialX.Node) and element.getNodeDef() is None:
            yield NODE(f"no standard node {element.getCategory()}", element.getNamePath())


def _authored_spaces(document: Any) -> set[str]:
    return {
        element.getColorSpace() for element in document.traverseTree() if element.hasColorSpace()
    }


def _files(document: Any, folder: Path) -> Iterator[Finding]:
    inside = folder.resolve()
    for element in document.traverseTree():
        if not element.isA(MaterialX.Input) or element.getType() != "filename":
            continue
        name = element.getResolvedValueString()
        file = folder / name
        climbs = name.startswith("/") or ".." in re.split(r"[/\\]", name)
        if not name or climbs or not file.is_file() or not file.resolve().is_relative_to(inside):
            yield FILE(f"{name!r} is no file of the asset", element.getNamePath())
