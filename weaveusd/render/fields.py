"""Fields: what a shading network computes at a point, as a small graph of values.

A field is made by a `Fields`, which makes equal ones once, folds what is constant, and so lets
two materials with the same network share what is built from them. A field of width n has n
components; nothing here looks at an image or a mesh.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from weaveusd.errors import StageError
from weaveusd.render.operations import OPERATIONS, Components

MAX_FIELDS = 1 << 20
"""Distinct fields in one render; a network beyond is refused."""


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
