"""Threading, tie-up and treadling as strings."""

from __future__ import annotations

import pytest

from tests.draft.wif_text import TWILL_ROWS, rows
from weaveusd.draft.threaded import from_threading, parse_places
from weaveusd.errors import DraftError


@pytest.mark.parametrize(
    ("text", "places"),
    [
        ("1 2,3", [1, 2, 3]),
        ("1-4 3 2", [1, 2, 3, 4, 3, 2]),
        ("4-2", [4, 3, 2]),
        ("(1 2)*3", [1, 2] * 3),
        ("2x3 1", [2, 2, 2, 1]),
        ("((1 2)*2 3)x2", [1, 2, 1, 2, 3] * 2),
        ("1-2*2", [1, 2, 1, 2]),
        ("(3)", [3]),
        (" 0 ", [0]),
    ],
)
def test_lists_count_up_down_and_over(text: str, places: list[int]) -> None:
    assert parse_places(text, "list") == [(n,) for n in places]


def test_a_plus_joins_shafts_or_treadles() -> None:
    assert parse_places("1+3 2", "list") == [(1, 3), (2,)]


def test_a_twill_is_woven_from_three_strings() -> None:
    draft = from_threading("1-4", "1+2 2+3 3+4 4+1", "1-4", title="mine")
    assert rows(draft) == TWILL_ROWS
    assert draft.title == "mine"


def test_two_treadles_lift_the_shafts_of_both_and_none_lifts_none() -> None:
    assert rows(from_threading("1 2 3", "1 2", "1+2 0 2")) == ["##.", "...", ".#."]


def test_an_overshot_alternates_pattern_and_tabby() -> None:
    draft = from_threading("(1 2)*3 (2 3)*2 3 4 1 4", "1+2 2+3 3+4 4+1 1+3 2+4", "(1 5 1 6)*2")
    assert draft.picks == 8
    assert rows(draft)[0].startswith("######")
    assert rows(draft)[1].startswith("#.#.#.")


@pytest.mark.parametrize(
    "text",
    [
        "", "  ", "()", "(1", "1)", "a", "1-", "-1", "1+", "+", "1+2-4", "*3", "1*0", "1**2",
        "1*2*2", "(1 2)*99999999", "((((1-1024)*9)*9)*9)*9", "1-9999", "99999999999", "1*", "١",
        "1" * 70000, "1 \n;",
    ],
)  # fmt: skip
def test_what_is_no_list_is_told_on_one_line(text: str) -> None:
    with pytest.raises(DraftError, match=r"threading: found .*; expected ") as caught:
        from_threading(text, "1", "1")
    assert "\n" not in str(caught.value)


def test_a_treadle_without_tie_up_is_refused() -> None:
    with pytest.raises(DraftError, match="treadling: found treadle 3; expected at most 2"):
        from_threading("1 2", "1 2", "3")


def test_a_cloth_too_large_is_refused_before_memory_is_taken() -> None:
    with pytest.raises(DraftError, match="found 16384 ends by 16384 picks"):
        from_threading("1*16384", "1", "1*16384")
