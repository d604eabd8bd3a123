"""Standard weaves come out as the loom would weave them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.draft.wif_text import rows
from weaveusd.draft.make import make_draft
from weaveusd.draft.sett import parse_sett
from weaveusd.errors import DraftError


def test_a_z_twill_climbs_to_the_right_with_the_first_pick_at_the_bottom() -> None:
    up = make_draft("twill:2/2:Z").drawdown()
    np.testing.assert_array_equal(np.roll(up, (1, 1), axis=(0, 1)), up)
    # Seen with row 0 at the bottom: the last row is printed first.
    assert rows(make_draft("twill:2/2:Z"))[::-1] == ["#..#", "..##", ".##.", "##.."]


def test_an_s_twill_climbs_to_the_left_and_z_is_meant_where_nothing_is_said() -> None:
    up = make_draft("twill:3/1:S").drawdown()
    np.testing.assert_array_equal(np.roll(up, (1, -1), axis=(0, 1)), up)
    assert rows(make_draft("twill:3/1")) == rows(make_draft("TWILL : 3/1 : z"))


def test_the_numbers_of_a_twill_are_ends_up_and_down_along_a_pick() -> None:
    assert rows(make_draft("twill:3/1/1/2"))[0] == "###.#.."


def test_a_herringbone_inverts_where_it_turns_so_that_no_weft_float_crosses() -> None:
    up = make_draft("herringbone:2/2:6").drawdown()
    assert up.shape == (4, 12)
    for border in (0, 6):
        np.testing.assert_array_equal(up[:, border], ~up[:, border - 1])
    np.testing.assert_array_equal(up[1:, 1:6], up[:-1, :5])
    np.testing.assert_array_equal(up[1:, 6:11], up[:-1, 7:12])


def test_pointed_and_diamond_twills_are_symmetric_about_their_points() -> None:
    pointed = make_draft("pointed:2/2")
    assert pointed.threading.argmax(axis=1).tolist() == [0, 1, 2, 3, 2, 1]
    up = make_draft("diamond:2/2").drawdown()
    np.testing.assert_array_equal(up[:, 1:], up[:, :0:-1])
    np.testing.assert_array_equal(up[1:], up[:0:-1])


@pytest.mark.parametrize(("shafts", "step"), [(5, 2), (5, 3), (7, 2), (8, 3), (12, 5)])
def test_each_end_and_pick_of_a_satin_binds_once_and_never_beside_another(
    shafts: int, step: int
) -> None:
    down = ~make_draft(f"satin:{shafts}:{step}").drawdown()
    assert (down.sum(axis=0) == 1).all()
    assert (down.sum(axis=1) == 1).all()
    beside = np.roll(down, (1, 1), axis=(0, 1)) | np.roll(down, (1, -1), axis=(0, 1))
    assert not (down & beside).any()
    np.testing.assert_array_equal(make_draft(f"sateen:{shafts}:{step}").drawdown(), down)


def test_a_basket_is_a_plain_weave_of_groups() -> None:
    assert rows(make_draft("basket:2")) == ["##..", "##..", "..##", "..##"]
    assert rows(make_draft("basket:2/1")) == ["##..", "..##"]
    assert rows(make_draft("basket:1/2")) == ["#.", "#.", ".#", ".#"]


def test_a_honeycomb_binds_every_thread_and_floats_over_the_middle_of_its_cell() -> None:
    for shafts in (4, 5, 8):
        up = make_draft(f"honeycomb:{shafts}").drawdown()
        assert up.shape == (2 * shafts - 2,) * 2
        assert up.any(axis=0).all()
        assert up.any(axis=1).all()
        assert not up.all(axis=0).any()
        assert not up.all(axis=1).any()
        middle = shafts - 1
        assert up[:, middle].sum() == 2 * shafts - 3


def test_houndstooth_is_a_twill_in_groups_of_two_colors_both_ways() -> None:
    draft = make_draft("houndstooth@000000,ffffff")
    assert draft.warp_color.tolist() == draft.weft_color.tolist() == [0] * 4 + [1] * 4
    assert draft.palette.tolist() == [[0.0] * 3, [1.0] * 3]
    assert make_draft("houndstooth:6").ends == 12


def test_a_tartan_repeats_its_sett_until_the_twill_meets_itself() -> None:
    draft = make_draft("tartan:K4 R3")
    assert draft.ends == draft.picks == 28
    assert len(set(draft.warp_color.tolist())) == 2
    np.testing.assert_array_equal(draft.warp_color, draft.weft_color)


def test_pivots_reflect_a_sett() -> None:
    assert parse_sett("k/4 R24, DG/2") == [("K", 4), ("R", 24), ("DG", 2), ("R", 24)]
    assert parse_sett("K4 R24") == [("K", 4), ("R", 24)]


def test_colors_stand_behind_an_at_sign_for_warp_and_weft() -> None:
    draft = make_draft("plain@ff0000,0000FF")
    assert draft.palette[draft.warp_color].tolist() == [[1.0, 0.0, 0.0]] * 2
    assert draft.palette[draft.weft_color].tolist() == [[0.0, 0.0, 1.0]] * 2


@pytest.mark.parametrize(
    "notation",
    [
        "", "velvet", "plain:2", "twill", "twill:2", "twill:2/2/1", "twill:2/0", "twill:2/2:N",
        "twill:2/2:Z:9", "twill:9999/1", "twill:99999999999/1", "twill:١/١", "twill:1.5/2",
        "satin:4:2", "satin:6:3", "satin:5:1", "satin:5:4", "satin:5", "basket:1/2/3", "basket:0",
        "honeycomb:3", "herringbone:3/1", "herringbone:2/2:1", "houndstooth:0", "pointed:2/2:8",
        "tartan", "tartan:", "tartan:Q4", "tartan:K0", "tartan:K/4 R2", "tartan:K4 R/2 G4",
        "tartan:K9999", "tartan:K4@000000,ffffff", "plain@red,blue", "plain@", "plain@000000",
        "a\nb", "x" * 9999,
    ],
)  # fmt: skip
def test_a_notation_that_cannot_be_woven_is_told_on_one_line(notation: str) -> None:
    with pytest.raises(DraftError, match=r"found .*; expected ") as caught:
        make_draft(notation)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300


def test_a_waffle_is_a_honeycomb() -> None:
    assert rows(make_draft("waffle:5")) == rows(make_draft("honeycomb:5"))
