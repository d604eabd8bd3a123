"""Images, ramps and texture coordinates of MaterialX as fields."""

from __future__ import annotations

from collections.abc import Callable

from pxr import UsdShade

from weaveusd.errors import StageError
from weaveusd.render.fields import Field, Sampling
from weaveusd.render.network import Network, Reader
from weaveusd.render.nodes import source_of
from weaveusd.render.nodes_usd import load, wrap_of

DEFAULT_ST = "st"
"""The primvar that USD gives to MaterialX as its first texture coordinates, UV0."""


def coordinates(net: Network) -> Field:
    """Return the texture coordinates that a node has by default."""
    return net.fields.primvar(DEFAULT_ST, net.fields.constant(0, 0))


def place2d(net: Network, node: UsdShade.Shader, output: str) -> Field:
    """Return texture coordinates placed about a pivot: divided by scale, turned, less offset."""
    apply = net.fields.apply
    pivot, offset = net.input(node, "pivot", (0, 0)), net.input(node, "offset", (0, 0))
    scale = net.input(node, "scale", (1, 1))
    clockwise = apply("multiply", net.input(node, "rotate", (0,)), net.fields.constant(-1))
    st = apply("subtract", net.input(node, "texcoord", coordinates(net)), pivot)
    if net.number(node, "operationorder", 0) == 0:
        st = apply("rotate2", apply("divide", st, scale), clockwise)
        st = apply("subtract", st, offset)
    else:
        st = apply("rotate2", apply("subtract", st, offset), clockwise)
        st = apply("divide", st, scale)
    return apply("add", st, pivot)


def texcoord(net: Network, node: UsdShade.Shader, output: str) -> Field:
    """Return the first texture coordinates; MaterialX's others have no name in USD."""
    index = int(net.number(node, "index", 0))
    if index != 0:
        raise StageError(f"texture coordinates {index}, expected 0, which USD names st")
    return coordinates(net)


def image(kind: str, width: int, *, tiled: bool) -> Reader:
    """Return the reader of an image of MaterialX type `kind`; beyond a border is its default."""

    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        fields, st = net.fields, net.input(node, "texcoord", coordinates(net))
        if tiled:
            st = _tiled(net, node, st)
        default = net.input(node, "default", (0,) * width)
        try:
            # Only colors have a space; what states none is linear.
            raster = load(net, node, "file", _space(node) if kind.startswith("color") else "raw")
        except StageError as error:
            net.losses.dropped(node.GetPrim(), f"{error}: the image's default is shown")
            return default
        modes = ["repeat", "repeat"] if tiled else [
            wrap_of(net, node, name, net.text(node, name, "periodic"), "repeat")
            for name in ("uaddressmode", "vaddressmode")
        ]  # fmt: skip
        if "border" in modes and default.numbers is None:
            net.losses.approximated(node.GetPrim(), "varying default is 0 beyond the image")
        border = fields.resized(default, 4).numbers or (0.0, 0.0, 0.0, 0.0)
        filtering = net.text(node, "filtertype", "linear")
        if filtering not in ("linear", "closest"):
            net.losses.approximated(node.GetPrim(), f"filtertype {filtering} is shown as linear")
        if net.text(node, "framerange", ""):
            net.losses.dropped(node.GetPrim(), "framerange of an image: one file is shown")
        sampling = Sampling(
            raster, (modes[0], modes[1]), (border[0], border[1], border[2], border[3]),
            filtering != "closest",
        )  # fmt: skip
        return fields.pick(fields.picture(sampling, st), *range(width))

    return read


def _space(node: UsdShade.Shader) -> str:
    """Return the color space that the file's input states, or where it is connected to."""
    given = node.GetInput("file")
    source = source_of(given)
    for attribute in (given.GetAttr(), source.attribute) if source is not None else ():
        if attribute.HasColorSpace():
            return str(attribute.GetColorSpace())
    return "raw"


def _tiled(net: Network, node: UsdShade.Shader, st: Field) -> Field:
    """Return st · uvtiling - uvoffset, over the image's size and times the tile's."""
    apply: Callable[..., Field] = net.fields.apply
    st = apply("multiply", st, net.input(node, "uvtiling", (1, 1)))
    st = apply("subtract", st, net.input(node, "uvoffset", (0, 0)))
    st = apply("divide", st, net.input(node, "realworldimagesize", (1, 1)))
    return apply("multiply", st, net.input(node, "realworldtilesize", (1, 1)))


def ramp(width: int, low: str, high: str, axis: int) -> Reader:
    """Return the reader of a ramp between two inputs along s (axis 0) or t (axis 1)."""

    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        fields = net.fields
        along = fields.pick(net.input(node, "texcoord", coordinates(net)), axis)
        share = fields.apply("clamp", along, fields.constant(0), fields.constant(1))
        ends = (net.input(node, name, (0,) * width) for name in (high, low))
        return fields.apply("mix", *ends, share)

    return read
