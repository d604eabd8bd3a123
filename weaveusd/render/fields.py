"""Fields: what a shading network computes at a point, as a small graph of values.

A field is made by a `Fields`, which makes equal ones once, folds what is constant, and so lets
two materials with the same network share what is built from them. A field of width n has n
components; nothing here looks at an image or a mesh.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any

import drjit as dr
import numpy as np

from weaveusd.errors import StageError

MAX_FIELDS = 4096
"""Distinct fields in one render; a network beyond is refused."""

Components = list[Any]  # of Python floats or Dr.Jit arrays
Operation = Callable[..., Components]


@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """A node of the graph; made by `Fields`, compared by identity.

    `kind` is `constant`, `primvar`, `picture` or a name in `OPERATIONS`; `detail` are a
    constant's numbers, a primvar's name, or the `Sampling` of a picture.
    """

    kind: str
    width: int
    args: tuple[Field, ...] = ()
    detail: Any = None

    @property
    def numbers(self) -> tuple[float, ...] | None:
        """Return the components of a constant, None of what varies."""
        return self.detail if self.kind == "constant" else None


@dataclass(frozen=True, slots=True)
class Sampling:
    """How an image is looked up: its raster, its wrap modes, and what lies around it.

    `wrap` is one of `repeat`, `mirror`, `clamp` and `border` for s and for t; beyond a border
    there is `border`. `smooth` interpolates between texels.
    """

    raster: Any
    wrap: tuple[str, str]
    border: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    smooth: bool = True


@dataclass(slots=True)
class Fields:
    """Makes fields, equal ones once."""

    _made: dict[Hashable, Field] = field(default_factory=dict)

    def constant(self, *numbers: float) -> Field:
        """Return a field that is the same everywhere."""
        exact = tuple(float(v) + 0.0 for v in numbers)
        return self._once(("constant", exact), Field("constant", len(exact), (), exact))

    def primvar(self, name: str, fallback: Field) -> Field:
        """Return the primvar `name` of the surface, and `fallback` on a surface without it."""
        key = ("primvar", name, id(fallback))
        return self._once(key, Field("primvar", fallback.width, (fallback,), name))

    def picture(self, sampling: Sampling, st: Field) -> Field:
        """Return the four channels of an image at texture coordinates, t upwards."""
        key = ("picture", id(sampling.raster), sampling, id(st))
        return self._once(key, Field("picture", 4, (st,), sampling))

    def apply(self, kind: str, *args: Field) -> Field:
        """Return an operation on fields; a width of 1 serves wherever another is asked for.

        Raises
        ------
        StageError
            When the network has more than `MAX_FIELDS` nodes.
        """
        if all(a.kind == "constant" for a in args):
            folded = OPERATIONS[kind](*(list(a.detail) for a in args))
            return self.constant(*(_tame(v) for v in folded))
        width = _width(kind, args)
        return self._once((kind, *(id(a) for a in args)), Field(kind, width, args))

    def pick(self, source: Field, *indices: int) -> Field:
        """Return the components `indices` of a field, in that order."""
        if source.numbers is not None:
            return self.constant(*(source.numbers[i] for i in indices))
        key = ("pick", id(source), indices)
        return self._once(key, Field("pick", len(indices), (source,), indices))

    def join(self, *parts: Field) -> Field:
        """Return the components of all parts, one after the other."""
        return self.apply("join", *parts)

    def resized(self, source: Field, width: int) -> Field:
        """Return a field of another width: one component is repeated, else 0 fills, alpha 1."""
        if source.width == width:
            return source
        if source.width == 1:
            spread = self.pick(source, *(0,) * min(width, 3))
            return self.join(spread, self.constant(1.0)) if width == 4 else spread
        if source.width > width:
            return self.pick(source, *range(width))
        rest = [0.0] * (width - source.width)
        if width == 4:
            rest[-1] = 1.0
        return self.join(source, self.constant(*rest))

    def _once(self, key: Hashable, made: Field) -> Field:
        known = self._made.get(key)
        if known is not None:
            return known
        if len(self._made) >= MAX_FIELDS:
            raise StageError(f"materials: more than {MAX_FIELDS} distinct values in networks")
        self._made[key] = made
        return made


def walk(*roots: Field | None) -> list[Field]:
    """Return every field below the roots once, sources first."""
    found: dict[int, Field] = {}
    stack = [(root, False) for root in reversed(roots) if root is not None]
    while stack:
        node, done = stack.pop()
        if done:
            found[id(node)] = node
        elif id(node) not in found:
            stack.append((node, True))
            stack += [(a, False) for a in node.args if id(a) not in found]
    return list(found.values())


def compute(root: Field, leaf: Callable[[Field, list[Components]], Components]) -> Components:
    """Return the components of `root`; `leaf` computes primvars and pictures from their args."""
    values: dict[int, Components] = {}
    for node in walk(root):
        args = [values[id(a)] for a in node.args]
        if node.kind == "constant":
            values[id(node)] = list(node.detail)
        elif node.kind in ("primvar", "picture"):
            values[id(node)] = leaf(node, args)
        elif node.kind == "pick":
            values[id(node)] = [args[0][i] for i in node.detail]
        else:
            values[id(node)] = OPERATIONS[node.kind](*args)
    return values[id(root)]


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
    "smoothstep": _each(_smoothstep),
    "remap": _each(_remap),
    "at_least": _each(lambda x, limit: dr.select(x >= limit, 1.0, 0.0)),
    "if_greater": _each(lambda a, b, yes, no: dr.select(a > b, yes, no)),
    "if_greater_equal": _each(lambda a, b, yes, no: dr.select(a >= b, yes, no)),
    "if_equal": _each(lambda a, b, yes, no: dr.select(a == b, yes, no)),
    "dot": _dot,
    "cross": _cross,
    "normalize": _normalize,
    "rotate2": _rotate2,
    "rotate3": _rotate3,
    "luminance": _luminance,
}
"""Operations by name; most work on each component."""


def _width(kind: str, args: Sequence[Field]) -> int:
    if kind == "join":
        return sum(a.width for a in args)
    if kind == "dot":
        return 1
    if kind in ("cross", "rotate3"):
        return 3
    if kind in ("rotate2",):
        return 2
    return max(a.width for a in args)


def _tame(value: Any) -> float:
    """Return a finite number: what overflowed is 0."""
    number = float(value)
    return number if np.isfinite(number) else 0.0
