"""Reads textures back in bands of rows, the top one first, to make other files of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813

from weaveusd.contract import VECTOR_PNG_LEVELS
from weaveusd.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bytes = NDArray[np.uint8]
    Words = NDArray[np.uint16]
    Floats = NDArray[np.float32]

Rows = dict[str, "NDArray[Any]"]
"""Rows of every texture by its key, (n, W, channels), numbers as stored; halves as float32."""

BAND_TEXELS = 1 << 19


def read_bands(files: Mapping[str, Path]) -> Iterator[Rows]:
    """Yield all rows of the images `files`, which are of one size, in bands.

    A band has about `BAND_TEXELS` texels, so that memory does not grow with the resolution.

    Raises
    ------
    InputError
        An image is missing or broken, or of another size than the others.
    """
    with ExitStack() as stack:
        sources = {key: _open(path, stack) for key, path in files.items()}
        specs = {key: source.spec() for key, source in sources.items()}
        width, height = next(iter((spec.width, spec.height) for spec in specs.values()))
        for key, spec in specs.items():
            if (spec.width, spec.height) != (width, height):
                raise InputError(
                    f"{files[key]}: {spec.width} x {spec.height} texels, "
                    f"expected {width} x {height}"
                )
        rows = max(1, BAND_TEXELS // width)
        for first in range(0, height, rows):
            last = min(height, first + rows)
            yield {key: _read(sources[key], files[key], first, last) for key in files}


def size_of(path: Path) -> tuple[int, int]:
    """Return width and height of the image `path` in texels.

    Raises
    ------
    InputError
        It is missing or no image.
    """
    with ExitStack() as stack:
        spec = _open(path, stack).spec()
        return int(spec.width), int(spec.height)


def vectors(levels: Words) -> Floats:
    """Return the unit vectors (…, 3) that 16-bit `levels` of a PNG stand for."""
    half = np.float32(VECTOR_PNG_LEVELS // 2)
    return (levels.astype(np.float32) - half) / half


def across_fibre(normal: Floats, fibre: Floats) -> Floats:
    """Return where highlights are wide, in the plane of the cloth: (…, 2), unit.

    It is x and y of normal × fibre, both (…, 3) in the cloth frame; x where that is upright.
    """
    x = normal[..., 1] * fibre[..., 2] - normal[..., 2] * fibre[..., 1]
    y = normal[..., 2] * fibre[..., 0] - normal[..., 0] * fibre[..., 2]
    length = np.sqrt(x * x + y * y)
    flat = length > np.float32(1e-3)
    length = np.where(flat, length, np.float32(1))
    return np.stack([np.where(flat, x / length, 1), np.where(flat, y / length, 0)], -1)


def per_yarn(rows: Rows, values: list[float], loose: float) -> Floats:
    """Return (n, W) of the value of each texel's yarn, and `loose` in gaps and on loose hairs.

    `rows` has `yarn_id`, whose ids count from 1, and `opacity`, which is 255 on yarn.
    """
    table = np.array([loose, *values], np.float32)
    ids = np.where(rows["opacity"][..., 0] == 255, rows["yarn_id"][..., 0], 0)
    return table[ids]


def codes_of(shares: Floats) -> Bytes:
    """Return numbers of 0…1 as codes of 8 bits, clipped."""
    codes: Bytes = np.rint(np.clip(shares, 0, 1) * np.float32(255)).astype(np.uint8)
    return codes


def _open(path: Path, stack: ExitStack) -> Any:
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    source = oiio.ImageInput.open(str(path), config) if path.is_file() else None
    if source is None:
        raise InputError(f"{path}: not a readable image: {' '.join(oiio.geterror().split())}")
    stack.callback(source.close)
    return source


def _read(source: Any, path: Path, first: int, last: int) -> NDArray[Any]:
    spec = source.spec()
    kind = oiio.FLOAT if spec.format == oiio.HALF else spec.format
    pixels = source.read_scanlines(first, last, 0, 0, spec.nchannels, kind)
    if pixels is None:
        raise InputError(f"{path}: broken image: {' '.join(source.geterror().split())}")
    rows: NDArray[Any] = np.asarray(pixels).reshape(last - first, spec.width, spec.nchannels)
    return rows
