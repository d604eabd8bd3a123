"""A Draft is frozen, whole, and equal to what weaves the same."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from tests.strategies import drafts
from weaveusd.draft.make import make_draft
from weaveusd.draft.model import Draft, DraftWarning, drawdown_sha256


@given(drafts())
@settings(deadline=None)
def test_an_end_is_up_when_any_of_its_shafts_is(draft: Draft) -> None:
    expected = [
        [bool((draft.liftplan[r] & draft.threading[c]).any()) for c in range(draft.ends)]
        for r in range(draft.picks)
    ]
    np.testing.assert_array_equal(draft.drawdown(), expected)


def test_drafts_that_weave_the_same_on_other_shafts_are_equal() -> None:
    draft = make_draft("twill:2/2")
    other = replace(draft, threading=draft.threading[:, ::-1], liftplan=draft.liftplan[:, ::-1])
    assert other == draft
    assert hash(other) == hash(draft)
    assert len({draft, other}) == 1


@pytest.mark.parametrize(
    "change",
    [
        {"title": "other"},
        {"notes": "other"},
        {"palette": np.zeros((2, 3))},
        {"warp_color": np.ones(4)},
        {"warp_pitch_mm": np.ones(4)},
        {"liftplan": np.ones((4, 4))},
    ],
)
def test_drafts_of_other_threads_or_another_name_differ(change: dict[str, Any]) -> None:
    draft = make_draft("twill:2/2")
    assert replace(draft, **change) != draft


def test_warnings_do_not_count_and_nothing_equals_a_draft_but_a_draft() -> None:
    draft = make_draft("plain")
    assert replace(draft, warnings=(DraftWarning(3, "so"),)) == draft
    assert draft != "plain"


def test_a_draft_cannot_be_changed_nor_its_arrays_through_those_given() -> None:
    color = np.zeros(2, np.int32)
    draft = replace(make_draft("plain"), warp_color=color)
    color[0] = 1
    assert draft.warp_color.tolist() == [0, 0]
    with pytest.raises(ValueError, match="read-only"):
        draft.liftplan[0, 0] = True
    with pytest.raises(ValueError, match="read-only"):
        draft.drawdown()[0, 0] = True
    with pytest.raises(FrozenInstanceError):
        draft.title = "x"  # type: ignore[misc]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"threading": np.ones(2)}, "matrices"),
        ({"threading": np.ones((2, 3))}, "different shafts"),
        ({"liftplan": np.ones((0, 2))}, "at least one"),
        ({"palette": np.ones((2, 4))}, r"\(P, 3\)"),
        ({"palette": np.full((2, 3), np.nan)}, "0…1"),
        ({"warp_color": np.ones(3)}, "one entry a thread"),
        ({"weft_color": np.array([0, 2])}, "leaves the palette"),
        ({"warp_pitch_mm": np.ones(3)}, "one entry a thread"),
        ({"weft_thickness_mm": np.zeros(2)}, "lies in"),
        ({"warp_pitch_mm": np.array([1.0, np.nan])}, "lies in"),
    ],
)
def test_a_draft_that_contradicts_itself_is_a_slip_of_the_programmer(
    change: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        replace(make_draft("plain"), **change)


def test_the_sha256_of_a_drawdown_is_that_of_its_packed_bits() -> None:
    # Rows 10 and 01 of the plain weave pack into the one byte 1001 0000.
    import hashlib

    assert drawdown_sha256(make_draft("plain")) == hashlib.sha256(b"\x90").hexdigest()


def test_a_warning_names_its_line_where_it_has_one() -> None:
    assert str(DraftWarning(7, "odd")) == "line 7: odd"
    assert str(DraftWarning(0, "odd")) == "odd"
