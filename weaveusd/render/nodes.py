"""Connections of UsdShade: what feeds an input, through the boundaries of node graphs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pxr import Usd, UsdShade

from weaveusd.errors import StageError


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """What an input takes its value from: a node's output, or an attribute with a value."""

    attribute: Usd.Attribute
    node: UsdShade.Shader | None = None

    @property
    def output(self) -> str:
        """Return the name of the node's output."""
        return str(self.attribute.GetBaseName())


def source_of(given: Any) -> Source | None:
    """Return what feeds an input or output of a shader, material or node graph.

    None where nothing is there at all. Of several connections the first counts, as in USD.

    Raises
    ------
    StageError
        When a connection leads nowhere or in a circle.
    """
    attribute = given.GetAttr() if given else None
    if not attribute:
        return None
    stage = attribute.GetStage()
    seen = set()
    while True:
        if attribute.GetPath() in seen:
            raise StageError(f"{attribute.GetPath()} is connected in a circle")
        seen.add(attribute.GetPath())
        targets = attribute.GetConnections()
        if not targets:
            if UsdShade.Output.IsOutput(attribute) and len(seen) > 1:
                raise StageError(f"{attribute.GetPath()} is connected to nothing")
            return Source(attribute)
        target = stage.GetAttributeAtPath(targets[0])
        if not target:
            raise StageError(f"{attribute.GetPath()} is connected to {targets[0]}, which is not")
        attribute = target
        if UsdShade.Output.IsOutput(target) and not UsdShade.NodeGraph(target.GetPrim()):
            shader = UsdShade.Shader(target.GetPrim())
            if not shader:
                raise StageError(f"{target.GetPrim().GetPath()} feeds it and is no shader")
            return Source(target, shader)


def node_value(node: UsdShade.Shader, name: str, time: Usd.TimeCode) -> Any:
    """Return the value of an input through its connections, None if there is none or a node.

    Raises
    ------
    StageError
        When a connection leads nowhere or in a circle.
    """
    source = source_of(node.GetInput(name))
    return None if source is None or source.node is not None else source.attribute.Get(time)


def shader_id(node: UsdShade.Shader) -> str:
    """Return `info:id`, empty where a shader is told by its source."""
    return str(node.GetShaderId() or "")
