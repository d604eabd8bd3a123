"""A jacquard draft from an image: dark is warp on top."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.draft.defaults import default_palette
from weaveusd.draft.loom import MAX_CELLS
from weaveusd.draft.model import DraftWarning
from weaveusd.draft.resolve import from_drawdown
from weaveusd.errors import DraftError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.draft.model import Bools, Doubles, Draft, Indices

MAX_COLORS = 255
"""Flat colors in a color image: more is a photograph."""

_REC709 = np.array([0.2126, 0.7152, 0.0722])


def from_bitmap(
    image: NDArray[Any],
    colors: NDArray[Any] | None = None,
    *,
    title: str = "",
    name: str = "bitmap",
) -> Draft:
    """Return the draft whose drawdown is a black-and-white image, one pixel a crossing.

    Parameters
    ----------
    image
        (H, W) or (H, W, C), top row first, uint8 in 0…255 or float in 0…1. A dark pixel is
        warp on top; the bottom row is the first pick, the left column the first end. Of three
        channels the luma counts; a fourth is not looked at.
    colors
        (H, W, 3) of the same size: the color wanted at each crossing. Each end takes the color
        that most of its crossings on top ask for, each pick likewise.
    title
        Title of the draft.
    name
        Stands for the image in messages.

    Raises
    ------
    DraftError
        When the image is empty or larger than 2**26 pixels, or the color image has another
        size or more than `MAX_COLORS` colors.
    ValueError
        When an array has another shape or type than those above.
    """
    gray = _gray(_checked(image, name))
    up = np.ascontiguousarray(gray[::-1] < 0.5)
    warnings = []
    between = int(((gray > 0.1) & (gray < 0.9)).sum())
    if between:
        warnings.append(
            DraftWarning(
                0, f"{between} of {gray.size} pixels are neither black nor white; cut at half"
            )
        )
    if colors is None:
        warp, weft = np.zeros(up.shape[1], np.int32), np.ones(up.shape[0], np.int32)
        palette = default_palette()
    else:
        if colors.shape[:2] != image.shape[:2]:
            found = " × ".join(map(str, colors.shape[1::-1]))
            raise DraftError(
                f"{name}: found a color image of {found} pixels; expected {up.shape[1]} × "
                f"{up.shape[0]}, the size of the drawdown"
            )
        warp, weft, palette, other = _thread_colors(up, _checked(colors, name), name)
        if other:
            warnings.append(
                DraftWarning(
                    0, f"{other} of {up.size} crossings show another color than the image: a "
                    "thread has one color",
                )
            )  # fmt: skip
    return from_drawdown(up, warp, weft, palette, title=title, warnings=tuple(warnings))


def _checked(image: NDArray[Any], name: str) -> NDArray[Any]:
    """Return the image in 0…1, (H, W, C)."""
    if image.ndim not in (2, 3):
        raise ValueError("an image is (H, W) or (H, W, C)")
    if image.dtype != np.uint8 and not np.issubdtype(image.dtype, np.floating):
        raise ValueError("an image is uint8 or float")
    if not 0 < image.shape[0] * image.shape[1] <= MAX_CELLS:
        size = f"{image.shape[1]} × {image.shape[0]}"
        raise DraftError(f"{name}: found {size} pixels; expected 1 to {MAX_CELLS}")
    return image if image.ndim == 3 else image[:, :, None]


def _gray(image: NDArray[Any]) -> NDArray[np.float32]:
    """Return the luma (H, W) in 0…1 of one to four channels."""
    scale = 255.0 if image.dtype == np.uint8 else 1.0
    gray = np.zeros(image.shape[:2], dtype=np.float32)
    weights = _REC709 if image.shape[2] >= 3 else np.ones(1)
    for channel, weight in enumerate(weights):
        gray += np.float32(weight / scale) * image[:, :, channel].astype(np.float32)
    return gray


def _thread_colors(
    up: Bools, image: NDArray[Any], name: str
) -> tuple[Indices, Indices, Doubles, int]:
    """Return warp and weft colors, the palette, and how many crossings show another color."""
    if image.shape[2] < 3:
        raise ValueError("a color image is (H, W, 3) or (H, W, 4)")
    rgb = image[::-1, :, :3]
    if rgb.dtype != np.uint8:
        rgb = np.rint(np.clip(rgb, 0.0, 1.0) * 255).astype(np.uint8)
    packed = rgb.astype(np.int32) @ np.array([65536, 256, 1], dtype=np.int32)
    values = np.unique(packed)
    if values.size > MAX_COLORS:
        raise DraftError(
            f"{name}: found {values.size} colors; expected at most {MAX_COLORS} flat ones"
        )
    index = np.empty(packed.shape, dtype=np.uint8)
    for row, wanted in enumerate(packed):
        index[row] = np.searchsorted(values, wanted)
    warp = _most_wanted(index.T, up.T)
    weft = _most_wanted(index, ~up)
    other = int((np.where(up, warp[None, :], weft[:, None]) != index).sum())
    palette = (values[:, None] >> np.array([16, 8, 0]) & 255) / 255
    return warp, weft, palette, other


def _most_wanted(index: NDArray[np.uint8], on_top: Bools) -> Indices:
    """Return for each row of `index` the value that occurs most where the row is on top.

    A row that is nowhere on top takes its most frequent value; of equals the lowest counts.
    """
    winners = np.empty(index.shape[0], dtype=np.int32)
    for thread, (wanted, seen) in enumerate(zip(index, on_top, strict=True)):
        votes = np.bincount(wanted[seen] if seen.any() else wanted)
        winners[thread] = votes.argmax()
    return winners
