"""Shading networks as fields: inputs followed to their values and nodes, each read once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pxr import Usd, UsdShade

from weaveusd.errors import StageError
from weaveusd.render import color
from weaveusd.render.fields import Field, Fields, walk
from weaveusd.render.model import Losses
from weaveusd.render.nodes import shader_id, source_of
from weaveusd.render.rasters import Rasters

MAX_DEPTH = 48
"""Longest chain of nodes."""

MAX_NODES = 512
"""Nodes of one network: each is computed wherever a ray meets the surface."""

MAX_SIZE = 1e8
"""Numbers beyond are taken for a slip: their products would leave what a float can hold."""

_AXES = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))

Reader = Callable[["Network", UsdShade.Shader, str], Field]
"""Returns the field of a node's output; raises StageError where it cannot."""


@dataclass(slots=True)
class Network:
    """The network of one material.

    `readers` holds a reader for each `info:id`. What cannot be read becomes a loss at its prim
    and its reader's fallback.
    """

    time: Usd.TimeCode
    losses: Losses
    fields: Fields
    rasters: Rasters
    readers: Mapping[str, Reader]
    directional: bool = False  # what is read is the surface's normal or tangent
    framed: bool = False  # some node gave a direction in the surface's frame
    _read: dict[str, Field | None] = field(default_factory=dict)
    _open: set[str] = field(default_factory=set)

    def input(self, node: UsdShade.Shader, name: str, fallback: Sequence[float] | Field) -> Field:
        """Return an input as a field of the fallback's width."""
        default = fallback if isinstance(fallback, Field) else self.fields.constant(*fallback)
        try:
            source = source_of(node.GetInput(name))
            if source is None:
                return default
            if source.node is not None:
                found = self.output(source.node, source.output)
            else:
                found = self._constant(source.attribute)
        except StageError as error:
            self._lost(node, error)
            return default
        return default if found is None else self.fields.resized(found, default.width)

    def direction(self, node: UsdShade.Shader, name: str, *, in_world: bool = True) -> Field | None:
        """Return an input that is a direction, in tangent space; None for the surface's own.

        `in_world` tells that the shader takes it in the world, as MaterialX does: then only nodes
        that give directions in the surface's frame are exact.
        """
        if not self.connected(node, name):
            if self.value(node, name, None) not in (None, *_AXES):
                self.losses.dropped(node.GetPrim(), f"constant {name}")
            return None
        was, self.directional = self.directional, True
        found = self.input(node, name, (0, 0, 0))
        self.directional = was
        if found.numbers == (0.0, 0.0, 0.0):
            return None
        if any(f.kind == "primvar" and f.width == len(_AXES[0]) for f in walk(found)):
            self.losses.dropped(node.GetPrim(), f"{name} from a primvar")
            return None
        if in_world and not self.framed:
            self.losses.approximated(node.GetPrim(), f"{name} is taken to be in tangent space")
        return found

    def output(self, node: UsdShade.Shader, output: str) -> Field | None:
        """Return the field of a node's output, None where it is not understood.

        Raises
        ------
        StageError
            When the nodes feed each other in a circle, or the chain is too long.
        """
        key = f"{node.GetPath()}.{output} {self.directional}"
        if key in self._open:
            raise StageError(f"{node.GetPath()} feeds itself")
        if len(self._open) >= MAX_DEPTH:
            raise StageError(f"{node.GetPath()}: more than {MAX_DEPTH} nodes feed each other")
        if key not in self._read:
            if len(self._read) >= MAX_NODES:
                raise StageError(f"network has more than {MAX_NODES} nodes")
            self._open.add(key)
            try:
                self._read[key] = self._node(node, output)
            finally:
                self._open.discard(key)
        return self._read[key]

    def _node(self, node: UsdShade.Shader, output: str) -> Field | None:
        identifier = shader_id(node)
        reader = self.readers.get(identifier)
        if reader is None:
            self.losses.dropped(node.GetPrim(), f"node {identifier or 'without id'}")
            return None
        try:
            return reader(self, node, output)
        except StageError as error:
            self._lost(node, error)
            return None

    def value(self, node: UsdShade.Shader, name: str, fallback: Any) -> Any:
        """Return the value of an input that no node feeds, as USD has it."""
        try:
            source = source_of(node.GetInput(name))
        except StageError as error:
            self._lost(node, error)
            return fallback
        if source is None:
            return fallback
        if source.node is not None:
            self.losses.dropped(node.GetPrim(), f"node {source.node.GetPath()} feeding {name}")
            return fallback
        found = source.attribute.Get(self.time)
        return fallback if found is None else found

    def text(self, node: UsdShade.Shader, name: str, fallback: str) -> str:
        """Return a token or string."""
        return str(self.value(node, name, fallback))

    def number(self, node: UsdShade.Shader, name: str, fallback: float) -> float:
        """Return a number that Mitsuba takes as a constant only; what varies is a loss."""
        found = self.input(node, name, (fallback,))
        if found.numbers is None:
            self.losses.approximated(node.GetPrim(), f"varying {name} is taken as {fallback:g}")
            return fallback
        return found.numbers[0]

    def connected(self, node: UsdShade.Shader, name: str) -> bool:
        """Return whether a node feeds an input."""
        try:
            source = source_of(node.GetInput(name))
        except StageError:
            return False
        return source is not None and source.node is not None

    def _lost(self, node: UsdShade.Shader, error: StageError) -> None:
        """Report an error at the node, whose path its words need not repeat."""
        self.losses.dropped(node.GetPrim(), str(error).replace(f"{node.GetPath()}.", ""))

    def _constant(self, attribute: Usd.Attribute) -> Field | None:
        """Return a value as a constant, a color in linear Rec.709; None where there is none."""
        value = attribute.Get(self.time)
        if value is None:
            return None
        try:
            numbers = np.asarray(value, np.float64).reshape(-1)
        except (TypeError, ValueError):
            numbers = np.zeros(0)
        if not 1 <= numbers.size <= 4:
            kind = attribute.GetTypeName()
            raise StageError(f"{attribute.GetPath()} is a {kind}, expected one to four numbers")
        if not (np.abs(numbers) <= MAX_SIZE).all():
            raise StageError(f"{attribute.GetPath()} is {value}, expected finite numbers")
        if attribute.GetRoleName() == "Color" and numbers.size >= 3:
            numbers[:3] = self._rec709(attribute, numbers[:3])
        return self.fields.constant(*numbers.tolist())

    def _rec709(self, attribute: Usd.Attribute, numbers: Any) -> Any:
        space = str(Usd.ColorSpaceAPI.ComputeColorSpaceName(attribute, None))
        if not color.known(space):
            self.losses.approximated(
                attribute.GetPrim(), f"color space {space!r} of {attribute.GetName()} is unknown"
            )
            return numbers
        return color.linear(numbers.astype(np.float32), space)
