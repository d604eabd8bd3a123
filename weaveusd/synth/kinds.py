"""Kinds of yarn: those of one system that scatter alike, as far as moment maps tell them apart."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import TYPE_CHECKING

import numpy as np

from weaveusd.contract import MAX_KINDS

if TYPE_CHECKING:
    from weaveusd.cloth.model import Weave
    from weaveusd.yarn.model import Optics


@dataclass(frozen=True, slots=True)
class Kinds:
    """The kinds of a system's yarns, by the first yarn of each: indices into `Weave.yarns`."""

    yarns: tuple[int, ...]  # in the order of the yarns
    optics: tuple[Optics, ...]  # of those yarns
    of_yarn: tuple[int, ...]  # the kind of every yarn of the weave; -1 of the other system


def kinds_of(weave: Weave, *, weft: bool) -> Kinds:
    """Return the kinds of warp or weft, at most `MAX_KINDS`.

    Yarns of the same optics are of one kind. Where there are more kinds, those that are on top at
    most crossings stand for themselves, the earlier yarn first where they are alike in that; each
    other counts as the nearest of them, by the sum of the squared differences of the optics'
    numbers, angles in radians.
    """
    threads = weave.weft_yarn if weft else weave.warp_yarn
    on_top = (~weave.warp_up).sum(1) if weft else weave.warp_up.sum(0)
    crossings = np.bincount(threads, weights=on_top, minlength=len(weave.yarns))
    shown: dict[Optics, float] = {}
    first: dict[Optics, int] = {}
    for yarn in sorted(set(threads.tolist())):
        optics = weave.yarns[yarn].optics
        first.setdefault(optics, yarn)
        shown[optics] = shown.get(optics, 0.0) + float(crossings[yarn])
    most = sorted(shown, key=lambda optics: (-shown[optics], first[optics]))[:MAX_KINDS]
    kept = sorted(most, key=lambda optics: first[optics])
    system = "weft" if weft else "warp"
    of_yarn = tuple(
        _nearest(yarn.optics, kept) if yarn.system == system else -1 for yarn in weave.yarns
    )
    return Kinds(tuple(first[optics] for optics in kept), tuple(kept), of_yarn)


def _nearest(optics: Optics, kinds: list[Optics]) -> int:
    numbers = np.array([astuple(kind) for kind in kinds])
    return int(np.argmin(np.sum((numbers - astuple(optics)) ** 2, -1)))
