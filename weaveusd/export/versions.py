"""The versions of an asset on disk: which there are, and which one some content gets."""

from __future__ import annotations

import os
import re
from pathlib import Path

from weaveusd.contract import VERSION_PATTERN
from weaveusd.errors import InputError, VersionConflictError
from weaveusd.export.manifest import FileRecord, list_files

NEXT = "next"


def version_number(version: str) -> int | None:
    """Return the number of a version such as ``v002``, None for ``next``.

    Raises
    ------
    InputError
        `version` is neither.
    """
    if version == NEXT:
        return None
    if not re.fullmatch(VERSION_PATTERN, version, re.ASCII) or len(version) > 10:
        raise InputError(f"version {version[:40]!r}: expected 'next' or one such as 'v001'")
    number = int(version[1:])
    if number == 0 or version != f"v{number:03d}":
        raise InputError(f"version {version!r}: expected 'next' or one such as 'v001'")
    return number


def place(home: Path, number: int | None, files: tuple[FileRecord, ...]) -> tuple[Path, bool]:
    """Return the folder below `home` for content `files`, and whether it holds them already.

    With `number` None that is the newest version where it holds `files`, else the one after it.

    Raises
    ------
    InputError
        The version asked for is a symbolic link or a file.
    VersionConflictError
        The version asked for exists with other content.
    """
    taken = _versions(home)
    newest = max(taken, default=0)
    rival = newest if number is None else number
    if rival in taken:
        held = home / taken[rival]
        if _holds(held, files):
            return held, True
        if number is not None:
            refuse_links(held)
            raise VersionConflictError(f"{held}: exists with other content")
    return home / f"v{newest + 1 if number is None else number:03d}", False


def refuse_links(*folders: Path) -> None:
    """Raise InputError where one of `folders` is there and no folder of its own."""
    for folder in folders:
        if os.path.islink(folder):
            raise InputError(f"{folder}: a symbolic link, expected a folder")
        if os.path.exists(folder) and not os.path.isdir(folder):
            raise InputError(f"{folder}: a file, expected a folder")


def _versions(home: Path) -> dict[int, str]:
    """Return the names of what holds a version's place below `home`, by number."""
    try:
        names = os.listdir(home)
    except FileNotFoundError:
        return {}
    return {int(n[1:]): n for n in names if re.fullmatch(VERSION_PATTERN, n, re.ASCII)}


def _holds(folder: Path, files: tuple[FileRecord, ...]) -> bool:
    """Return whether `folder` holds exactly `files`, by content and not by its manifest."""
    if folder.is_symlink() or not folder.is_dir():
        return False
    try:
        return list_files(folder) == files
    except ValueError:
        return False
