"""Image files that a stage names: looked at before they are decoded, then read as numbers.

Arrays are top-down, as files are; whoever needs v = 0 first turns them.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from pxr import Ar, Sdf

from weaveusd.errors import StageError

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_SIDE = 16384
"""Texels along a side of an image that is read."""

MAX_CHANNELS = 64
"""Channels of an image that is read; the first four of them are."""

MAX_PACKED_BYTES = 1 << 30

Wrap = tuple[str | None, str | None]
"""`repeat`, `clamp`, `mirror` or `black` for s and t, as a file states them."""

_WRAPS = {"periodic": "repeat", "repeat": "repeat", "clamp": "clamp", "mirror": "mirror",
          "black": "black"}  # fmt: skip

_AS_STORED = oiio.ImageSpec()
_AS_STORED.attribute("oiio:UnassociatedAlpha", 1)  # color is not multiplied by alpha


@dataclass(frozen=True, slots=True, eq=False)
class Image:
    """A decoded file: 8- and 16-bit integers are scaled to 0…1, floats are as they are."""

    pixels: NDArray[np.float32]  # (H, W, channels), row 0 at the top
    bits: int  # of one stored channel
    is_float: bool
    wrap: Wrap = (None, None)


def resolved(asset: Any, where: str) -> str:
    """Return the path to which an asset value resolved.

    Raises
    ------
    StageError
        When there is none, no such file, or a pipe or device, which might be read forever; the
        message starts with `where`.
    """
    if not isinstance(asset, Sdf.AssetPath) or not asset.path:
        raise StageError(f"{where}: names no file")
    path = str(asset.resolvedPath)
    if not path:
        raise StageError(f"{where}: {asset.path} is not found")
    if os.path.exists(path) and not os.path.isfile(path):
        raise StageError(f"{where}: {asset.path} is no regular file")
    return path


def read_image(
    path: str, where: str, *, most_bytes: int | None = None, most_texels: int | None = None
) -> Image:
    """Return the image at a resolved path, which may lie inside a usdz package.

    Of more than four channels the first four are read.

    Raises
    ------
    StageError
        When the file is no image, holds a texel that is no finite number, is larger than
        `MAX_SIDE`, has more than `most_texels` or would take more than `most_bytes` of memory;
        sizes are taken from the header, before memory is.
    """
    with _on_disk(path, where) as file:
        opened = oiio.ImageInput.open(file, _AS_STORED)
        if opened is None:
            raise StageError(f"{where}: {path} is no image that can be read: {_reason()}")
        try:
            return _decode(opened, path, where, most_bytes, most_texels)
        finally:
            opened.close()


def linear(image: Image, color_space: str) -> NDArray[np.float32]:
    """Return the pixels as linear values.

    `color_space` is that of UsdUVTexture: `sRGB` decodes color, `raw` nothing, and `auto`
    decodes what has 8 bits and at least three channels. Alpha is never decoded.
    """
    channels = image.pixels.shape[2]
    by_guess = image.bits == 8 and not image.is_float and channels >= 3
    if color_space != "sRGB" and not (color_space == "auto" and by_guess):
        return image.pixels
    decoded = image.pixels.copy()
    colors = channels - 1 if channels in (2, 4) else channels
    decoded[..., :colors] = from_srgb(image.pixels[..., :colors])
    return decoded


def from_srgb(encoded: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return linear values of sRGB ones (IEC 61966-2-1)."""
    low = encoded / 12.92
    high = np.power((np.maximum(encoded, 0.04045) + 0.055) / 1.055, 2.4)
    return np.where(encoded <= 0.04045, low, high).astype(np.float32)


def to_srgb(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return sRGB values of linear ones, clipped to 0…1 (IEC 61966-2-1)."""
    clipped = np.clip(values, 0, 1)
    high = 1.055 * np.power(np.maximum(clipped, 0.0031308), 1 / 2.4) - 0.055
    return np.where(clipped <= 0.0031308, clipped * 12.92, high).astype(np.float32)


def _decode(
    opened: Any, path: str, where: str, most_bytes: int | None, most_texels: int | None
) -> Image:
    spec = opened.spec()
    if not (0 < spec.width <= MAX_SIDE and 0 < spec.height <= MAX_SIDE and spec.depth <= 1):
        raise StageError(
            f"{where}: {path} has {spec.width} x {spec.height} x {spec.depth} texels, "
            f"expected at most {MAX_SIDE} x {MAX_SIDE}"
        )
    if most_texels is not None and spec.width * spec.height > most_texels:
        raise StageError(
            f"{where}: {path} has {spec.width} x {spec.height} texels, "
            f"expected at most {most_texels} in all"
        )
    if not 0 < spec.nchannels <= MAX_CHANNELS:
        raise StageError(f"{where}: {path} has {spec.nchannels} channels, at most {MAX_CHANNELS}")
    channels = min(spec.nchannels, 4)
    size = spec.width * spec.height * channels * 4
    if most_bytes is not None and size > most_bytes:
        raise StageError(f"{where}: {path} takes {size} bytes, of which {most_bytes} are left")
    pixels = opened.read_image(0, 0, 0, channels, oiio.FLOAT)
    if pixels is None:
        raise StageError(f"{where}: {path} cannot be decoded: {_reason(opened)}")
    pixels = np.asarray(pixels, np.float32).reshape(spec.height, spec.width, channels)
    if not np.isfinite(pixels).all():
        raise StageError(f"{where}: {path} holds a texel that is no finite number")
    is_float = spec.format.basetype in (oiio.HALF, oiio.FLOAT, oiio.DOUBLE)
    return Image(pixels, spec.format.size() * 8, is_float, _wrap(spec))


def _wrap(spec: Any) -> Wrap:
    """Return the wrap modes that OpenImageIO's or USD's metadata state."""
    both = str(spec.getattribute("wrapmodes") or "").split(",")
    stated = [spec.getattribute(n) or b for n, b in zip(("wrapS", "wrapT"), both * 2, strict=False)]
    return _WRAPS.get(str(stated[0])), _WRAPS.get(str(stated[-1]))


@contextmanager
def _on_disk(path: str, where: str) -> Iterator[str]:
    """Give a file that decoders can open; what lies in a package is unpacked for the while."""
    if not Ar.IsPackageRelativePath(path):
        yield path
        return
    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(path))
    if not asset:
        raise StageError(f"{where}: {path} cannot be opened")
    if asset.GetSize() > MAX_PACKED_BYTES:
        raise StageError(f"{where}: {path} has {asset.GetSize()} bytes, at most {MAX_PACKED_BYTES}")
    with tempfile.TemporaryDirectory(prefix="weaveusd-") as folder:
        # The name inside the package is outside data: only its known endings are kept.
        suffix = os.path.splitext(Ar.SplitPackageRelativePathInner(path)[1])[1].lower()
        known = suffix if suffix in (".exr", ".png", ".jpg", ".jpeg", ".hdr", ".tif") else ""
        file = os.path.join(folder, "texture" + known)
        with open(file, "wb") as out:
            out.write(asset.GetBuffer())
        yield file


def _reason(opened: Any | None = None) -> str:
    text = (opened.geterror() if opened is not None else "") or oiio.geterror()
    return " ".join(str(text).split())[:200] or "unknown format"
