"""Publishing: a version of an asset appears whole, checked and once, or not at all.

``<root>/<asset>/v001`` is written in a hidden folder beside it, checked there, flushed to disk
and renamed. A version is new only if its content is. Locks are held by open files, so that a
killed run leaves none; what it wrote is removed by the next run.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from weaveusd.contract import MATERIAL_NAME, VERSION_PATTERN, entry_layer
from weaveusd.errors import InputError, VersionConflictError, WeaveusdError
from weaveusd.export.locks import locked_folder, staging_folder
from weaveusd.export.manifest import FileRecord, content_digest, list_files, write_manifest
from weaveusd.export.names import safe_name

NEXT = "next"


@dataclass(frozen=True, slots=True)
class PublishedAsset:
    """A version of an asset on disk; `unchanged` if it was there before with this content.

    `material` is the path of the material prim in the entry layer. `files` lists all content,
    which is everything but the manifest, sorted by path.
    """

    status: Literal["published", "unchanged"]
    asset: str
    version: str
    folder: Path
    entry: Path
    material: str
    content_sha256: str
    files: tuple[FileRecord, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the asset as JSON types."""
        return {
            "status": self.status,
            "asset": self.asset,
            "version": self.version,
            "folder": str(self.folder),
            "entry": str(self.entry),
            "material": self.material,
            "content_sha256": self.content_sha256,
            "files": [asdict(record) for record in self.files],
        }


def publish_asset(
    root: Path,
    name: str,
    write: Callable[[Path], object],
    check: Callable[[Path], object] | None = None,
    version: str = NEXT,
) -> PublishedAsset:
    """Publish what `write` writes as a version of asset `name` below `root`.

    `write` gets an empty folder, `check` that folder complete with its manifest; an exception
    from either leaves `root` as it was. Where the newest version (or the one asked for) holds
    the same files already, nothing is kept and the result is `unchanged`.

    Parameters
    ----------
    root
        Folder of all assets; made if missing.
    name
        Name of the asset, one that `safe_name` returned.
    write
        Writes the asset with its entry layer.
    check
        Raises to refuse the asset.
    version
        ``next``, or a version such as ``v002``.

    Raises
    ------
    ValueError
        `name` is not safe, or `write` wrote no entry layer.
    InputError
        `version` is none, or `root` or a folder below it is a symbolic link or a file.
    VersionConflictError
        The version asked for exists with other content.
    WeaveusdError
        The disk refused.
    """
    if safe_name(name) != name:
        raise ValueError(f"{name!r} is no safe name, {safe_name(name)!r} is")
    number = None if version == NEXT else _version_number(version)
    home = root / name
    _refuse_links(root, home)
    made = not root.exists()
    try:
        home.mkdir(parents=True, exist_ok=True)
        with staging_folder(home) as staged:
            write(staged)
            if not (staged / entry_layer(name)).is_file():
                raise ValueError(f"the asset has no entry layer {entry_layer(name)}")
            files = list_files(staged)
            write_manifest(staged, name, files)
            if check is not None:
                check(staged)
            _flush(staged)
            with locked_folder(home):
                return _settle(staged, home, name, number, files)
    except OSError as error:
        raise WeaveusdError(f"{error.filename or home}: {error.strerror or error}") from error
    finally:
        if made:
            # Succeeds only where nothing was published.
            with contextlib.suppress(OSError):
                root.rmdir()


def _settle(
    staged: Path, home: Path, name: str, number: int | None, files: tuple[FileRecord, ...]
) -> PublishedAsset:
    """Give the staged asset its version, or find the one that it equals; under the lock."""
    taken = _versions(home)
    newest = max(taken, default=0)
    rival = newest if number is None else number
    if rival in taken:
        held = home / taken[rival]
        if _holds(held, files):
            return _published("unchanged", held, name, files)
        if number is not None:
            _refuse_links(held)
            raise VersionConflictError(f"{held}: exists with other content")
    target = home / f"v{newest + 1 if number is None else number:03d}"
    os.rename(staged, target)
    _flush_folder(home)
    _flush_folder(home.parent)
    return _published("published", target, name, files)


def _published(
    status: Literal["published", "unchanged"],
    folder: Path,
    name: str,
    files: tuple[FileRecord, ...],
) -> PublishedAsset:
    return PublishedAsset(
        status=status,
        asset=name,
        version=folder.name,
        folder=folder,
        entry=folder / entry_layer(name),
        material=f"/{name}/{MATERIAL_NAME}",
        content_sha256=content_digest(files),
        files=files,
    )


def _version_number(version: str) -> int:
    if not re.fullmatch(VERSION_PATTERN, version, re.ASCII) or len(version) > 10:
        raise InputError(f"version {version[:40]!r}: expected 'next' or one such as 'v001'")
    number = int(version[1:])
    if number == 0 or version != f"v{number:03d}":
        raise InputError(f"version {version!r}: expected 'next' or one such as 'v001'")
    return number


def _versions(home: Path) -> dict[int, str]:
    """Return the names of what holds a version's place below `home`, by number."""
    names = (entry.name for entry in os.scandir(home))
    return {int(n[1:]): n for n in names if re.fullmatch(VERSION_PATTERN, n, re.ASCII)}


def _holds(folder: Path, files: tuple[FileRecord, ...]) -> bool:
    """Return whether `folder` holds exactly `files`, by content and not by its manifest."""
    if folder.is_symlink() or not folder.is_dir():
        return False
    try:
        return list_files(folder) == files
    except ValueError:
        return False


def _refuse_links(*folders: Path) -> None:
    for folder in folders:
        if folder.is_symlink():
            raise InputError(f"{folder}: a symbolic link, expected a folder")
        if folder.exists() and not folder.is_dir():
            raise InputError(f"{folder}: a file, expected a folder")


def _flush(folder: Path) -> None:
    """Flush all files and folders below `folder` to disk, and `folder` itself."""
    for directory, _, names in os.walk(folder):
        for name in names:
            _flush_file(os.path.join(directory, name), os.O_RDONLY)
        _flush_folder(Path(directory))


def _flush_folder(folder: Path) -> None:
    _flush_file(os.fspath(folder), os.O_RDONLY | os.O_DIRECTORY)


def _flush_file(path: str, flags: int) -> None:
    descriptor = os.open(path, flags)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
