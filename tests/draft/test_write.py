"""What is written is read back the same, and says nothing that is private or of the day."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.strategies import drafts
from weaveusd.draft.make import make_draft
from weaveusd.draft.model import Draft
from weaveusd.draft.resolve import from_drawdown
from weaveusd.draft.wif import parse_wif
from weaveusd.draft.write import write_wif
from weaveusd.errors import DraftError


@given(drafts())
@settings(max_examples=100, deadline=None)
def test_a_draft_written_and_read_is_the_same_draft(draft: Draft) -> None:
    data = write_wif(draft)
    again = parse_wif(data, "again.wif")
    assert again == draft
    assert hash(again) == hash(draft)
    np.testing.assert_array_equal(again.threading, draft.threading)
    np.testing.assert_array_equal(again.liftplan, draft.liftplan)
    assert write_wif(again) == data
    assert all("on no shaft" in str(w) for w in again.warnings)


def test_tie_up_and_treadling_are_written_where_they_fit_and_a_liftplan_where_not() -> None:
    small = write_wif(make_draft("twill:16/16"))
    large = write_wif(make_draft("twill:17/16"))
    assert b"[TIEUP]" in small
    assert b"[LIFTPLAN]" not in small
    assert b"[LIFTPLAN]" in large
    assert b"[TREADLING]" not in large


def test_the_usual_ranges_of_color_are_preferred() -> None:
    draft = make_draft("plain")
    for high in (255, 999, 65535):
        palette = np.array([[1 / high, 0.0, 1.0], [0.0, 1.0, 0.0]])
        assert f"Range=0,{high}\n".encode() in write_wif(replace(draft, palette=palette))


def test_any_color_of_a_double_comes_back_exactly() -> None:
    palette = np.array([[0.1, 1 / 3, 1e-300], [np.pi / 4, 5e-324, 1.0]])
    draft = replace(make_draft("plain"), palette=palette)
    np.testing.assert_array_equal(parse_wif(write_wif(draft), "x").palette, palette)


def test_a_pitch_that_elsewhere_is_a_placeholder_is_kept() -> None:
    draft = replace(
        make_draft("plain"),
        warp_pitch_mm=np.full(2, 0.185),
        warp_thickness_mm=np.full(2, 0.213),
    )
    assert parse_wif(write_wif(draft), "x") == draft


def test_no_date_and_no_personal_field_is_written() -> None:
    text = write_wif(make_draft("tartan:K4 R8")).decode().lower()
    for key in ("date", "developers", "author", "address", "email", "telephone", "fax", "@"):
        assert key not in text


def test_a_draft_too_large_for_a_wif_is_refused() -> None:
    up = np.random.default_rng(1).random((2500, 2500)) < 0.5
    threads = np.zeros(2500, np.int32)
    draft = from_drawdown(up, threads, threads, np.zeros((1, 3)))
    with pytest.raises(DraftError, match=r"2500 ends, 2500 picks .* expected at most 8388608"):
        write_wif(draft)
