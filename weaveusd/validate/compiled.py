"""How the loops over texels are compiled: without Python, side by side, and kept on disk.

`_nrt=False` leaves out the counting of references to arrays, which is atomic and costs more than
the arithmetic; such functions cannot make arrays, they get them. `error_model="numpy"` lets a
division by zero give infinity instead of ending a loop. Nothing here allows other roundings than
those of IEEE 754. Numba looks for changes in the file of the outermost function only: no loop
calls a function of another file.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit


def compiled(function: Callable[..., Any]) -> Any:
    """Return `function`, one that loops, compiled for the types that it is called with."""
    return njit(cache=True, nogil=True, error_model="numpy", _nrt=False)(function)
