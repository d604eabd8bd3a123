"""Publishing: a version of an asset appears whole, checked and once, or not at all.

``<root>/<asset>/v001`` is written in a hidden folder beside it, checked there, flushed to disk
and renamed. A version is new only if its content is. Locks are held by open files, so that a
killed run leaves none; what it wrote is removed by the next run.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from weaveusd.contract import MANIFEST_FILE, MATERIAL_NAME, entry_layer
from weaveusd.errors import InputError, WeaveusdError
from weaveusd.export.locks import locked_folder, staging_folder
from weaveusd.export.manifest import FileRecord, content_digest, list_files, write_manifest
from weaveusd.export.names import safe_name
from weaveusd.export.versions import NEXT, place, refuse_links, version_number

Status = Literal["published", "unchanged", "would-publish"]


@dataclass(frozen=True, slots=True)
class PublishedAsset:
    """A version of an asset on disk; `unchanged` if it was there before with this content.

    One that a dry run `would-publish` is not there.

    `material` is the path of the material prim in the entry layer. `files` lists all content,
    which is everything but the manifest, sorted by path.
    """

    status: Status
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
    losses: Sequence[Mapping[str, Any]] = (),
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
    losses
        What the manifest states that the networks lose of the exact cloth.

    Raises
    ------
    ValueError
        `name` is not safe, or `write` wrote no entry layer.
    InputError
        `version` is none, or `root` or a folder below it is a symbolic link or a file, or its name
        is no UTF-8.
    VersionConflictError
        The version asked for exists with other content.
    WeaveusdError
        The disk refused.
    """
    _check(root, name)
    number = version_number(version)
    home = root / name
    refuse_links(root, home)
    made = not os.path.exists(root)
    try:
        with _told_in_one_line(home):
            home.mkdir(parents=True, exist_ok=True)
            with staging_folder(home) as staged:
                files = _prepare(staged, name, write, check, losses)
                _flush(staged)
                with locked_folder(home):
                    return _settle(staged, home, name, number, files)
    finally:
        if made:
            # Succeeds only where nothing was published.
            with contextlib.suppress(OSError):
                root.rmdir()


def plan_asset(
    root: Path,
    name: str,
    write: Callable[[Path], object],
    check: Callable[[Path], object] | None = None,
    version: str = NEXT,
    losses: Sequence[Mapping[str, Any]] = (),
) -> PublishedAsset:
    """Return what `publish_asset` would do, and touch nothing below `root`.

    The asset is written and checked all the same, in a temporary folder of the system that is
    removed at the end. The status is `unchanged`, or `would-publish` with the version, folder and
    entry that the asset would get now.

    Raises
    ------
    ValueError, InputError, VersionConflictError, WeaveusdError
        As `publish_asset` does.
    """
    _check(root, name)
    number = version_number(version)
    home = root / name
    refuse_links(root, home)
    with (
        _told_in_one_line(home),
        tempfile.TemporaryDirectory(prefix="weaveusd-") as folder,
    ):
        staged = Path(folder, "asset")
        staged.mkdir()
        files = _prepare(staged, name, write, check, losses)
        planned, held = place(home, number, files)
        return _asset("unchanged" if held else "would-publish", planned, name, files)


def _prepare(
    staged: Path,
    name: str,
    write: Callable[[Path], object],
    check: Callable[[Path], object] | None,
    losses: Sequence[Mapping[str, Any]],
) -> tuple[FileRecord, ...]:
    """Have the asset written into the empty folder `staged` and checked; return its files."""
    write(staged)
    if not (staged / entry_layer(name)).is_file():
        raise ValueError(f"the asset has no entry layer {entry_layer(name)}")
    files = list_files(staged)
    if not (staged / MANIFEST_FILE).exists():  # a copy of a version brings its own
        write_manifest(staged, name, files, losses)
    if check is not None:
        check(staged)
    return files


def _settle(
    staged: Path, home: Path, name: str, number: int | None, files: tuple[FileRecord, ...]
) -> PublishedAsset:
    """Give the staged asset its version, or find the one that it equals; under the lock."""
    folder, held = place(home, number, files)
    if held:
        return _asset("unchanged", folder, name, files)
    # What was a folder when the asset was begun may have been replaced by a link since.
    refuse_links(home.parent, home)
    os.rename(staged, folder)
    for above in (home, home.parent, home.absolute().parent.parent):  # the root may be new too
        _flush_folder(above)
    return _asset("published", folder, name, files)


def _asset(
    status: Status, folder: Path, name: str, files: tuple[FileRecord, ...]
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


@contextmanager
def _told_in_one_line(home: Path) -> Iterator[None]:
    """Raise WeaveusdError for what the disk refuses inside."""
    try:
        yield
    except OSError as error:
        raise WeaveusdError(f"{error.filename or home}: {error.strerror or error}") from error


def _check(root: Path, name: str) -> None:
    if safe_name(name) != name:
        raise ValueError(f"{name!r} is no safe name, {safe_name(name)!r} is")
    try:
        str(root.absolute()).encode()
    except UnicodeEncodeError:
        raise InputError(f"{str(root)!r}: not UTF-8, expected a folder that USD can open") from None


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
