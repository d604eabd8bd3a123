"""Whether the files are those that were published."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from weaveusd.contract import MANIFEST_FILE
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

BROKEN = Code("manifest-broken", Status.FAIL, "The manifest is not of the form that is published.")
CHANGED = Code("manifest-changed", Status.FAIL, "A file is not the one that was published.")
GONE = Code("manifest-gone", Status.FAIL, "A published file is gone.")
ADDED = Code("manifest-added", Status.FAIL, "A file was added after publishing.")
DIGEST = Code("manifest-digest", Status.FAIL, "The digest of the content is not that of the files.")
NONE = Code("manifest-none", Status.SKIP, "There is no manifest: the asset is not published yet.")

MAX_BYTES = 16 << 20
MAX_FILES = 10_000


@check(
    id="files/manifest",
    why="A version that is published never changes; one flipped bit is another cloth.",
    codes=(BROKEN, CHANGED, GONE, ADDED, DIGEST, NONE),
)
def manifest(asset: OpenAsset) -> Iterator[Finding]:
    """Every file is the one that was published, none is gone and none was added."""
    path = asset.folder / MANIFEST_FILE
    if not path.exists():
        yield NONE("there is no manifest, as before publishing")
        return
    try:
        stated, digest = _read(path)
    except (OSError, ValueError, RecursionError) as error:
        yield BROKEN(" ".join(str(error).split()), MANIFEST_FILE)
        return
    found = dict(_files(asset.folder))
    for name in sorted(stated.keys() - found.keys()):
        yield GONE("is gone", name)
    for name in sorted(found.keys() - stated.keys()):
        yield ADDED("was added", name)
    for name in sorted(stated.keys() & found.keys()):
        sha256 = _sha256(found[name])
        if sha256 != stated[name]:
            yield CHANGED(f"has SHA-256 {sha256}, was published with {stated[name]}", name)
    content = "".join(f"{sha256}  {name}\n" for name, sha256 in sorted(stated.items()))
    if hashlib.sha256(content.encode()).hexdigest() != digest:
        yield DIGEST("content_sha256 is not that of the files listed", MANIFEST_FILE)


def _read(path: Path) -> tuple[dict[str, str], Any]:
    """Return the SHA-256 stated for each file, and the one for all of them."""
    if not path.is_file() or path.stat().st_size > MAX_BYTES:
        raise ValueError(f"expected a file of at most {MAX_BYTES} bytes")
    data = json.loads(path.read_text(encoding="utf-8"))
    try:
        files = {str(record["path"]): str(record["sha256"]) for record in data["files"]}
        return files, data["content_sha256"]
    except (KeyError, TypeError) as error:
        raise ValueError(f"{type(error).__name__}: {error}") from None


def _files(folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield name and path of every file below `folder` but the manifest.

    Names are those of the disk: the manifest's own are compared with them and never opened.
    """
    count = 0
    for directory, folders, names in os.walk(folder):
        folders.sort()
        for name in sorted(names):
            path = Path(directory, name)
            count += 1
            if count > MAX_FILES:
                raise ValueError(f"{folder}: more than {MAX_FILES} files")
            relative = path.relative_to(folder).as_posix()
            if relative != MANIFEST_FILE:
                yield relative, path


def _sha256(path: Path) -> str:
    if path.is_symlink() or not path.is_file():
        return "none, for it is no plain file"
    with path.open("rb") as stream:
        digest = hashlib.sha256()
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()
