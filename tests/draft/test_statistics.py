"""Floats, faces and names of weaves."""

from __future__ import annotations

import json
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from tests.strategies import drafts, drawdowns
from weaveusd.draft.make import make_draft
from weaveusd.draft.model import Draft
from weaveusd.draft.resolve import from_drawdown
from weaveusd.draft.statistics import describe, float_lengths, used_colors
from weaveusd.draft.structure import smallest_repeat
from weaveusd.draft.transform import mirror, repeat, rotate


def _runs_of(row: list[bool]) -> list[tuple[bool, int]]:
    """The cyclic runs of a row, found one crossing at a time."""
    starts = [i for i in range(len(row)) if row[i] != row[i - 1]]
    if not starts:
        return [(row[0], len(row))]
    ends = [*starts[1:], starts[0] + len(row)]
    return [(row[a], b - a) for a, b in zip(starts, ends, strict=True)]


@given(drawdowns())
@settings(deadline=None)
def test_float_lengths_are_those_of_cyclic_runs(up: np.ndarray) -> None:
    runs = [run for row in up.tolist() for run in _runs_of(row)]
    over, under = float_lengths(up)
    assert sorted(over.tolist()) == sorted(n for value, n in runs if value)
    assert sorted(under.tolist()) == sorted(n for value, n in runs if not value)


@given(drafts())
@settings(deadline=None)
def test_floats_of_both_faces_cover_every_crossing_twice(draft: Draft) -> None:
    d = describe(draft)
    for system in ("warp", "weft"):
        floats = [d.face_floats[system], d.back_floats[system]]
        assert sum(n * count for f in floats for n, count in f.items()) == draft.ends * draft.picks
    face = sum(n * count for n, count in d.face_floats["warp"].items())
    assert face == round(d.warp_face * draft.ends * draft.picks)


@given(drafts())
@settings(deadline=None)
def test_a_quarter_turn_exchanges_the_floats_of_warp_and_weft(draft: Draft) -> None:
    here, there = describe(draft), describe(rotate(draft))
    assert there.face_floats["weft"] == here.face_floats["warp"]
    assert there.longest_warp_float == here.longest_weft_float
    assert there.longest_float == here.longest_float
    assert there.warp_interlacing == here.weft_interlacing


@pytest.mark.parametrize(
    ("notation", "name"),
    [
        ("plain", "plain"),
        ("twill:2/2:Z", "twill 2/2 Z 45°"),
        ("twill:2/2:S", "twill 2/2 S 45°"),
        ("twill:1/3", "twill 1/3 Z 45°"),
        ("twill:3/1/1/2:S", "twill 3/1/1/2 S 45°"),
        ("satin:5:2", "satin 5 step 2"),
        ("satin:8:5", "satin 8 step 5"),
        ("sateen:5:3", "sateen 5 step 3"),
        ("basket:2", "basket 2/2"),
        ("basket:2/3", "basket 2/3"),
        ("basket:1/2", "warp rib 2"),
        ("basket:3/1", "weft rib 3"),
        ("herringbone:2/2:8", "herringbone 2/2 over 8 ends"),
        ("houndstooth", "twill 2/2 Z 45°"),
        ("honeycomb:5", None),
    ],
)
def test_a_weave_is_named_in_any_number_of_repeats_from_any_thread_on(
    notation: str, name: str | None
) -> None:
    draft = repeat(make_draft(notation), 3, 2)
    moved = replace(
        draft,
        threading=np.roll(draft.threading, 1, axis=0),
        liftplan=np.roll(draft.liftplan, 2, axis=0),
    )
    assert describe(draft).structure == name
    assert describe(moved).structure == name


def test_the_angle_of_a_twill_is_that_of_its_steepest_line() -> None:
    row = np.array([True] * 4 + [False] * 3)
    for step, name in ((2, "Z 27°"), (4, "Z 63°"), (5, "S 27°")):
        up = np.array([np.roll(row, step * pick) for pick in range(7)])
        draft = from_drawdown(up, np.zeros(7, int), np.zeros(7, int), np.zeros((1, 3)))
        assert describe(draft).structure == f"twill 4/3 {name}"


def test_a_mirrored_satin_has_the_complementary_step() -> None:
    assert describe(mirror(make_draft("satin:5:2"))).structure == "satin 5 step 3"


@given(drawdowns(8))
@settings(deadline=None)
def test_the_smallest_repeat_tiles_the_drawdown_and_has_none_smaller(up: np.ndarray) -> None:
    picks, ends = smallest_repeat(up)
    block = up[:picks, :ends]
    np.testing.assert_array_equal(np.tile(block, (len(up) // picks, up.shape[1] // ends)), up)
    assert smallest_repeat(block) == (picks, ends)


def test_long_floats_are_warned_about_in_millimetres_where_the_pitch_is_known() -> None:
    draft = make_draft("satin:16:5")
    assert "warp float passes 15 threads" in describe(draft).warnings[0]
    fine = replace(draft, weft_pitch_mm=np.full(16, 0.4), warp_pitch_mm=np.full(16, 0.2))
    assert not describe(fine).warnings
    coarse = replace(fine, weft_pitch_mm=np.full(16, 2.0))
    assert "30.0 mm long" in describe(coarse).warnings[0]


def test_threads_that_never_interlace_are_one_float_and_warned_about() -> None:
    draft = make_draft("plain")
    loose = replace(draft, liftplan=np.array([[True, True], [False, True]]))
    d = describe(loose)
    assert d.never_interlacing == 2
    assert d.longest_float == 2
    assert any("2 threads never interlace" in w for w in d.warnings)


def test_a_description_is_json_with_the_colors_in_use() -> None:
    draft = replace(make_draft("plain@ff8000,000000"), weft_color=np.zeros(2, int))
    record = json.loads(json.dumps(describe(draft).as_dict()))
    assert record["colors"] == used_colors(draft) == ["#ff8000"]
    assert {"ends", "picks", "shafts", "drawdown_sha256", "longest_float", "warnings"} <= set(
        record
    )
    assert record["face_floats"]["warp"] == {"1": 2}


def test_the_floats_of_a_large_jacquard_are_counted_in_a_moment() -> None:
    up = np.random.default_rng(5).random((8208, 1146)) < 0.5
    start = time.perf_counter()
    warp, weft = float_lengths(up.T), float_lengths(up)
    seconds = time.perf_counter() - start
    assert sum(map(np.sum, warp)) == sum(map(np.sum, weft)) == up.size
    assert seconds < 3.0  # 0.4 s on an idle machine
