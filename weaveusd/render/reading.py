"""Values of attributes, whatever a stage may have authored there."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Tf, Usd

if TYPE_CHECKING:
    from numpy.typing import NDArray


class UnreadableError(Exception):
    """A prim cannot be shown as it is authored; the text says what is wrong, for a loss."""


def authored(attribute: Usd.Attribute, time: Usd.TimeCode) -> Any:
    """Return the value at `time`, None without one.

    Raises
    ------
    UnreadableError
        When USD itself cannot read it.
    """
    if not attribute:
        return None
    try:
        return attribute.Get(time)
    except (Tf.ErrorException, RuntimeError):
        raise UnreadableError(f"{attribute.GetName()} cannot be read") from None


def rows(attribute: Usd.Attribute, time: Usd.TimeCode, width: int) -> NDArray[np.float64]:
    """Return an array of vectors as (n, width); empty without a value.

    Raises
    ------
    UnreadableError
        When it holds something else, or a number that is not finite.
    """
    return as_rows(authored(attribute, time), width, attribute.GetName())


def as_rows(value: Any, width: int, name: str) -> NDArray[np.float64]:
    """Return `value` as (n, width); raises UnreadableError as `rows` does."""
    array = np.asarray(() if value is None else value)
    if array.size == 0:
        return np.zeros((0, width))
    if width == 1 and array.ndim == 1:
        array = array[:, None]
    if array.dtype.kind not in "fiu" or array.ndim != 2 or array.shape[1] != width:
        raise UnreadableError(f"{name} is {_kind(array)}, expected {_vectors(width)}")
    array = array.astype(np.float64)
    if not np.isfinite(array).all():
        raise UnreadableError(f"{name} holds a value that is no finite number")
    return array


def integers(attribute: Usd.Attribute, time: Usd.TimeCode) -> NDArray[np.int64]:
    """Return an array of integers, (n,); raises UnreadableError for anything else."""
    array = np.asarray(() if (value := authored(attribute, time)) is None else value)
    if array.size == 0:
        return np.zeros(0, np.int64)
    if array.dtype.kind not in "iu" or array.ndim != 1:
        raise UnreadableError(f"{attribute.GetName()} is {_kind(array)}, expected integers")
    return array.astype(np.int64)


def number(attribute: Usd.Attribute, time: Usd.TimeCode, fallback: float) -> float:
    """Return a number, `fallback` without a value.

    Raises
    ------
    UnreadableError
        When it is no number, or not finite.
    """
    value = authored(attribute, time)
    if value is None:
        return fallback
    if not isinstance(value, (int, float)) or not math.isfinite(value):
        raise UnreadableError(
            f"{attribute.GetName()} is {str(value)[:40]!r}, expected a finite number"
        )
    return float(value)


def token(attribute: Usd.Attribute, time: Usd.TimeCode, fallback: str) -> str:
    """Return a token, `fallback` where there is none."""
    value = authored(attribute, time)
    return value if isinstance(value, str) and value else fallback


def _kind(array: NDArray[Any]) -> str:
    if array.dtype.kind not in "fiu":
        return "no array of numbers"
    return _vectors(array.shape[1]) if array.ndim == 2 else "an array of numbers"


def _vectors(width: int) -> str:
    return "numbers" if width == 1 else f"vectors of {width} numbers"
