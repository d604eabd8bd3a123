"""Images as networks look them up: read once, linear, tiles of a UDIM set side by side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import drjit as dr
import mitsuba as mi
import numpy as np
from pxr import Sdf, Usd, UsdShade

from weaveusd.errors import StageError
from weaveusd.render import color, textures

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float32]

MAX_BYTES = 8 << 30
"""Memory for all images of one render; what would go beyond is refused."""

_ROWS = 256
_FLOAT_BYTES = 4


@dataclass(frozen=True, slots=True, eq=False)
class Raster:
    """An image in memory: `columns` by `rows` tiles, each one unit of st wide and high.

    `wrap` are the modes for s and t that the file itself states, None where it states none.
    """

    texels: Any  # tensor (H, W, channels), row 0 at t = 0
    columns: int = 1
    rows: int = 1
    wrap: textures.Wrap = (None, None)
    _textures: dict[bool, Any] = field(default_factory=dict)

    @property
    def size(self) -> tuple[int, int]:
        """Return width and height in texels."""
        return self.texels.shape[1], self.texels.shape[0]

    def prepare(self, smooth: bool) -> None:
        """Make the texture that `channels_at` looks up: none can be made while a kernel is."""
        if smooth not in self._textures:
            mode = dr.FilterMode.Linear if smooth else dr.FilterMode.Nearest
            self._textures[smooth] = mi.Texture2f(
                self.texels, use_accel=False, filter_mode=mode, wrap_mode=dr.WrapMode.Repeat
            )

    def channels_at(self, uv: Any, active: Any, smooth: bool) -> list[Any]:
        """Return red, green, blue and alpha at `uv` in 0…1: gray is repeated, alpha else 1."""
        found = list(self._textures[smooth].eval(uv, active))
        alpha = found.pop() if len(found) in (2, 4) else mi.Float(1)
        return [*(found if len(found) == 3 else found * 3), alpha]


@dataclass(slots=True)
class Rasters:
    """Reads every image of a render once for each color space that it is taken to be in."""

    _read: dict[tuple[str, str], Raster] = field(default_factory=dict)
    _bytes: int = 0

    def load(self, attribute: Usd.Attribute, time: Usd.TimeCode, space: str) -> Raster:
        """Return the image, or the UDIM set, that an asset attribute names.

        `space` is `auto` or a name that `color.known` knows. With `auto` the attribute's own
        `colorSpace` counts, and without one 8-bit color is sRGB and all else linear.

        Raises
        ------
        StageError
            When the file is missing, broken or too large; the message names the attribute.
        """
        where = str(attribute.GetName())
        asset = attribute.Get(time)
        if not isinstance(asset, Sdf.AssetPath) or not asset.path:
            raise StageError(f"{where}: names no file")
        if space == "auto" and attribute.HasColorSpace():
            space = str(attribute.GetColorSpace())
        if space != "auto" and not color.known(space):
            raise StageError(f"{where}: has the unknown color space {space!r}")
        if UsdShade.UdimUtils.IsUdimIdentifier(asset.path):
            return self._tiles(attribute, asset.path, time, space, where)
        path = textures.resolved(asset, where)
        return self._once(path, space, lambda: self._single(path, space, where))

    def _single(self, path: str, space: str, where: str) -> Raster:
        pixels, wrap = self._pixels(path, space, where)
        return Raster(_tensor(pixels), wrap=wrap)

    def _tiles(
        self, attribute: Usd.Attribute, path: str, time: Usd.TimeCode, space: str, where: str
    ) -> Raster:
        stack = attribute.GetPropertyStack(time)
        said = (s.layer for s in stack if s.HasDefaultValue() or s.HasInfo("timeSamples"))
        layer = next(said, None)
        found = UsdShade.UdimUtils.ResolveUdimTilePaths(path, layer) if layer else ()
        if not found:
            raise StageError(f"{where}: {path} is not found")
        files = {_cell(str(tile)): str(file) for file, tile in found}
        key = "\n".join(files[cell] for cell in sorted(files))
        return self._once(
            key, space,
            lambda: self._atlas({c: self._pixels(f, space, where)[0] for c, f in files.items()},
                                where),
        )  # fmt: skip

    def _atlas(self, tiles: dict[tuple[int, int], Floats], where: str) -> Raster:
        """Return one raster of all tiles; smaller ones repeat texels, missing ones are 0."""
        columns, rows = (1 + max(cell[k] for cell in tiles) for k in (0, 1))
        height, width, channels = (max(p.shape[k] for p in tiles.values()) for k in range(3))
        size = rows * height * columns * width * channels * _FLOAT_BYTES
        left = MAX_BYTES - self._bytes
        if max(rows * height, columns * width) > textures.MAX_SIDE or size > left:
            raise StageError(
                f"{where}: has {columns} x {rows} tiles of {width} x {height} texels, expected "
                f"at most {textures.MAX_SIDE} texels a side in all and {left} bytes"
            )
        self._bytes += size
        return Raster(_tensor(_joined(tiles, rows, columns)), columns, rows)

    def _once(self, key: str, space: str, read: Callable[[], Raster]) -> Raster:
        known = self._read.get((key, space))
        if known is None:
            known = self._read[key, space] = read()
        return known

    def _pixels(self, path: str, space: str, where: str) -> tuple[Floats, textures.Wrap]:
        """Return the linear pixels of one file, row 0 at t = 0, and the wrap that it states."""
        image = textures.read_image(path, where, most_bytes=MAX_BYTES - self._bytes)
        self._bytes += image.pixels.nbytes
        return _linear(image, space)[::-1], image.wrap


def _linear(image: textures.Image, space: str) -> Floats:
    if space == "auto":
        return textures.linear(image, "auto")
    pixels = image.pixels
    if pixels.shape[2] < 3:
        # A single channel has no primaries: only its curve can be undone.
        gray = np.repeat(pixels[..., :1], 3, axis=2)
        pixels[..., 0] = color.linear(gray, space)[..., 1]
        return pixels
    for first in range(0, len(pixels), _ROWS):
        band = slice(first, first + _ROWS)
        pixels[band, :, :3] = color.linear(pixels[band, :, :3], space)
    return pixels


def _cell(tile: str) -> tuple[int, int]:
    """Return column and row of a UDIM tile, 1001 being the first."""
    number = int(tile) - 1001
    return number % 10, number // 10


def _tensor(pixels: Floats) -> Any:
    return mi.TensorXf(np.ascontiguousarray(pixels, np.float32))


def _joined(tiles: dict[tuple[int, int], Floats], rows: int, columns: int) -> Floats:
    height, width, channels = (max(p.shape[k] for p in tiles.values()) for k in range(3))
    atlas = np.zeros((rows * height, columns * width, channels), np.float32)
    for (column, row), pixels in tiles.items():
        down = np.arange(height) * len(pixels) // height
        across = np.arange(width) * pixels.shape[1] // width
        part = atlas[row * height : (row + 1) * height, column * width : (column + 1) * width]
        part[..., : pixels.shape[2]] = pixels[down][:, across]
        if pixels.shape[2] < channels and channels in (2, 4):
            part[..., -1] = 1.0
    return atlas
