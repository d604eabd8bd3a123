"""Drafts turned and repeated weave the cloth turned and repeated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.strategies import drafts
from weaveusd.draft.make import make_draft
from weaveusd.draft.model import Draft
from weaveusd.draft.picture import cloth_colors
from weaveusd.draft.transform import invert, mirror, repeat, rotate
from weaveusd.errors import DraftError


def _exact(draft: Draft) -> np.ndarray:
    """The color on top of each crossing, which a turn must carry along."""
    return cloth_colors(draft)


@given(drafts())
@settings(deadline=None)
def test_a_mirror_reverses_the_columns_and_twice_it_does_nothing(draft: Draft) -> None:
    np.testing.assert_array_equal(_exact(mirror(draft)), _exact(draft)[:, ::-1])
    assert mirror(mirror(draft)) == draft


@given(drafts())
@settings(deadline=None)
def test_a_quarter_turn_transposes_and_inverts_and_four_do_nothing(draft: Draft) -> None:
    turned = rotate(draft)
    np.testing.assert_array_equal(turned.drawdown(), ~draft.drawdown()[::-1].T)
    np.testing.assert_array_equal(_exact(turned), _exact(draft)[::-1].transpose(1, 0, 2))
    assert rotate(rotate(rotate(turned))) == draft


@given(drafts())
@settings(deadline=None)
def test_inverting_exchanges_warp_and_weft_on_top_and_twice_does_nothing(draft: Draft) -> None:
    np.testing.assert_array_equal(invert(draft).drawdown(), ~draft.drawdown())
    assert invert(invert(draft)) == draft


@given(drafts(), st.integers(1, 4), st.integers(1, 4))
@settings(deadline=None)
def test_a_repeat_tiles_the_cloth(draft: Draft, across: int, along: int) -> None:
    tiled = np.tile(_exact(draft), (along, across, 1))
    np.testing.assert_array_equal(_exact(repeat(draft, across, along)), tiled)


def test_a_mirrored_z_twill_is_an_s_twill() -> None:
    up = mirror(make_draft("twill:2/2:Z")).drawdown()
    np.testing.assert_array_equal(np.roll(up, (1, -1), axis=(0, 1)), up)


def test_pitch_turns_with_its_threads() -> None:
    draft = make_draft("twill:1/2")
    draft = replace(draft, warp_pitch_mm=np.array([1.0, 2.0, 3.0]), weft_pitch_mm=np.full(3, 4.0))
    turned = rotate(draft)
    np.testing.assert_array_equal(turned.weft_pitch_mm, [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(turned.warp_pitch_mm, [4.0] * 3)
    np.testing.assert_array_equal(mirror(draft).warp_pitch_mm, [3.0, 2.0, 1.0])
    np.testing.assert_array_equal(repeat(draft, 2, 1).warp_pitch_mm, [1.0, 2.0, 3.0] * 2)


def test_a_repeat_beyond_the_limit_is_refused_before_memory_is_taken() -> None:
    with pytest.raises(DraftError, match="expected products up to"):
        repeat(make_draft("plain"), 10**6, 10**6)
    with pytest.raises(ValueError, match="at least once"):
        repeat(make_draft("plain"), 0, 1)
