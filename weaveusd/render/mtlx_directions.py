"""Directions of MaterialX as fields.

A direction is in tangent space here: x along the surface's tangent, z its normal. A node that
gives one in MaterialX's world is read only on the way to a surface's normal or tangent.
"""

from __future__ import annotations

from pxr import UsdShade

from weaveusd.errors import StageError
from weaveusd.render.fields import Field
from weaveusd.render.network import Network, Reader


def normalmap(net: Network, node: UsdShade.Shader, output: str) -> Field:
    """Return the direction that a map encodes as 0…1, in tangent space."""
    _needs_frame(net, node)
    for name in ("normal", "tangent", "bitangent"):
        if net.connected(node, name):
            net.losses.approximated(node.GetPrim(), f"{name} of the map is that of the surface")
    fields, apply = net.fields, net.fields.apply
    encoded = net.input(node, "in", (0.5, 0.5, 1.0))
    signed = apply("subtract", apply("multiply", encoded, fields.constant(2)), fields.constant(1))
    scale = net.input(node, "scale", (1, 1))
    scaled = apply("multiply", signed, fields.join(scale, fields.constant(1)))
    # A texel of zeros says nothing: it is flat, as MaterialX has it.
    length = apply("dot", encoded, encoded)
    flat, none = fields.constant(0, 0, 1), fields.constant(0)
    return apply("normalize", apply("if_equal", length, none, flat, scaled))


def axis(x: float, y: float, z: float) -> Reader:
    """Return the reader of a node that gives an axis of the surface's frame."""

    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        _needs_frame(net, node)
        return net.fields.constant(x, y, z)

    return read


def _needs_frame(net: Network, node: UsdShade.Shader) -> None:
    if not net.directional:
        raise StageError("direction in the world is carried as normal or tangent only")
    net.framed = True
