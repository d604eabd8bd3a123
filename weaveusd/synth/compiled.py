"""How the loops over texels are compiled: without Python, and without its habits.

`_nrt=False` leaves out the counting of references to arrays: it is atomic, happens at each
access to an array of a tuple, and took four fifths of the time. Such functions cannot make
arrays; they get them. `error_model="numpy"` lets a division by zero give infinity, as the check
for it keeps loops from becoming vector instructions. Nothing here allows other roundings than
those of IEEE 754, so that every machine computes the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit

_OPTIONS = {"nogil": True, "error_model": "numpy", "_nrt": False}


def compiled(function: Callable[..., Any]) -> Any:
    """Return `function`, one that Python calls, compiled for its types and kept on disk.

    What is kept knows the file of `function` alone, not those of the steps that it calls.
    """
    return njit(**_OPTIONS, cache=True)(function)


def step(function: Callable[..., Any]) -> Any:
    """Return `function`, one that such a function calls, compiled with it."""
    return njit(**_OPTIONS)(function)


def inlined(function: Callable[..., Any]) -> Any:
    """Return `function`, one that a step calls for every texel, compiled into its loop."""
    return njit(**_OPTIONS, inline="always")(function)
