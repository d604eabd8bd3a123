"""The zip file of a usdz: stored, aligned, and the same bytes for the same files."""

from __future__ import annotations

import shutil
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

from weaveusd.errors import WeaveusdError

ALIGNMENT = 64
"""Every file in a package begins at a multiple of so many bytes (USDZ specification)."""

MAX_BYTES = (1 << 32) - 1
"""Size of a package: the format knows no zip64."""

_FIRST_DATE = (1980, 1, 1, 0, 0, 0)
_LOCAL_HEADER = 30
_FIELD_HEADER = 4
_PADDING_ID = 0x5753
_ENTRY_BYTES = 1024


def write_package(package: Path, files: Sequence[tuple[str, Path]]) -> None:
    """Write the new zip file `package` of `files`, (name, path), in their order.

    Entries carry the first date that zip knows, no owner and no compression.

    Raises
    ------
    WeaveusdError
        A file is missing, all are too large together, or the disk refused.
    """
    try:
        size = sum(path.stat().st_size + _ENTRY_BYTES for _, path in files)
        if size > MAX_BYTES:
            raise WeaveusdError(
                f"{package}: {size} bytes to pack, expected at most {MAX_BYTES} in a usdz; "
                "a lower resolution has less"
            )
        with package.open("xb") as out, zipfile.ZipFile(out, "w", allowZip64=False) as archive:
            for name, path in files:
                info = zipfile.ZipInfo(name, _FIRST_DATE)
                info.create_system = 0
                info.external_attr = 0
                info.file_size = path.stat().st_size
                info.extra = _padding(out, name)
                with path.open("rb") as source, archive.open(info, "w") as target:
                    shutil.copyfileobj(source, target, 1 << 20)
    except OSError as error:
        raise WeaveusdError(f"{error.filename or package}: {error.strerror or error}") from error


def _padding(out: BinaryIO, name: str) -> bytes:
    """Return an extra field after which the content of the next entry is aligned."""
    begin = out.tell() + _LOCAL_HEADER + len(name.encode()) + _FIELD_HEADER
    count = -begin % ALIGNMENT
    return _PADDING_ID.to_bytes(2, "little") + count.to_bytes(2, "little") + bytes(count)
