"""How the loops over texels are compiled: without Python, and without its habits.

`_nrt=False` leaves out the counting of references to arrays: it is atomic, happens at each
access to an array of a tuple, and took four fifths of the time. Such functions cannot make
arrays; they get them. `error_model="numpy"` lets a division by zero give infinity, as the check
for it keeps loops from becoming vector instructions. Nothing here allows other roundings than
those of IEEE 754, so that every machine computes the same bits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])

_OPTIONS = {"cache": True, "nogil": True, "error_model": "numpy", "_nrt": False}


def compiled(function: F) -> F:
    """Return `function`, one that loops, compiled for the types that it is called with."""
    loop: F = njit(**_OPTIONS)(function)
    return loop


def inlined(function: F) -> F:
    """Return `function`, one that such a loop calls for every texel, to be compiled into it."""
    part: F = njit(**_OPTIONS, inline="always")(function)
    return part
