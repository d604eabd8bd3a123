"""Files that a command is told to write: whole or not at all, and never through a link."""

from __future__ import annotations

import contextlib
import os
import secrets
from pathlib import Path

from weaveusd.errors import InputError, WeaveusdError


def check_target(what: str, path: Path) -> None:
    """Raise InputError unless a file can be made at `path`; `what` names it in the message."""
    if os.path.islink(path):
        raise InputError(f"{what} {path}: a symbolic link, expected a file")
    if os.path.exists(path) and not os.path.isfile(path):
        raise InputError(f"{what} {path}: a folder, pipe or device, expected a file")
    if not os.path.isdir(path.parent):
        raise InputError(f"{what} {path}: the folder {path.parent} does not exist")


def write_whole(path: Path, data: bytes) -> None:
    """Write `data` to the file `path`, which appears or is replaced when it is complete.

    Raises
    ------
    WeaveusdError
        The file cannot be written; nothing of it is left.
    """
    part = path.with_name(f".{path.name[:32]}.{secrets.token_hex(4)}.part")
    try:
        with part.open("xb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except (OSError, ValueError) as error:
        with contextlib.suppress(OSError, ValueError):
            part.unlink(missing_ok=True)
        reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
        raise WeaveusdError(f"{path}: cannot be written: {reason}") from error
