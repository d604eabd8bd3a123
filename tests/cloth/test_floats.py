"""Floats are cyclic runs, found once and completely."""

from __future__ import annotations

import hypothesis.strategies as st
import numpy as np
from hypothesis import given

from weaveusd.cloth.floats import cyclic_runs, longest_float

grids = st.tuples(st.integers(1, 7), st.integers(1, 9)).flatmap(
    lambda size: st.lists(
        st.lists(st.booleans(), min_size=size[1], max_size=size[1]),
        min_size=size[0],
        max_size=size[0],
    )
)


@given(grids)
def test_every_crossing_belongs_to_the_one_run_that_covers_it(rows):
    on_top = np.array(rows)
    thread, start, count, at = cyclic_runs(on_top)
    covered = np.full(on_top.shape, -1)
    for run, (k, first, n) in enumerate(zip(thread, start, count, strict=True)):
        places = (first + np.arange(n)) % on_top.shape[1]
        assert (covered[k, places] == -1).all()
        covered[k, places] = run
    np.testing.assert_array_equal(covered, at)
    np.testing.assert_array_equal(at >= 0, on_top)


@given(grids)
def test_runs_are_maximal(rows):
    on_top = np.array(rows)
    thread, start, count, _ = cyclic_runs(on_top)
    for k, first, n in zip(thread, start, count, strict=True):
        if n < on_top.shape[1]:
            assert not on_top[k, first - 1]
            assert not on_top[k, (first + n) % on_top.shape[1]]


@given(grids, st.integers(0, 8))
def test_rolling_the_crossings_rolls_the_runs(rows, shift):
    on_top = np.array(rows)
    rolled = np.roll(on_top, shift, axis=1)
    assert sorted(cyclic_runs(on_top)[2]) == sorted(cyclic_runs(rolled)[2])


def test_a_run_wraps_around_the_border():
    thread, start, count, at = cyclic_runs(np.array([[True, False, False, True, True]]))
    assert (thread.tolist(), start.tolist(), count.tolist()) == ([0], [3], [3])
    assert at.tolist() == [[0, -1, -1, 0, 0]]


def test_a_thread_on_top_everywhere_is_one_closed_float():
    thread, start, count, _ = cyclic_runs(np.ones((2, 3), bool))
    assert (thread.tolist(), start.tolist(), count.tolist()) == ([0, 1], [0, 0], [3, 3])


def test_the_longest_float_of_a_five_end_satin_is_four():
    warp_up = np.array([[(2 * r - c) % 5 != 0 for c in range(5)] for r in range(5)])
    assert longest_float(warp_up) == 4
    assert longest_float(~warp_up) == 4
