"""Hypothesis strategies: drafts of every kind that a Draft can hold."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from weaveusd.draft.model import LENGTH_LIMITS_MM, Draft

_LOW, _HIGH = LENGTH_LIMITS_MM
_LENGTHS = st.one_of(
    st.floats(_LOW, _HIGH),
    st.sampled_from([0.185, 0.213, 1.058418, 2.12, 0.5]),
)


@st.composite
def matrices(draw: st.DrawFn, rows: int, columns: int) -> np.ndarray:
    """Any (rows, columns) bool."""
    bits = draw(st.binary(min_size=rows * columns, max_size=rows * columns))
    return (np.frombuffer(bits, np.uint8) & 1).astype(bool).reshape(rows, columns)


@st.composite
def drawdowns(draw: st.DrawFn, most: int = 12) -> np.ndarray:
    """Any (picks, ends) bool, neither empty."""
    picks, ends = draw(st.integers(1, most)), draw(st.integers(1, most))
    return draw(matrices(picks, ends))


@st.composite
def palettes(draw: st.DrawFn) -> np.ndarray:
    """Colors of 8 bits, of the ranges that programs write, and any others in 0…1."""
    size = draw(st.integers(1, 5))
    high = draw(st.sampled_from([255, 999, 1180, 65535, 0]))
    part = st.integers(0, high).map(lambda n: n / high) if high else st.floats(0.0, 1.0)
    return np.array(draw(st.lists(part, min_size=3 * size, max_size=3 * size))).reshape(size, 3)


@st.composite
def lengths(draw: st.DrawFn, count: int) -> np.ndarray | None:
    """A length in mm for each thread, the same for all, or none."""
    kind = draw(st.sampled_from(["none", "one", "each"]))
    if kind == "none":
        return None
    if kind == "one":
        return np.full(count, draw(_LENGTHS))
    return np.array(draw(st.lists(_LENGTHS, min_size=count, max_size=count)))


@st.composite
def drafts(draw: st.DrawFn, most: int = 8) -> Draft:
    """Any draft of few threads: ends on several shafts or none, idle shafts and picks."""
    ends, picks, shafts = (draw(st.integers(1, most)) for _ in range(3))
    palette = draw(palettes())
    entry = st.integers(0, len(palette) - 1)
    return Draft(
        threading=draw(matrices(ends, shafts)),
        liftplan=draw(matrices(picks, shafts)),
        warp_color=np.array(draw(st.lists(entry, min_size=ends, max_size=ends))),
        weft_color=np.array(draw(st.lists(entry, min_size=picks, max_size=picks))),
        palette=palette,
        warp_pitch_mm=draw(lengths(ends)),
        weft_pitch_mm=draw(lengths(picks)),
        warp_thickness_mm=draw(lengths(ends)),
        weft_thickness_mm=draw(lengths(picks)),
        title=draw(st.text(max_size=30)),
        notes=draw(st.text(max_size=60)),
    )
