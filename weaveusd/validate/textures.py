"""Texture files of an asset: headers judged before memory is taken, pixels read in bands."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO

from weaveusd.contract import VECTOR_PNG_LEVELS
from weaveusd.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Pixels = NDArray[Any]
    Floats32 = NDArray[np.float32]

MAX_SIDE = 16384
"""Widest and highest texture that is decoded."""

MAX_CHANNELS = 4
CACHE_BYTES = 1 << 30
"""Sets of textures up to this size are decoded once; larger ones again for each check."""

BAND_TEXELS = 1 << 19


@dataclass(frozen=True, slots=True)
class Header:
    """What a texture file says of itself.

    `dtype` is NumPy's name of the stored type, `color_space` OpenImageIO's name of the space that
    the file states, or that its format implies.
    """

    width: int
    height: int
    channels: int
    dtype: str
    color_space: str

    @property
    def bytes(self) -> int:
        """Size of the decoded pixels."""
        return self.width * self.height * self.channels * np.dtype(self.dtype).itemsize


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """The same rows of several textures.

    `first` is the image row, counted from the top, of row 0 of every array. Arrays are
    (rows, width, channels) in the type of their file.
    """

    first: int
    pixels: Mapping[str, Pixels]

    def vectors(self, file: str) -> Floats32:
        """Return the texels of a vector texture as (rows, width, 3) components, -1…1."""
        return decode_vectors(self.pixels[file])


def decode_vectors(stored: Pixels) -> Floats32:
    """Return the components, -1…1, of vectors as 16-bit PNGs or EXRs store them."""
    if stored.dtype == np.uint16:
        return stored.astype(np.float32) / np.float32(VECTOR_PNG_LEVELS / 2) - np.float32(1)
    return stored.astype(np.float32)


class TextureFolder:
    """The textures of an asset by file name.

    Headers are read once. Pixels are decoded once and kept, in the types of their files, as
    long as all of them together stay below `CACHE_BYTES`.
    """

    __slots__ = ("_headers", "_pixels", "folder")

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._headers: dict[str, Header] = {}
        self._pixels: dict[str, Pixels] = {}

    def header(self, file: str) -> Header:
        """Return the header of `file`.

        Raises
        ------
        InputError
            When the file is missing, no image, or larger than is decoded.
        """
        if file not in self._headers:
            with _opened(self.folder / file) as source:
                self._headers[file] = _header(self.folder / file, source.spec())
        return self._headers[file]

    def bands(self, *files: str) -> Iterator[Band]:
        """Yield all rows of `files`, which are of one size, from the top down.

        Raises
        ------
        InputError
            When a file does not decode.
        """
        size = self.header(files[0])
        rows = max(1, BAND_TEXELS // size.width)
        with ExitStack() as stack:
            readers = {file: self._reader(file, stack) for file in files}
            for first in range(0, size.height, rows):
                last = min(first + rows, size.height)
                yield Band(first, {file: read(first, last) for file, read in readers.items()})

    def _reader(self, file: str, stack: ExitStack) -> Callable[[int, int], Pixels]:
        """Return what reads rows of `file`, which stays open in `stack` when it is not kept."""
        if file not in self._pixels:
            path, header = self.folder / file, self.header(file)
            source = stack.enter_context(_opened(path))
            # The file may have been exchanged since its header was judged.
            if _header(path, source.spec()) != header:
                raise InputError(f"{path}: changed while it was read")
            kept = sum(self._headers[name].bytes for name in self._pixels)
            if kept + header.bytes > CACHE_BYTES:
                return lambda first, last: _decode(path, source, first, last)
            self._pixels[file] = _decode(path, source, 0, header.height)
            self._pixels[file].setflags(write=False)
        pixels = self._pixels[file]
        return lambda first, last: pixels[first:last]


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    source = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        raise InputError(f"{path}: not an image: {_one_line(OpenImageIO.geterror())}")
    try:
        yield source
    finally:
        source.close()


def _header(path: Path, spec: Any) -> Header:
    if spec.deep or spec.depth > 1:
        raise InputError(f"{path}: a deep or volume image, expected a flat one")
    if not (0 < spec.width <= MAX_SIDE and 0 < spec.height <= MAX_SIDE):
        raise InputError(
            f"{path}: {spec.width} x {spec.height} texels, expected at most {MAX_SIDE} a side"
        )
    if spec.nchannels > MAX_CHANNELS:
        raise InputError(f"{path}: {spec.nchannels} channels, expected at most {MAX_CHANNELS}")
    stored = {"half": "float16", "float": "float32"}.get(str(spec.format), str(spec.format))
    space = str(spec.get_string_attribute("oiio:ColorSpace"))
    return Header(spec.width, spec.height, spec.nchannels, stored, space)


def _decode(path: Path, source: Any, first: int, last: int) -> Pixels:
    """Return rows `first` to `last` - 1; later rows of one source come after earlier ones."""
    spec = source.spec()
    pixels = source.read_scanlines(0, 0, first, last, 0, 0, spec.nchannels, spec.format)
    if pixels is None or source.has_error:
        raise InputError(f"{path}: does not decode: {_one_line(source.geterror())}")
    return np.asarray(pixels).reshape(last - first, spec.width, spec.nchannels)


def _one_line(text: str) -> str:
    return " ".join(text.split()) or "no reason given"
