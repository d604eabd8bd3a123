"""What the commands `inspect` and `draft` do: drafts from and into files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from weaveusd.draft.bitmap import from_bitmap
from weaveusd.draft.picture import MAX_PIXELS, draft_picture
from weaveusd.draft.transform import invert, mirror, repeat, rotate
from weaveusd.draft.wif import read_wif
from weaveusd.draft.write import write_wif
from weaveusd.files import write_whole

if TYPE_CHECKING:
    from weaveusd.draft.model import Draft

IMAGE_SUFFIXES = frozenset({".png", ".bmp"})
_CELL = 12


def load_draft(path: Path) -> Draft:
    """Return the draft in a WIF, or from a black-and-white image by its suffix .png or .bmp.

    Raises
    ------
    InputError
        When the file is neither.
    """
    return draft_from_image(path) if path.suffix.lower() in IMAGE_SUFFIXES else read_wif(path)


def draft_from_image(path: Path, color_path: Path | None = None) -> Draft:
    """Return the draft whose drawdown is the image, in the colors of the second if given.

    Raises
    ------
    InputError
        When an image cannot be read or suits no draft.
    """
    from weaveusd.export.images import read_image

    colors = None if color_path is None else read_image(color_path)
    return from_bitmap(read_image(path), colors, title=path.stem, name=str(path))


def transformed(
    draft: Draft,
    *,
    mirrored: bool = False,
    rotated: bool = False,
    inverted: bool = False,
    repeats: tuple[int, int] = (1, 1),
) -> Draft:
    """Return the draft mirrored, then rotated, then inverted, then repeated, as asked."""
    for asked, change in ((mirrored, mirror), (rotated, rotate), (inverted, invert)):
        if asked:
            draft = change(draft)
    return draft if repeats == (1, 1) else repeat(draft, *repeats)


def save_draft(draft: Draft, path: Path) -> None:
    """Write the draft as WIF: the whole file or, on any failure, none.

    Raises
    ------
    WeaveusdError
        When the draft is too large for a WIF or the file cannot be written.
    """
    write_whole(path, write_wif(draft))


def save_picture(draft: Draft, path: Path) -> None:
    """Write the picture of the draft as PNG, its cells as large as the limit of pixels allows.

    Raises
    ------
    WeaveusdError
        When even one pixel a cell is too much, or the file cannot be written.
    """
    from weaveusd.export.images import write_png8

    # Room for the liftplan, the widest thing that can stand beside the drawdown.
    width, height = draft.ends + draft.shafts + 67, draft.picks + draft.shafts + 3
    cell = max(1, min(_CELL, int((MAX_PIXELS / (width * height)) ** 0.5)))
    write_png8(path, draft_picture(draft, cell))
