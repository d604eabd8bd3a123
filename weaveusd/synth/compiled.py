"""How the loops over texels are compiled: without Python, and without its habits.

`_nrt=False` leaves out the counting of references to arrays: it is atomic, happens at each
access to an array of a tuple, and took four fifths of the time. Such functions cannot make
arrays; they get them. `error_model="numpy"` lets a division by zero give infinity, as the check
for it keeps loops from becoming vector instructions. Nothing here allows other roundings than
those of IEEE 754, so that every machine computes the same bits.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache

_OPTIONS = {"nogil": True, "error_model": "numpy", "_nrt": False}

SOURCES = hashlib.sha256(
    b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
).hexdigest()
"""What the files of this package are: compiled code is kept for these and no others."""


class _Cache(FunctionCache):  # type: ignore[misc] # numba has no types
    """Numba's cache on disk, which by itself knows the file of the outermost function alone."""

    def _index_key(self, *arguments: Any) -> tuple[Any, ...]:
        return (*super()._index_key(*arguments), SOURCES)


def compiled(function: Callable[..., Any]) -> Any:
    """Return `function`, one that Python calls, compiled for its types and kept on disk."""
    dispatcher = njit(**_OPTIONS)(function)
    dispatcher._cache = _Cache(function)
    return dispatcher


def step(function: Callable[..., Any]) -> Any:
    """Return `function`, one that such a function calls, compiled with it."""
    return njit(**_OPTIONS)(function)


def inlined(function: Callable[..., Any]) -> Any:
    """Return `function`, one that a step calls for every texel, compiled into its loop."""
    return njit(**_OPTIONS, inline="always")(function)
