"""Whether the asset can be moved: every path in it is anchored and stays inside."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from pxr import Sdf, UsdUtils

from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

ABSOLUTE = Code("path-absolute", Status.FAIL, "A path is absolute, or names a drive or host.")
PARENT = Code("path-parent", Status.FAIL, "A path climbs out of its folder with '..'.")
UNANCHORED = Code(
    "path-unanchored", Status.FAIL, "A path does not begin with './', so that it is searched for."
)
MISSING = Code("path-missing", Status.FAIL, "A path leads to no file.")
OUTSIDE = Code("path-outside", Status.FAIL, "A path leads to a file outside the asset's folder.")

_ABSOLUTE = re.compile(r"[/\\~]|[A-Za-z][A-Za-z0-9+.-]*:")


@check(
    id="path/anchored",
    why="An absolute or searched path works on the machine that made it and breaks on every "
    "other; USD itself notices neither.",
    codes=(ABSOLUTE, PARENT, UNANCHORED, MISSING, OUTSIDE),
)
def anchored_paths(asset: OpenAsset) -> Iterator[Finding]:
    """Every path in every layer is anchored with './' and leads to a file of the asset."""
    inside = asset.folder.resolve()
    for layer in asset.layers():
        where = asset.short(layer.realPath)
        folder = Path(layer.realPath).parent
        for path in sorted(authored_paths(layer)):
            if _ABSOLUTE.match(path):
                yield ABSOLUTE(f"@{path}@ is absolute, expected it to begin with './'", where)
            elif ".." in re.split(r"[/\\]", path):
                yield PARENT(f"@{path}@ leaves its folder, expected no '..'", where)
            elif not path.startswith("./"):
                yield UNANCHORED(f"@{path}@ is searched for, expected @./{path}@", where)
            elif not (file := (folder / path)).is_file():
                yield MISSING(f"@{path}@ is no file", where)
            elif not file.resolve().is_relative_to(inside):
                yield OUTSIDE(f"@{path}@ leads to {file.resolve()}", where)


def authored_paths(layer: Sdf.Layer) -> set[str]:
    """Return every asset path authored in `layer`, as written there."""
    found: set[str] = set()

    def note(path: str) -> str:
        found.add(path)
        return path

    copy = Sdf.Layer.CreateAnonymous(".usda")
    copy.TransferContent(layer)
    UsdUtils.ModifyAssetPaths(copy, note)
    return found - {""}
