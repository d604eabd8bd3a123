"""Whether the files are those that were published."""

from __future__ import annotations

import os
from collections.abc import Iterator

from weaveusd.contract import MANIFEST_FILE
from weaveusd.validate.integrity import Kind, differences
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

BROKEN = Code("manifest-broken", Status.FAIL, "The manifest is not of the form that is published.")
CHANGED = Code("manifest-changed", Status.FAIL, "A file is not the one that was published.")
GONE = Code("manifest-gone", Status.FAIL, "A published file is gone.")
ADDED = Code("manifest-added", Status.FAIL, "A file was added after publishing.")
DIGEST = Code(
    "manifest-digest", Status.FAIL, "The manifest's digests are not those of what it lists."
)
NONE = Code("manifest-none", Status.SKIP, "There is no manifest: the asset is not published yet.")

CODES: dict[Kind, Code] = {
    "missing": GONE,
    "added": ADDED,
    "changed": CHANGED,
    "broken": BROKEN,
    "digest": DIGEST,
}


@check(
    id="files/manifest",
    why="A version that is published never changes; one flipped bit is another cloth.",
    codes=(BROKEN, CHANGED, GONE, ADDED, DIGEST, NONE),
)
def manifest(asset: OpenAsset) -> Iterator[Finding]:
    """Every file is the one that was published, none is gone and none was added."""
    if not os.path.lexists(asset.folder / MANIFEST_FILE):
        yield NONE("there is no manifest, as before publishing")
        return
    for found in differences(asset.folder):
        yield CODES[found.kind](found.message, found.path)
