"""The manifest of an asset: every file with its size and digest, and one digest of all."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from weaveusd.contract import MANIFEST_FILE

_CHUNK = 1 << 20


@dataclass(frozen=True, slots=True, order=True)
class FileRecord:
    """A file of an asset: path below the asset's folder with ``/``, SHA-256, size."""

    path: str
    sha256: str
    bytes: int


def list_files(folder: Path) -> tuple[FileRecord, ...]:
    """Return a record of every file below `folder` but the manifest, sorted by path.

    Raises
    ------
    ValueError
        Something below `folder` is neither a file nor a folder, a symbolic link for one.
    """
    records = []
    for directory, folders, names in os.walk(folder):
        for name in (*folders, *names):
            path = Path(directory, name)
            if path.is_symlink() or not (path.is_file() or path.is_dir()):
                raise ValueError(f"{path}: neither a file nor a folder")
        for name in names:
            path = Path(directory, name)
            relative = path.relative_to(folder).as_posix()
            if relative != MANIFEST_FILE:
                records.append(FileRecord(relative, _sha256(path), path.stat().st_size))
    return tuple(sorted(records))


def content_digest(files: tuple[FileRecord, ...]) -> str:
    """Return one SHA-256 for the names and contents of `files`.

    It is the SHA-256 of what ``sha256sum`` prints for the files in this order: a line with
    digest, two spaces and path for each.
    """
    lines = "".join(f"{record.sha256}  {record.path}\n" for record in files)
    return hashlib.sha256(lines.encode()).hexdigest()


def write_manifest(
    folder: Path,
    asset: str,
    files: tuple[FileRecord, ...],
    losses: Sequence[Mapping[str, Any]] = (),
) -> None:
    """Write the manifest of `asset` into `folder`: JSON with sorted keys.

    `losses` are what the networks lose of the exact cloth, as JSON types, where that is known.
    Its `manifest_sha256` is the SHA-256 of the same text without that key, so that no bit of the
    manifest changes unseen either.
    """
    manifest: dict[str, Any] = {
        "asset": asset,
        "content_sha256": content_digest(files),
        "files": [asdict(record) for record in files],
    }
    if losses:
        manifest["losses"] = list(losses)
    manifest["manifest_sha256"] = hashlib.sha256(_text(manifest)).hexdigest()
    (folder / MANIFEST_FILE).write_bytes(_text(manifest))


def _text(manifest: dict[str, Any]) -> bytes:
    return (json.dumps(manifest, indent=2, sort_keys=True) + "\n").encode()


def _sha256(path: Path) -> str:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        while chunk := file.read(_CHUNK):
            digest.update(chunk)
    return digest.hexdigest()
