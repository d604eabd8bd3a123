"""What a render returns, and what it had to give up on the way."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

LossKind = Literal["approximated", "dropped"]


@dataclass(frozen=True, slots=True)
class Loss:
    """Something of the stage that the picture does not show as the stage says it."""

    prim: str
    kind: LossKind
    what: str

    def __str__(self) -> str:
        return f"{self.prim}: {self.what} ({self.kind})"


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
        """Return the losses, first found first."""
        return tuple(self.found)


@dataclass(frozen=True, slots=True, eq=False)
class RenderResult:
    """A finished picture: row 0 at the top, linear Rec.709 radiance, no exposure applied."""

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
