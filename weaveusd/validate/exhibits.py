"""What checks and reports show beside findings: pictures and a line about each."""

from __future__ import annotations

import base64
import struct
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bytes = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Exhibit:
    """A picture with its title and what it tells.

    `source` is a `data:` URI of a PNG.
    """

    group: str
    title: str
    text: str
    source: str

    def as_dict(self) -> dict[str, str]:
        """Return the exhibit as JSON types."""
        return {
            "group": self.group, "title": self.title, "text": self.text, "source": self.source,
        }  # fmt: skip


def of_display(pixels: Bytes) -> str:
    """Return (H, W, 3) or (H, W, 1) levels of 8 bits, row 0 at the top, as the URI of a PNG."""
    height, width, channels = pixels.shape
    rows = np.zeros((height, 1 + width * channels), np.uint8)
    rows[:, 1:] = pixels.reshape(height, -1)
    kind = {1: 0, 3: 2}[channels]
    head = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    data = (
        b"\x89PNG\r\n\x1a\n"
        + _chunk(b"IHDR", head)
        + _chunk(b"IDAT", zlib.compress(rows.tobytes(), 6))
        + _chunk(b"IEND", b"")
    )
    return "data:image/png;base64," + base64.b64encode(data).decode("ascii")


def of_linear(image: NDArray[Any]) -> str:
    """Return linear Rec.709 (H, W, 3), 1 being white, under the sRGB curve as a PNG's URI."""
    return of_display(np.rint(to_display(image) * 255).astype(np.uint8))


def of_share(values: NDArray[Any], largest: float) -> str:
    """Return a map (H, W) from 0, black, over red and yellow to `largest`, white, as a PNG."""
    x = np.clip(np.nan_to_num(values) / largest, 0, 1)
    colors = np.stack([np.clip(3 * x - k, 0, 1) for k in range(3)], axis=-1)
    return of_display(np.rint(colors * 255).astype(np.uint8))


def to_display(image: NDArray[Any]) -> NDArray[np.float64]:
    """Return linear values under the curve of sRGB (IEC 61966-2-1), 0 to 1."""
    x = np.clip(np.nan_to_num(np.asarray(image, np.float64)), 0, 1)
    return np.where(x <= 0.0031308, x * 12.92, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
