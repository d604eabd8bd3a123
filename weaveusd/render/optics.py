"""The optics of the yarns as one table, checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from weaveusd import contract

if TYPE_CHECKING:
    from numpy.typing import NDArray

YARN_INPUTS = tuple(contract.SHADER_YARN_INPUTS)

_LIMITS: dict[str, tuple[float, float]] = {
    "eta": (1.0, 3.0),
    "k_d": (0.0, 1.0),
    "k_s": (0.0, 1.0),
    "gamma_s": (1e-3, 6.3),
    "gamma_v": (1e-3, 6.3),
    "tau": (0.0, 1.0),
    "normalization": (0.0, 1e3),
}


def yarn_table(inputs: Mapping[str, Sequence[float]]) -> NDArray[np.float32]:
    """Return the optics as (7, yarns) float32, in the order of `contract.SHADER_YARN_INPUTS`."""
    missing = [name for name in YARN_INPUTS if name not in inputs]
    if missing:
        raise ValueError(f"{missing[0]}: is missing, expected one value for each yarn")
    columns = [np.asarray(inputs[name], np.float32).reshape(-1) for name in YARN_INPUTS]
    yarns = columns[0].size
    if not 1 <= yarns <= contract.MAX_YARNS:
        raise ValueError(f"eta: has {yarns} values, expected 1 to {contract.MAX_YARNS} yarns")
    for name, column in zip(YARN_INPUTS, columns, strict=True):
        low, high = _LIMITS[name]
        if column.size != yarns:
            raise ValueError(f"{name}: has {column.size} values, but eta has {yarns}")
        wrong = ~((column >= low) & (column <= high))
        if wrong.any():
            raise ValueError(f"{name}: is {column[wrong][0]:g}, expected {low:g} to {high:g}")
    return np.stack(columns)
