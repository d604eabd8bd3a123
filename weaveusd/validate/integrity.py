"""Whether a published folder holds what its manifest lists, every file to the last bit.

Nothing here opens USD. Names in a manifest are compared with those on the disk and never opened.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from weaveusd.contract import MANIFEST_FILE

MAX_BYTES = 16 << 20
"""Bytes of a manifest that is read."""

MAX_FILES = 10_000
"""Files and folders of an asset that are looked at."""

Kind = Literal["missing", "added", "changed", "broken", "digest"]
"""What became of a file; the last two are of the manifest itself: of another form, or it does not
agree with itself."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A file that is not as published, by its path below the folder, and how."""

    kind: Kind
    path: str
    message: str

    def as_dict(self) -> dict[str, Any]:
        """Return the difference as JSON types."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class _Stated:
    """A manifest as read: size and SHA-256 by path."""

    files: dict[str, tuple[int, str]]
    agrees: bool  # both digests are those of what it lists


def differences(folder: Path) -> Iterator[Difference]:
    """Yield how the files below `folder` differ from its manifest, by path.

    A symbolic link, or anything else that is no plain file, is `added` or `changed`, whatever it
    leads to. A file of another size is not read.

    Raises
    ------
    ValueError
        There are more than `MAX_FILES` files and folders.
    OSError
        A file or folder cannot be read.
    """
    try:
        stated = _read(folder / MANIFEST_FILE)
    except FileNotFoundError:
        yield Difference("missing", MANIFEST_FILE, "is gone")
        return
    except (OSError, ValueError, RecursionError) as error:
        yield Difference("broken", MANIFEST_FILE, " ".join(str(error).split()))
        return
    found = dict(_walk(folder))
    found.pop(MANIFEST_FILE, None)
    for name in sorted(stated.files.keys() | found.keys()):
        if name not in found:
            yield Difference("missing", _shown(name), "is gone")
        elif name not in stated.files:
            what = "was added" if _is_plain(found[name]) else "was added, and is no plain file"
            yield Difference("added", _shown(name), what)
        elif (change := _change(found[name], *stated.files[name])) is not None:
            yield Difference("changed", _shown(name), change)
    if not stated.agrees:
        yield Difference("digest", MANIFEST_FILE, "its digests are not those of what it lists")


def _read(path: Path) -> _Stated:
    """Return the manifest; raises ValueError where it is not one as published, to the byte."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    with open(descriptor, "rb") as file:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise ValueError("found no plain file, expected one")
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise ValueError(f"expected a file of at most {MAX_BYTES} bytes")
    manifest = json.loads(data.decode())
    try:
        files = {str(r["path"]): (int(r["bytes"]), str(r["sha256"])) for r in manifest["files"]}
        content, own = manifest["content_sha256"], manifest.pop("manifest_sha256")
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{type(error).__name__}: {error}") from None
    if len(files) != len(manifest["files"]):
        raise ValueError("lists a file twice")
    if _canonical({**manifest, "manifest_sha256": own}) != data:
        raise ValueError("is not written as it was published")
    lines = "".join(f"{sha256}  {name}\n" for name, (_, sha256) in sorted(files.items()))
    agrees = content == _digest(lines.encode("utf-8", "surrogatepass"))
    return _Stated(files, agrees and own == _digest(_canonical(manifest)))


def _canonical(manifest: dict[str, Any]) -> bytes:
    return (json.dumps(manifest, indent=2, sort_keys=True) + "\n").encode()


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _walk(folder: Path) -> Iterator[tuple[str, Path]]:
    """Yield name and path of all below `folder` but plain folders, which are walked."""
    count = 0
    waiting = [""]
    while waiting:
        prefix = waiting.pop()
        with os.scandir(folder / prefix) as entries:
            for entry in entries:
                count += 1
                if count > MAX_FILES:
                    raise ValueError(f"{folder}: more than {MAX_FILES} files and folders")
                if entry.is_dir(follow_symlinks=False):
                    waiting.append(f"{prefix}{entry.name}/")
                else:
                    yield f"{prefix}{entry.name}", Path(entry.path)


def _is_plain(path: Path) -> bool:
    return stat.S_ISREG(path.lstat().st_mode)


def _change(path: Path, size: int, sha256: str) -> str | None:
    """Return how the file at `path` differs from one of `size` bytes and `sha256`, or None."""
    if not _is_plain(path):
        return "is no plain file, as was published"
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    with open(descriptor, "rb") as file:
        found = os.fstat(descriptor).st_size
        if found != size:
            return f"has {found} bytes, was published with {size}"
        digest = hashlib.sha256()
        while block := file.read(1 << 20):
            digest.update(block)
    if digest.hexdigest() != sha256:
        return f"has SHA-256 {digest.hexdigest()}, was published with {sha256}"
    return None


def _shown(name: str) -> str:
    """Return the name of a file, which need not be text, as text of one line."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in name)
