"""Counting faulty texels of textures that are read in bands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from weaveusd.contract import TEXTURE_DIR
from weaveusd.validate.model import Finding
from weaveusd.validate.registry import Code

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Mask = NDArray[np.bool_]


def any_component(faulty: Mask) -> Mask:
    """Return (rows, width): where any component of `faulty`, (rows, width, c), holds."""
    return np.asarray(faulty.any(axis=-1))


@dataclass(slots=True)
class Tally:
    """How many texels are at fault, and the first of them."""

    count: int = 0
    column: int = 0
    row: int = 0
    example: str = ""

    def add(
        self,
        first: int,
        faulty: Mask,
        values: NDArray[Any],
        table: NDArray[np.float32] | None = None,
    ) -> None:
        """Count the texels where `faulty`, (rows, width), holds.

        `first` is the image row of row 0; `values`, (rows, width) or (rows, width, c), are
        quoted for the first of all faulty texels, or what `table` says that they stand for.
        """
        found = int(np.count_nonzero(faulty))
        if found and not self.count:
            row, column = divmod(int(np.argmax(faulty)), faulty.shape[1])
            self.row, self.column = first + row, column
            stored = np.atleast_1d(values[row, column])
            numbers = (stored if table is None else table[stored]).astype(float)
            self.example = ", ".join(f"{number:.4g}" for number in numbers)
        self.count += found

    def report(self, code: Code, file: str, law: str) -> list[Finding]:
        """Return a finding that `law` is broken in `file`, or nothing when it is not."""
        if not self.count:
            return []
        texels = "texel is" if self.count == 1 else "texels are"
        message = (
            f"{self.count} {texels} {law}; the first at column {self.column}, "
            f"row {self.row} from the top, is ({self.example})"
        )
        return [code(message, f"{TEXTURE_DIR}/{file}")]
