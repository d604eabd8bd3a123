"""Texture files of an asset: headers judged before memory is taken, pixels read in bands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
    Words = NDArray[np.uint16]

MAX_SIDE = 16384
"""Widest and highest texture that is decoded."""

MAX_CHANNELS = 4

BAND_TEXELS = 1 << 19
CHUNK_ROWS = 16
"""Rows that an EXR of this package compresses together: bands begin where such a chunk does."""


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

    def spans(self) -> Iterator[tuple[int, int]]:
        """Yield the first row and the one behind the last of each band, from the top down."""
        rows = max(1, BAND_TEXELS // self.width)
        rows = max(CHUNK_ROWS, rows - rows % CHUNK_ROWS)
        for first in range(0, self.height, rows):
            yield first, min(first + rows, self.height)


@dataclass(frozen=True, slots=True, eq=False)
class Band:
    """The same rows of several textures.

    `first` is the image row, counted from the top, of row 0 of every array. Arrays are
    (rows, width, channels) in the type of their file.
    """

    first: int
    pixels: Mapping[str, Pixels]

    def words(self, file: str) -> Words:
        """Return the texels of a texture of 16 bits as the bits that its file stores."""
        return np.ascontiguousarray(self.pixels[file]).view(np.uint16)


def decode_vectors(stored: Pixels) -> Floats32:
    """Return the components, -1…1, of vectors as 16-bit PNGs or EXRs store them."""
    if stored.dtype == np.uint16:
        return stored.astype(np.float32) / np.float32(VECTOR_PNG_LEVELS / 2) - np.float32(1)
    return stored.astype(np.float32)


_WORDS = np.arange(1 << 16, dtype=np.uint16)

HALVES = _WORDS.view(np.float16).astype(np.float32)
"""The number that each 16 bits are as a half float: (65536,) float32."""

VECTOR_LEVELS = decode_vectors(_WORDS)
"""The component of a vector that each level of a 16-bit PNG stands for: (65536,) float32."""


def vector_table(file: str) -> Floats32:
    """Return what each 16 bits of the vector texture `file` stand for."""
    return VECTOR_LEVELS if file.endswith(".png") else HALVES


class Reader:
    """A texture file that is open; rows are read from the top down.

    Raises
    ------
    InputError
        When the file cannot be opened, or is not what `header` says any longer.
    """

    __slots__ = ("_path", "_source")

    def __init__(self, path: Path, header: Header, stack: ExitStack) -> None:
        self._path = path
        self._source = stack.enter_context(_opened(path))
        # The file may have been exchanged since its header was judged.
        if _header(path, self._source.spec()) != header:
            raise InputError(f"{path}: changed while it was read")

    def read(self, first: int, last: int) -> Pixels:
        """Return rows `first` to `last` - 1 as (rows, width, channels) in the stored type.

        Raises InputError when they do not decode.
        """
        source, spec = self._source, self._source.spec()
        pixels = source.read_scanlines(0, 0, first, last, 0, 0, spec.nchannels, spec.format)
        if pixels is None or source.has_error:
            raise InputError(f"{self._path}: does not decode: {_one_line(source.geterror())}")
        return np.asarray(pixels).reshape(last - first, spec.width, spec.nchannels)


class TextureFolder:
    """The textures of an asset by file name. Headers are read once, pixels never kept.

    Those in the folder `own` of a colorway stand before those of the same name in `folder`.
    """

    __slots__ = ("_headers", "folder", "own")

    def __init__(self, folder: Path, own: Path | None = None) -> None:
        self.folder, self.own = folder, own
        self._headers: dict[str, Header] = {}

    def path(self, file: str) -> Path:
        """Return where `file` lies."""
        if self.own is not None and (self.own / file).is_file():
            return self.own / file
        return self.folder / file

    def header(self, file: str) -> Header:
        """Return the header of `file`.

        Raises
        ------
        InputError
            When the file is missing, no image, or larger than is decoded.
        """
        if file not in self._headers:
            with _opened(self.path(file)) as source:
                self._headers[file] = _header(self.path(file), source.spec())
        return self._headers[file]

    def open(self, file: str, stack: ExitStack) -> Reader:
        """Return what reads the rows of `file`, which stays open in `stack`."""
        return Reader(self.path(file), self.header(file), stack)

    def bands(self, *files: str) -> Iterator[Band]:
        """Yield all rows of `files`, which are of one size, from the top down.

        Raises
        ------
        InputError
            When a file does not decode.
        """
        with ExitStack() as stack:
            readers = {file: self.open(file, stack) for file in files}
            for first, last in self.header(files[0]).spans():
                yield Band(first, {f: reader.read(first, last) for f, reader in readers.items()})


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


def _one_line(text: str) -> str:
    return " ".join(text.split()) or "no reason given"
