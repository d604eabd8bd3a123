"""Kinds of yarn: alike ones together, and the rarest with those that they are nearest to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.weaves import twill, woven
from weaveusd.contract import MAX_KINDS
from weaveusd.synth.kinds import kinds_of


def ends_of(*gammas: float):
    """A 2/2 twill whose ends in turn are of yarns with lobes so wide; one pick's yarn is last."""
    plain = woven(twill(), "shot_silk")
    warp, weft = plain.yarns
    ends = tuple(replace(warp, optics=replace(warp.optics, gamma_s=g)) for g in gammas)
    turn = np.arange(len(gammas), dtype=np.int32)
    return replace(
        plain,
        warp_up=np.tile(plain.warp_up, (1, len(gammas)))[:, : len(gammas)],
        yarns=(*ends, weft),
        warp_yarn=turn,
        weft_yarn=np.full(4, len(gammas), np.int32),
    )


def test_yarns_that_scatter_alike_are_one_kind_by_the_first_of_them():
    weave = ends_of(0.2, 0.1, 0.2, 0.1)
    warp, weft = kinds_of(weave, weft=False), kinds_of(weave, weft=True)
    assert warp.yarns == (0, 1)
    assert warp.of_yarn == (0, 1, 0, 1, -1)
    assert [optics.gamma_s for optics in warp.optics] == [0.2, 0.1]
    assert (weft.yarns, weft.of_yarn) == ((4,), (-1, -1, -1, -1, 0))


def test_what_shows_most_stands_for_itself_and_others_count_as_the_nearest():
    weave = ends_of(0.1, 0.52, 0.3, 0.4, 0.5, 0.21)
    shown = weave.warp_up.copy()
    shown[:, 1], shown[:, 5] = False, False
    kinds = kinds_of(replace(weave, warp_up=shown), weft=False)
    assert len(kinds.optics) == MAX_KINDS
    assert kinds.yarns == (0, 2, 3, 4)
    assert kinds.of_yarn == (0, 3, 1, 2, 3, 1, -1)


def test_of_kinds_that_show_alike_the_earlier_are_kept():
    assert kinds_of(ends_of(0.1, 0.2, 0.3, 0.4, 0.5, 0.6), weft=False).yarns == (0, 1, 2, 3)


def test_a_yarn_that_no_thread_is_of_is_no_kind():
    weave = ends_of(0.1, 0.2)
    unused = replace(weave, warp_yarn=np.array([1, 1], np.int32))
    kinds = kinds_of(unused, weft=False)
    assert (kinds.yarns, kinds.of_yarn) == ((1,), (0, 0, -1))
