"""A jacquard from an image: dark is warp on top, the bottom row is the first pick."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from tests.draft.wif_text import rows
from tests.strategies import drafts, drawdowns
from weaveusd.draft.bitmap import from_bitmap
from weaveusd.draft.model import Draft
from weaveusd.draft.picture import cloth_colors
from weaveusd.errors import DraftError

BLACK, WHITE = 0, 255


def test_the_bottom_row_is_the_first_pick_and_black_is_warp_on_top() -> None:
    image = np.array([[WHITE, WHITE, BLACK], [BLACK, WHITE, WHITE]], np.uint8)
    assert rows(from_bitmap(image)) == ["#..", "..#"]


@given(drawdowns())
@settings(deadline=None)
def test_any_drawdown_comes_back_from_its_image(up: np.ndarray) -> None:
    image = np.where(up[::-1], BLACK, WHITE).astype(np.uint8)
    draft = from_bitmap(image)
    np.testing.assert_array_equal(draft.drawdown(), up)
    assert draft.shafts == len({column.tobytes() for column in up.T})
    assert not draft.warnings


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_the_number_of_channels_and_the_type_do_not_matter(channels: int, dtype: type) -> None:
    flat = np.array([[0, 1], [1, 0]]) * (255 if dtype is np.uint8 else 1)
    image = np.repeat(flat[:, :, None], channels, axis=2).astype(dtype)
    assert rows(from_bitmap(image)) == [".#", "#."]


def test_gray_pixels_are_cut_at_half_with_a_warning() -> None:
    draft = from_bitmap(np.array([[0, 100], [200, 255]], np.uint8))
    assert rows(draft) == ["..", "##"]
    assert "2 of 4 pixels are neither black nor white" in str(draft.warnings[0])


@given(drafts())
@settings(deadline=None)
def test_threads_take_the_colors_that_show_in_a_picture_of_their_cloth(draft: Draft) -> None:
    up = draft.drawdown()
    seen = cloth_colors(draft)
    image = np.where(up[::-1], BLACK, WHITE).astype(np.uint8)
    made = from_bitmap(image, seen[::-1])
    np.testing.assert_array_equal(cloth_colors(made), seen)
    assert not made.warnings


def test_crossings_in_a_color_that_no_thread_there_has_are_counted() -> None:
    colors = np.zeros((3, 3, 3), np.uint8)
    colors[1, 1] = 255
    draft = from_bitmap(np.zeros((3, 3), np.uint8), colors)
    assert "1 of 9 crossings show another color" in str(draft.warnings[0])


def test_images_that_are_no_drawdown_are_refused() -> None:
    with pytest.raises(DraftError, match=r"a\.png: found 4 × 0 pixels; expected 1 to"):
        from_bitmap(np.zeros((0, 4), np.uint8), name="a.png")
    with pytest.raises(DraftError, match="found a color image of 3 × 2 pixels; expected 2 × 2"):
        from_bitmap(np.zeros((2, 2), np.uint8), np.zeros((2, 3, 3), np.uint8))
    many = np.arange(300, dtype=np.uint16).view(np.uint8).reshape(1, 300, 2)
    many = np.concatenate([many, many[:, :, :1]], axis=2)
    with pytest.raises(DraftError, match="found 300 colors; expected at most 255 flat ones"):
        from_bitmap(np.zeros((1, 300), np.uint8), many)
    huge = np.broadcast_to(np.uint8(0), (2**14, 2**13))
    with pytest.raises(DraftError, match="found 8192 × 16384 pixels"):
        from_bitmap(huge)


@pytest.mark.parametrize(
    ("image", "message"),
    [(np.zeros(4, np.uint8), "H, W"), (np.zeros((2, 2), np.int64), "uint8 or float")],
)
def test_an_array_of_another_kind_is_a_slip_of_the_programmer(
    image: np.ndarray, message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        from_bitmap(image)


def test_a_gray_color_image_is_a_slip_of_the_programmer() -> None:
    with pytest.raises(ValueError, match="H, W, 3"):
        from_bitmap(np.zeros((2, 2), np.uint8), np.zeros((2, 2), np.uint8))
