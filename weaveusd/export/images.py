"""Image files: read with limits, written row by row; the only place where OpenImageIO is used.

Rows of every array here run from the top of the picture down.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813

from weaveusd.errors import InputError, WeaveusdError
from weaveusd.export.png import png_fault

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bytes = NDArray[np.uint8]
    Floats32 = NDArray[np.float32]

Metadata = str | float | int | tuple[float, ...]

MAX_PIXELS = 2**26
MAX_CHANNELS = 8
INCH_MM = 25.4

_FORMATS = {"uint8": oiio.UINT8, "uint16": oiio.UINT16, "float16": oiio.HALF}
CONSTANT_TIME = "2000:01:01 00:00:00"


def read_image(path: Path) -> Bytes | Floats32:
    """Return the image in `path` as (height, width, channels), top row first, values as stored.

    Files of 8 bits a channel come back as uint8. All others come back as float32: integers of
    more bits divided by their maximum, floats unchanged. Alpha is never multiplied in. The size
    is judged from the header, before any memory is taken for pixels.

    Raises
    ------
    InputError
        The file is missing, no image, deep or volumetric, larger than `MAX_PIXELS` pixels,
        of more than `MAX_CHANNELS` channels, or cut short.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), config)
    if source is None:
        raise InputError(f"{path}: not a readable image: {_one_line(oiio.geterror())}")
    try:
        spec = source.spec()
        _check_size(path, spec)
        if source.format_name() == "png" and (fault := png_fault(path)) is not None:
            raise InputError(f"{path}: broken image: {fault}")
        kind = oiio.UINT8 if spec.format == oiio.UINT8 else oiio.FLOAT
        pixels = source.read_image(0, 0, 0, spec.nchannels, kind)
        if pixels is None:
            raise InputError(f"{path}: broken image: {_one_line(source.geterror())}")
    finally:
        source.close()
    image: Bytes | Floats32 = np.ascontiguousarray(pixels)
    return image.reshape(spec.height, spec.width, spec.nchannels)


def write_png8(path: Path, pixels: Bytes) -> None:
    """Write (H, W, 1…4) uint8 `pixels`, top row first, as a PNG tagged sRGB.

    Raises
    ------
    ValueError
        `pixels` has another shape or type.
    WeaveusdError
        The file could not be written.
    """
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or not 1 <= pixels.shape[2] <= 4:
        raise ValueError(f"expected (H, W, 1…4) uint8, got {pixels.shape} {pixels.dtype}")
    height, width, channels = pixels.shape
    with ImageWriter(
        path, width, height, channels, "uint8", {"oiio:ColorSpace": "srgb_rec709_scene"}
    ) as out:
        out.write(pixels)


def density(width: int, height: int, size_mm: tuple[float, float]) -> dict[str, Metadata]:
    """Return the metadata that state the physical size of an image, in pixels per inch."""
    x_per_inch = width / size_mm[0] * INCH_MM
    y_per_inch = height / size_mm[1] * INCH_MM
    return {
        # Always in inches: OpenImageIO turns "cm" the wrong way round for EXR.
        "ResolutionUnit": "in",
        "XResolution": x_per_inch,
        "YResolution": y_per_inch,
        "PixelAspectRatio": y_per_inch / x_per_inch,
    }


def state(spec: Any, metadata: Mapping[str, Metadata]) -> None:
    """Let a file of `spec` state `metadata`."""
    for key, value in metadata.items():
        if isinstance(value, tuple):
            spec.attribute(key, oiio.TypeDesc(f"float[{len(value)}]"), value)
        else:
            spec.attribute(key, value)


class ImageWriter:
    """A PNG or EXR file written from the top row down; the same rows give the same bytes.

    Parameters
    ----------
    path
        File to write; its suffix chooses the format.
    width, height, channels
        Size of the whole image.
    dtype
        NumPy name of the stored type: `uint8`, `uint16` or `float16`.
    metadata
        OpenImageIO attributes; a tuple is an array of floats.

    Raises
    ------
    WeaveusdError
        The file could not be opened, written or, on leaving the context, closed whole.
    """

    __slots__ = ("_dtype", "_out", "_path", "_row", "_shape")

    def __init__(
        self,
        path: Path,
        width: int,
        height: int,
        channels: int,
        dtype: str,
        metadata: Mapping[str, Metadata],
    ) -> None:
        spec = oiio.ImageSpec(width, height, channels, _FORMATS[dtype])
        state(spec, metadata)
        spec.attribute("oiio:UnassociatedAlpha", 1)
        if path.suffix == ".exr":
            spec.attribute("compression", "zip")
            spec.attribute("DateTime", CONSTANT_TIME)
        self._path = path
        self._dtype = np.dtype(dtype)
        self._shape = (height, width, channels)
        self._row = 0
        self._out: Any = oiio.ImageOutput.create(str(path))
        if self._out is None:
            raise WeaveusdError(f"{path}: no writer: {_one_line(oiio.geterror())}")
        if not self._out.open(str(path), spec):
            raise self._failure()

    def write(self, rows: NDArray[Any]) -> None:
        """Append `rows`, (n, width, channels) of the stored type, below those written so far."""
        height, width, channels = self._shape
        last = self._row + len(rows)
        if rows.dtype != self._dtype or rows.shape[1:] != (width, channels) or last > height:
            raise ValueError(f"{self._path}: unexpected rows {rows.shape} {rows.dtype}")
        if not self._out.write_scanlines(self._row, last, 0, np.ascontiguousarray(rows)):
            raise self._failure()
        self._row = last

    def __enter__(self) -> ImageWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        closed = self._out.close()
        if kind is not None:
            return
        if self._row != self._shape[0]:
            raise ValueError(f"{self._path}: {self._row} rows of {self._shape[0]} were written")
        if not closed:
            raise self._failure()
        fault = _written_fault(self._path)
        if fault is not None:
            raise WeaveusdError(f"{self._path}: cannot be written, is the disk full? {fault}")

    def _failure(self) -> WeaveusdError:
        return WeaveusdError(f"{self._path}: cannot be written: {_one_line(self._out.geterror())}")


def _check_size(path: Path, spec: Any) -> None:
    if spec.deep or spec.depth > 1:
        raise InputError(f"{path}: a deep or volume image, expected a flat one")
    if spec.width * spec.height > MAX_PIXELS:
        raise InputError(
            f"{path}: {spec.width} x {spec.height} pixels, expected at most {MAX_PIXELS}"
        )
    if spec.nchannels > MAX_CHANNELS:
        raise InputError(f"{path}: {spec.nchannels} channels, expected at most {MAX_CHANNELS}")


def _written_fault(path: Path) -> str | None:
    """Return what is wrong with a file just closed, None if it is whole.

    A full disk goes unnoticed by OpenImageIO in any part of a PNG and at the end of an EXR.
    """
    if path.suffix == ".png":
        return png_fault(path)
    written = oiio.ImageInput.open(str(path))
    if written is None:
        return _one_line(oiio.geterror())
    try:
        spec = written.spec()
        last = written.read_scanlines(spec.height - 1, spec.height, 0, 0, 1, oiio.FLOAT)
        return _one_line(written.geterror()) if last is None else None
    finally:
        written.close()


def _one_line(message: str) -> str:
    return " ".join(message.split()) or "no reason given"
