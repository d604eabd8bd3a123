"""What a render returns, and what it had to give up on the way."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

LossKind = Literal["approximated", "dropped"]

AUTO: Literal["auto"] = "auto"
FULL: Literal["full"] = "full"
Lod = Literal["auto", "full"] | int
"""Detail of exact cloths: by what a pixel sees, all of it, or one level of it, 0 the finest."""

MAX_LEVELS = 24
"""More levels than any texture has."""


_ENOUGH_EXAMPLES = 8
"""Prims that are named for one and the same loss; more of them are counted under the first."""


@dataclass(frozen=True, slots=True)
class Loss:
    """Something of the stage that the picture does not show as the stage says it.

    `count` is the number of prims that share it, `prim` the path of the first.
    """

    prim: str
    kind: LossKind
    what: str
    count: int = 1

    def __str__(self) -> str:
        others = f", and {self.count - 1} more" if self.count > 1 else ""
        return f"{self.prim}{others}: {self.what} ({self.kind})"

    def as_dict(self) -> dict[str, str | int]:
        """Return the loss as JSON types."""
        return {"prim": self.prim, "kind": self.kind, "what": self.what, "count": self.count}


@dataclass(slots=True)
class Losses:
    """Collects losses in the order of the stage; the same one is kept once."""

    found: dict[Loss, None] = field(default_factory=dict)

    def dropped(self, prim: object, what: str) -> None:
        """Note something that the picture lacks; `prim` is a prim or a path."""
        self.found[Loss(_path(prim), "dropped", what)] = None

    def approximated(self, prim: object, what: str) -> None:
        """Note something that the picture shows differently; `prim` is a prim or a path."""
        self.found[Loss(_path(prim), "approximated", what)] = None

    def as_tuple(self) -> tuple[Loss, ...]:
        """Return the losses, first found first; what more than eight prims share is told once."""
        shared = Counter((loss.kind, loss.what) for loss in self.found)
        told: set[tuple[LossKind, str]] = set()
        losses = []
        for loss in self.found:
            key = (loss.kind, loss.what)
            if shared[key] <= _ENOUGH_EXAMPLES:
                losses.append(loss)
            elif key not in told:
                told.add(key)
                losses.append(replace(loss, count=shared[key]))
        return tuple(losses)


@dataclass(frozen=True, slots=True, eq=False)
class RenderResult:
    """A finished picture: row 0 at the top, linear Rec.709 radiance times camera exposure."""

    image: NDArray[np.float32]  # (H, W, 3)
    output: Path | None
    losses: tuple[Loss, ...]
    seconds: float
    variant: str
    width: int
    height: int
    spp: int


def _path(prim: object) -> str:
    get_path = getattr(prim, "GetPath", None)
    return str(get_path()) if get_path else str(prim)
