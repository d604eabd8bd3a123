"""Pictures show the draft as weavers draw it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.strategies import drafts
from weaveusd.draft.make import make_draft
from weaveusd.draft.model import Draft
from weaveusd.draft.picture import cloth_colors, draft_picture, draft_text
from weaveusd.draft.resolve import from_drawdown
from weaveusd.errors import DraftError

INK, PAPER = [20, 20, 20], [255, 255, 255]


@given(drafts())
@settings(deadline=None)
def test_the_drawdown_stands_below_with_the_first_pick_lowest(draft: Draft) -> None:
    picture = draft_picture(draft, 1)
    below = picture[-draft.picks :, : draft.ends]
    np.testing.assert_array_equal(below[::-1], cloth_colors(draft))


def test_the_fields_of_a_twill_are_where_weavers_look_for_them() -> None:
    picture = draft_picture(make_draft("twill:2/2@ff0000,0000ff"), 1)
    assert picture.shape == (4 + 3 + 4, 4 + 3 + 4, 3)
    # Shaft 1 is the lowest row of the threading, and holds end 1.
    assert picture[3, 0].tolist() == INK
    assert picture[0, 3].tolist() == INK
    assert picture[0, 0].tolist() == PAPER
    # The first treadle lifts shafts 1 and 2 and is pressed on the lowest row.
    assert [picture[row, 7].tolist() == INK for row in range(4)] == [False, False, True, True]
    assert picture[10, 7].tolist() == INK
    assert picture[5, 0].tolist() == [255, 0, 0]
    assert picture[7, 5].tolist() == [0, 0, 255]


def test_a_liftplan_is_drawn_where_there_are_too_many_treadles() -> None:
    up = np.random.default_rng(2).random((70, 70)) < 0.5
    draft = from_drawdown(up, np.zeros(70, int), np.zeros(70, int), np.zeros((1, 3)))
    picture = draft_picture(draft, 1)
    assert picture.shape == (70 + 3 + draft.shafts, 70 + 3 + draft.shafts, 3)
    lifted = (picture[-70:, 73:] == INK).all(axis=2)
    np.testing.assert_array_equal(lifted[::-1], draft.liftplan)


def test_cells_have_lines_from_four_pixels_on() -> None:
    draft = make_draft("plain")
    small, large = draft_picture(draft, 3), draft_picture(draft, 8)
    assert small.shape == (7 * 3, 7 * 3, 3)
    assert large[-8 * 2, 1].tolist() == [205] * 3
    np.testing.assert_array_equal(large[1::8, 1::8], draft_picture(draft, 1))


def test_a_picture_beyond_the_limit_is_refused() -> None:
    with pytest.raises(DraftError, match="a picture of 700000 × 700000 pixels"):
        draft_picture(make_draft("plain"), 100_000)
    with pytest.raises(ValueError, match="at least one pixel"):
        draft_picture(make_draft("plain"), 0)


def test_the_text_shows_two_rows_a_line_and_never_more_than_its_width() -> None:
    draft = make_draft("herringbone:2/2:8")
    lines = draft_text(draft, 40).splitlines()
    assert len(lines) == (4 + 3 + 4 + 1) // 2
    narrow = draft_text(draft, 10).splitlines()
    assert narrow[-1] == "the first 10 of 16 ends, 4 of 4 picks"
    for line in narrow[:-1]:
        assert len(re.sub(r"\x1b\[[0-9;]*m", "", line)) == 10


def test_the_text_of_a_hostile_title_holds_none_of_it() -> None:
    draft = replace(make_draft("plain"), title="\x1b]0;evil\x07", notes="\x1b[2J")
    assert "evil" not in draft_text(draft)
    assert "\x1b[2J" not in draft_text(draft)
