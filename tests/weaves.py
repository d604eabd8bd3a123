"""Small weaves for tests, without a file."""

from __future__ import annotations

import numpy as np

from weaveusd.cloth.model import Weave
from weaveusd.cloth.weave import weave
from weaveusd.draft.model import Draft
from weaveusd.yarn.recipe import read_preset

PALETTE = np.array([[0.8, 0.6, 0.2], [0.2, 0.3, 0.7]])


def draft_of(warp_up: np.ndarray) -> Draft:
    """A draft with one shaft an end that weaves `warp_up` (picks, ends) in two colors."""
    picks, ends = warp_up.shape
    return Draft(
        threading=np.eye(ends, dtype=bool),
        liftplan=np.ascontiguousarray(warp_up, bool),
        warp_color=np.zeros(ends, np.int32),
        weft_color=np.ones(picks, np.int32),
        palette=PALETTE,
    )


def twill(over: int = 2, under: int = 2) -> np.ndarray:
    """A right-handed twill: one end to the right a pick."""
    n = over + under
    return np.array([[(c - r) % n < over for c in range(n)] for r in range(n)])


def plain() -> np.ndarray:
    return twill(1, 1)


def satin(ends: int = 5, step: int = 2) -> np.ndarray:
    return np.array([[(step * r - c) % ends != 0 for c in range(ends)] for r in range(ends)])


def woven(warp_up: np.ndarray, preset: str = "linen") -> Weave:
    return weave(draft_of(warp_up), read_preset(preset))
