"""Locks between publishers, held by open files so that a killed process holds none."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from weaveusd.errors import InputError

STAGING_PREFIX = ".publish.tmp-"

_LOCK = ".publish.lock"
_OWNER = "owner.lock"
_CONTENT = "asset"


@contextmanager
def locked_folder(folder: Path) -> Iterator[None]:
    """Hold the lock of `folder`, made if missing, against all other processes and threads.

    The lock's file is removed again on leaving, and `folder` with it if nothing else is there.
    """
    path = folder / _LOCK
    descriptor = _acquire(folder, path)
    try:
        yield
    finally:
        path.unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            folder.rmdir()
        os.close(descriptor)


@contextmanager
def staging_folder(home: Path) -> Iterator[Path]:
    """Make an empty hidden folder below `home` to prepare a version in, and remove what is left.

    Whatever dead owners left behind below `home` is removed first.
    """
    with locked_folder(home):
        _remove_orphans(home)
        outer = Path(tempfile.mkdtemp(prefix=STAGING_PREFIX, dir=home))
        try:
            owner = os.open(outer / _OWNER, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        except BaseException:
            shutil.rmtree(outer, ignore_errors=True)
            raise
        fcntl.flock(owner, fcntl.LOCK_EX)
    try:
        content = outer / _CONTENT
        content.mkdir()
        yield content
    finally:
        with locked_folder(home):
            shutil.rmtree(outer, ignore_errors=True)
            os.close(owner)


def _acquire(folder: Path, path: Path) -> int:
    while True:
        folder.mkdir(parents=True, exist_ok=True)
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        except FileNotFoundError:
            continue  # the folder was empty, and its last owner has just removed it
        except OSError as error:
            if path.is_symlink():
                raise InputError(f"{path}: a symbolic link, expected a lock's file") from error
            raise
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        if _is_still(path, descriptor):
            return descriptor
        os.close(descriptor)


def _is_still(path: Path, descriptor: int) -> bool:
    """Return whether `path` still names the open file: its last owner removes it."""
    try:
        found = os.stat(path, follow_symlinks=False)
    except FileNotFoundError:
        return False
    return os.path.samestat(found, os.fstat(descriptor))


def _remove_orphans(home: Path) -> None:
    for outer in home.glob(f"{STAGING_PREFIX}*"):
        if outer.is_symlink() or not outer.is_dir():
            continue
        try:
            owner = os.open(outer / _OWNER, os.O_RDWR | os.O_NOFOLLOW)
        except FileNotFoundError:
            # Owners make their lock while they hold that of `home`, so this one is dead.
            shutil.rmtree(outer, ignore_errors=True)
            continue
        try:
            fcntl.flock(owner, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            continue
        else:
            shutil.rmtree(outer, ignore_errors=True)
        finally:
            os.close(owner)
