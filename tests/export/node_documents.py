"""Documents with one node `weaveusd_cloth`, and its library beside them."""

from __future__ import annotations

import shutil
from pathlib import Path

import MaterialX as mx  # noqa: N813

from weaveusd.stage import schema_dir

LIBRARY = schema_dir() / "materialx"


def new_document() -> tuple[mx.Document, mx.Node]:
    """Return a document and its node `weaveusd_cloth`, which does not keep it alive."""
    made = mx.createDocument()
    made.setColorSpace("lin_rec709")
    return made, made.addNode("weaveusd_cloth", "cloth", "BSDF")


def write_document(made: mx.Document, folder: Path) -> Path:
    """Write `made` with a material "material" of its cloth, and the library, into `folder`."""
    shutil.copytree(LIBRARY, folder / "materialx")
    surface = made.addNode("surface", "surface", "surfaceshader")
    surface.setConnectedNode("bsdf", made.getNode("cloth"))
    made.addNode("surfacematerial", "material", "material").setConnectedNode(
        "surfaceshader", surface
    )
    mx.prependXInclude(made, "materialx/weaveusd_cloth.mtlx")
    path = folder / "document.mtlx"
    path.write_text(mx.writeToXmlString(made))
    return path
