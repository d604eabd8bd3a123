"""Recomputing every hash of a published asset, of one version or of all."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from weaveusd.contract import MANIFEST_FILE, VERSION_PATTERN
from weaveusd.errors import InputError
from weaveusd.validate.integrity import Difference, differences


@dataclass(frozen=True, slots=True)
class VerifiedVersion:
    """The folder of a version, and how it differs from what was published."""

    folder: Path
    differences: tuple[Difference, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the version as JSON types."""
        return {
            "folder": str(self.folder),
            "differences": [difference.as_dict() for difference in self.differences],
        }


@dataclass(frozen=True, slots=True)
class Verification:
    """What became of the published files of an asset, version by version."""

    versions: tuple[VerifiedVersion, ...]

    @property
    def intact(self) -> bool:
        """Whether every file of every version is as it was published."""
        return not any(version.differences for version in self.versions)

    def as_dict(self) -> dict[str, Any]:
        """Return the verification as JSON types."""
        return {
            "status": "intact" if self.intact else "damaged",
            "versions": [version.as_dict() for version in self.versions],
        }


def verify(asset: str | os.PathLike[str]) -> Verification:
    """Return how the files of `asset` differ from those that were published.

    `asset` is the entry layer or the folder of a version, or the folder of an asset, whose
    versions are all looked at, by number.

    Raises
    ------
    InputError
        There is no published asset at `asset`, or a file of it cannot be read.
    """
    path = Path(asset)
    return Verification(tuple(_verified(folder) for folder in _folders(path)))


def _folders(path: Path) -> list[Path]:
    """Return the folders of the versions that `path` stands for."""
    folder = path if path.is_dir() else path.parent
    if not os.path.lexists(path):
        raise InputError(f"{path}: no such file or folder, expected a published asset")
    if os.path.lexists(folder / MANIFEST_FILE) or _is_version(folder.absolute().name):
        return [folder]
    versions = [] if folder != path else [n for n in os.listdir(path) if _is_version(n)]
    if not versions:
        raise InputError(f"{path}: no {MANIFEST_FILE} and no version, expected a published asset")
    return [path / name for name in sorted(versions, key=lambda name: (int(name[1:]), name))]


def _is_version(name: str) -> bool:
    return re.fullmatch(VERSION_PATTERN, name, re.ASCII) is not None and len(name) <= 10


def _verified(folder: Path) -> VerifiedVersion:
    if folder.is_symlink():
        link = Difference("changed", ".", "is a symbolic link, expected a folder")
        return VerifiedVersion(folder, (link,))
    try:
        return VerifiedVersion(folder, tuple(differences(folder)))
    except OSError as error:
        raise InputError(f"{error.filename or folder}: {error.strerror or error}") from error
    except ValueError as error:
        raise InputError(str(error)) from error
