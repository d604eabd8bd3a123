"""What the nodes of networks compute, of Python floats and Dr.Jit arrays alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np

Components = list[Any]  # of Python floats or Dr.Jit arrays
Operation = Callable[..., Components]


def _each(function: Callable[..., Any]) -> Operation:
    """Return `function` applied to each component, single ones repeated."""

    def operation(*args: Components) -> Components:
        width = max(map(len, args))
        return [function(*(a[k if len(a) > 1 else 0] for a in args)) for k in range(width)]

    return operation


def _divide(a: Any, b: Any) -> Any:
    safe = dr.select(b == 0, 1.0, b)
    return dr.select(b == 0, 0.0, a / safe)


def _modulo(a: Any, b: Any) -> Any:
    return a - b * dr.floor(_divide(a, b))


def _power(a: Any, b: Any) -> Any:
    return dr.select(a > 0, dr.power(dr.maximum(a, 1e-30), b), dr.select(b == 0, 1.0, 0.0))


def _smoothstep(x: Any, low: Any, high: Any) -> Any:
    t = dr.clip(_divide(x - low, high - low), 0.0, 1.0)
    return dr.select(high > low, t * t * (3 - 2 * t), dr.select(x >= high, 1.0, 0.0))


def _remap(x: Any, a: Any, b: Any, c: Any, d: Any) -> Any:
    return c + _divide(x - a, b - a) * (d - c)


def _dot(a: Components, b: Components) -> Components:
    return [sum((x * y for x, y in zip(a, b, strict=False)), 0.0)]


def _cross(a: Components, b: Components) -> Components:
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def _normalize(a: Components) -> Components:
    length = dr.sqrt(_dot(a, a)[0])
    return [_divide(x, length) for x in a]


def _rotate2(a: Components, degrees: Components) -> Components:
    """Turn a vector counter-clockwise."""
    angle = degrees[0] * (np.pi / 180)
    c, s = dr.cos(angle), dr.sin(angle)
    return [c * a[0] - s * a[1], s * a[0] + c * a[1]]


def _rotate3(a: Components, degrees: Components, axis: Components) -> Components:
    """Turn a vector about an axis, clockwise seen from its tip, as MaterialX does."""
    angle = degrees[0] * (-np.pi / 180)
    c, s = dr.cos(angle), dr.sin(angle)
    axis = _normalize(axis)
    along = _dot(axis, a)[0] * (1 - c)
    across = _cross(axis, a)
    return [a[k] * c + across[k] * s + axis[k] * along for k in range(3)]


def _luminance(a: Components) -> Components:
    return _dot(a[:3], [0.2126, 0.7152, 0.0722]) * 3 + a[3:]


OPERATIONS: dict[str, Operation] = {
    "join": lambda *parts: [v for part in parts for v in part],
    "add": _each(lambda a, b: a + b),
    "subtract": _each(lambda a, b: a - b),
    "multiply": _each(lambda a, b: a * b),
    "divide": _each(_divide),
    "modulo": _each(_modulo),
    "power": _each(_power),
    "min": _each(dr.minimum),
    "max": _each(dr.maximum),
    "clamp": _each(lambda x, low, high: dr.minimum(dr.maximum(x, low), high)),
    "mix": _each(lambda fg, bg, t: bg + (fg - bg) * t),
    "invert": _each(lambda x, amount: amount - x),
    "absval": _each(dr.abs),
    "floor": _each(dr.floor),
    "ceil": _each(dr.ceil),
    "sqrt": _each(lambda x: dr.sqrt(dr.maximum(x, 0.0))),
    "sin": _each(dr.sin),
    "cos": _each(dr.cos),
    "atan2": _each(lambda y, x: dr.atan2(y, dr.select((x == 0) & (y == 0), 1.0, x))),
    "smoothstep": _each(_smoothstep),
    "remap": _each(_remap),
    "at_least": _each(lambda x, limit: dr.select(x >= limit, 1.0, 0.0)),
    "if_greater": _each(lambda a, b, yes, no: dr.select(a > b, yes, no)),
    "if_greater_equal": _each(lambda a, b, yes, no: dr.select(a >= b, yes, no)),
    "if_equal": _each(lambda a, b, yes, no: dr.select(a == b, yes, no)),
    "dot": _dot,
    "cross": _cross,
    "magnitude": lambda a: [dr.sqrt(_dot(a, a)[0])],
    "normalize": _normalize,
    "rotate2": _rotate2,
    "rotate3": _rotate3,
    "luminance": _luminance,
}
"""Operations by name; most work on each component."""
