"""Whether a PNG file is whole, from its chunks alone and without decoding it.

libpng and OpenImageIO do not notice when the disk refuses part of a PNG, and complain on the
terminal when they read one that is cut short. The chunks tell both beforehand.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import BinaryIO

SIGNATURE = b"\x89PNG\r\n\x1a\n"

_PIECE = 1 << 20


def png_fault(path: Path) -> str | None:
    """Return what is broken about the chunks of the PNG file `path`, None if they are whole.

    Every chunk must be there up to IEND and have its checksum (PNG 3rd edition, 5.3).
    """
    with path.open("rb") as file:
        if file.read(len(SIGNATURE)) != SIGNATURE:
            return "no PNG signature"
        kind = b""
        pixels = False
        while kind != b"IEND":
            head = file.read(8)
            if len(head) < 8:
                return "the file is cut short"
            length, kind = struct.unpack(">I4s", head)
            fault = _chunk_fault(file, length, kind)
            if fault is not None:
                return fault
            pixels = pixels or kind == b"IDAT"
    return None if pixels else "no pixels"


def _chunk_fault(file: BinaryIO, length: int, kind: bytes) -> str | None:
    checksum = zlib.crc32(kind)
    while length:
        piece = file.read(min(length, _PIECE))
        if not piece:
            return "the file is cut short"
        checksum = zlib.crc32(piece, checksum)
        length -= len(piece)
    stored = file.read(4)
    if len(stored) < 4:
        return "the file is cut short"
    if struct.unpack(">I", stored)[0] != checksum:
        return f"wrong checksum in chunk {kind.decode('ascii', 'replace')!r}"
    return None
