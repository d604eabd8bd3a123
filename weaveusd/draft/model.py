"""The Draft: what a weaver tells a loom, resolved and immutable."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.draft.text import one_line, tidy_lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Bools = NDArray[np.bool_]
    Indices = NDArray[np.int32]
    Doubles = NDArray[np.float64]

LENGTH_LIMITS_MM = (1e-3, 1e3)
"""Shortest and longest pitch or thickness that a draft states, in mm."""


@dataclass(frozen=True, slots=True)
class DraftWarning:
    """A decision taken on the reader's behalf: where (line 0 when nowhere) and what."""

    line: int
    message: str

    def __str__(self) -> str:
        return f"line {self.line}: {self.message}" if self.line else self.message


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A weaving draft with tie-up and sinking shed resolved into a liftplan.

    Row 0 of the liftplan is the first pick, column 0 of everything is the first shaft; thread
    and palette indices count from 0. Arrays are read-only. Lengths are in mm and are None where
    the draft does not state them. The title is one line; the notes are lines without blanks at
    their ends; neither holds control characters. `yarns` is what the file says of its yarns, a
    line each, as the proposed WIF 1.2 has it. Two drafts are equal when they weave the same cloth
    from the same threads under the same title and notes; yarns and warnings do not count.

    Raises
    ------
    ValueError
        When the shapes disagree, a color is outside the palette, or a number is outside its
        range: colors 0…1, lengths within `LENGTH_LIMITS_MM`.
    """

    threading: Bools  # (ends, shafts)
    liftplan: Bools  # (picks, shafts), True where the shaft is up
    warp_color: Indices  # (ends,) index into the palette
    weft_color: Indices  # (picks,) index into the palette
    palette: Doubles  # (P, 3) display sRGB, 0…1
    warp_pitch_mm: Doubles | None = None  # (ends,) centre to centre
    weft_pitch_mm: Doubles | None = None  # (picks,)
    warp_thickness_mm: Doubles | None = None  # (ends,)
    weft_thickness_mm: Doubles | None = None  # (picks,)
    title: str = ""
    notes: str = ""
    warnings: tuple[DraftWarning, ...] = field(default=())
    yarns: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze = object.__setattr__
        for name, kind in _ARRAYS.items():
            if (value := getattr(self, name)) is not None:
                freeze(self, name, _read_only(value, kind))
        freeze(self, "title", one_line(self.title))
        freeze(self, "notes", tidy_lines(self.notes))
        self._check()

    def _check(self) -> None:
        if self.threading.ndim != 2 or self.liftplan.ndim != 2:
            raise ValueError("threading and liftplan are matrices")
        if self.threading.shape[1] != self.liftplan.shape[1]:
            raise ValueError("threading and liftplan have different shafts")
        if not (self.ends and self.picks and self.shafts):
            raise ValueError("a draft has at least one end, one pick and one shaft")
        if self.palette.ndim != 2 or self.palette.shape[1] != 3:
            raise ValueError("the palette is (P, 3)")
        if not bool(((self.palette >= 0.0) & (self.palette <= 1.0)).all()):
            raise ValueError("palette colors lie in 0…1")
        for system, count in (("warp", self.ends), ("weft", self.picks)):
            color = getattr(self, f"{system}_color")
            if color.shape != (count,):
                raise ValueError(f"{system}_color has one entry a thread")
            if color.min() < 0 or color.max() >= len(self.palette):
                raise ValueError(f"{system}_color leaves the palette")
            for name in (f"{system}_pitch_mm", f"{system}_thickness_mm"):
                if (length := getattr(self, name)) is not None:
                    _check_lengths(name, length, count)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Draft):
            return NotImplemented
        return (
            (self.title, self.notes) == (other.title, other.notes)
            and all(
                _same(getattr(self, name), getattr(other, name))
                for name in _ARRAYS
                if name not in ("threading", "liftplan")
            )
            and np.array_equal(self.drawdown(), other.drawdown())
        )

    def __hash__(self) -> int:
        return hash((self.title, self.notes, self.ends, self.picks, drawdown_sha256(self)))

    @property
    def ends(self) -> int:
        """Number of warp threads."""
        return int(self.threading.shape[0])

    @property
    def picks(self) -> int:
        """Number of weft threads."""
        return int(self.liftplan.shape[0])

    @property
    def shafts(self) -> int:
        """Number of shafts of the loom."""
        return int(self.threading.shape[1])

    def drawdown(self) -> Bools:
        """Return the drawdown (picks, ends): True where the end is over the pick.

        An end is up on a pick when any shaft that it is threaded on is lifted; an end on no
        shaft stays down. Row 0 is the first pick.
        """
        # Picks are packed eight to a byte: an end on many shafts costs a few bytes for each.
        lifts = np.packbits(self.liftplan.T, axis=1)
        end, shaft = np.nonzero(self.threading)
        first = np.searchsorted(end, np.arange(self.ends))
        nth = np.arange(end.size) - first[end]
        packed = np.zeros((self.ends, lifts.shape[1]), dtype=np.uint8)
        for n in range(int(nth.max()) + 1 if nth.size else 0):
            some = nth == n
            packed[end[some]] |= lifts[shaft[some]]
        up = np.unpackbits(packed, axis=1, count=self.picks).T.astype(np.bool_, order="C")
        up.setflags(write=False)
        return up


def drawdown_sha256(draft: Draft) -> str:
    """Return the SHA-256, in hex, of the drawdown's bits, row after row from the first pick.

    Bits are packed eight to a byte, highest first, without padding between rows; 1 means that
    the end is on top.
    """
    return hashlib.sha256(np.packbits(draft.drawdown()).tobytes()).hexdigest()


_ARRAYS: dict[str, Any] = {
    "threading": np.bool_,
    "liftplan": np.bool_,
    "warp_color": np.int32,
    "weft_color": np.int32,
    "palette": np.float64,
    "warp_pitch_mm": np.float64,
    "weft_pitch_mm": np.float64,
    "warp_thickness_mm": np.float64,
    "weft_thickness_mm": np.float64,
}


def _read_only(value: NDArray[Any], kind: Any) -> NDArray[Any]:
    """Return `value` as a read-only C-ordered array of `kind` that nobody else can write."""
    array = np.array(value, dtype=kind, order="C", copy=not _is_frozen(value))
    array.setflags(write=False)
    return array


def _is_frozen(value: NDArray[Any]) -> bool:
    return isinstance(value, np.ndarray) and not value.flags.writeable and value.base is None


def _check_lengths(name: str, length: Doubles, count: int) -> None:
    low, high = LENGTH_LIMITS_MM
    if length.shape != (count,):
        raise ValueError(f"{name} has one entry a thread")
    if not bool(((length >= low) & (length <= high)).all()):
        raise ValueError(f"{name} lies in {low} to {high} mm")


def _same(a: NDArray[Any] | None, b: NDArray[Any] | None) -> bool:
    if a is None or b is None:
        return a is b
    return np.array_equal(a, b)
