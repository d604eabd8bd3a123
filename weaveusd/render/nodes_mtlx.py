"""Pattern nodes of MaterialX as fields.

A direction is in tangent space here: x along the surface's tangent, z its normal. A node that
gives one in MaterialX's world is read only on the way to a surface's normal or tangent.
"""

from __future__ import annotations

from collections.abc import Callable

from pxr import UsdShade

from weaveusd.errors import StageError
from weaveusd.render.fields import Field, Sampling
from weaveusd.render.network import Network, Reader
from weaveusd.render.nodes import source_of
from weaveusd.render.nodes_usd import load, primvar, wrap_of

WIDTHS = {
    "float": 1, "integer": 1, "boolean": 1, "vector2": 2,
    "color3": 3, "vector3": 3, "color4": 4, "vector4": 4,
}  # fmt: skip
"""Components of the types of MaterialX."""

DEFAULT_ST = "st"
"""The primvar that USD gives to MaterialX as its first texture coordinates, UV0."""

_VARIANTS = ("", "FA", "I", "B")
"""Endings of the nodes whose second value is a float, or that compare integers or booleans."""

_SWIZZLE = {"r": 0, "g": 1, "b": 2, "a": 3, "x": 0, "y": 1, "z": 2, "w": 3}

# Inputs in the order of the operation's arguments, each with the number it has by default.
_OPERATIONS: dict[str, tuple[str, tuple[tuple[str, float], ...]]] = {
    "add": ("add", (("in1", 0), ("in2", 0))),
    "subtract": ("subtract", (("in1", 0), ("in2", 0))),
    "multiply": ("multiply", (("in1", 0), ("in2", 1))),
    "divide": ("divide", (("in1", 0), ("in2", 1))),
    "modulo": ("modulo", (("in1", 0), ("in2", 1))),
    "power": ("power", (("in1", 0), ("in2", 1))),
    "min": ("min", (("in1", 0), ("in2", 0))),
    "max": ("max", (("in1", 0), ("in2", 0))),
    "mix": ("mix", (("fg", 0), ("bg", 0), ("mix", 0))),
    "invert": ("invert", (("in", 0), ("amount", 1))),
    "clamp": ("clamp", (("in", 0), ("low", 0), ("high", 1))),
    "smoothstep": ("smoothstep", (("in", 0), ("low", 0), ("high", 1))),
    "remap": ("remap", (("in", 0), ("inlow", 0), ("inhigh", 1), ("outlow", 0), ("outhigh", 1))),
    "absval": ("absval", (("in", 0),)),
    "floor": ("floor", (("in", 0),)),
    "ceil": ("ceil", (("in", 0),)),
    "sqrt": ("sqrt", (("in", 0),)),
    "sin": ("sin", (("in", 0),)),
    "cos": ("cos", (("in", 0),)),
    "luminance": ("luminance", (("in", 0),)),
    "normalize": ("normalize", (("in", 0),)),
    "crossproduct": ("cross", (("in1", 0), ("in2", 0))),
}

_COMPARISONS = {
    "ifgreater": "if_greater", "ifgreatereq": "if_greater_equal", "ifequal": "if_equal",
}  # fmt: skip


def readers() -> dict[str, Reader]:
    """Return the readers of all nodes that are carried, by `info:id`."""
    found: dict[str, Reader] = {
        "ND_place2d_vector2": place2d,
        "ND_rotate2d_vector2": _rotate2d,
        "ND_rotate3d_vector3": _rotate3d,
        "ND_dotproduct_vector2": _dot(2),
        "ND_dotproduct_vector3": _dot(3),
        "ND_texcoord_vector2": _texcoord,
        "ND_geomcolor_color3": _geomcolor,
        "ND_normal_vector3": _axis(0, 0, 1),
        "ND_tangent_vector3": _axis(1, 0, 0),
        "ND_bitangent_vector3": _axis(0, 1, 0),
        "ND_combine2_vector2": _combine((1, 1)),
        "ND_combine2_color4CF": _combine((3, 1)),
        "ND_combine2_vector4VF": _combine((3, 1)),
        "ND_combine2_vector4VV": _combine((2, 2)),
        "ND_combine3_color3": _combine((1, 1, 1)),
        "ND_combine3_vector3": _combine((1, 1, 1)),
        "ND_combine4_color4": _combine((1, 1, 1, 1)),
        "ND_combine4_vector4": _combine((1, 1, 1, 1)),
    }
    for suffix in ("", "_float", "_vector2"):
        found[f"ND_normalmap{suffix}"] = normalmap
    for kind, width in WIDTHS.items():
        for name, read in _typed(kind, width).items():
            found |= {f"ND_{name}_{kind}{variant}": read for variant in _VARIANTS}
        found[f"ND_mix_{kind}_{kind}"] = found[f"ND_mix_{kind}"]
        for source, source_width in WIDTHS.items():
            found[f"ND_convert_{source}_{kind}"] = _convert(source_width, width)
            found[f"ND_swizzle_{source}_{kind}"] = _swizzle(source_width, width)
    return found


def _typed(kind: str, width: int) -> dict[str, Reader]:
    """Return the readers of the nodes that exist for each type, by category."""
    found: dict[str, Reader] = {
        "constant": _single("value", width),
        "dot": _single("in", width),
        "image": _image(kind, width, tiled=False),
        "tiledimage": _image(kind, width, tiled=True),
        "geompropvalue": _geompropvalue(width),
        "extract": _extract(width),
        "switch": _switch(width),
        "ramplr": _ramp(width, "valuel", "valuer", 0),
        "ramptb": _ramp(width, "valueb", "valuet", 1),
    }
    for category, (operation, ports) in _OPERATIONS.items():
        found[category] = _operation(operation, ports, width)
    for category, operation in _COMPARISONS.items():
        found[category] = _comparison(operation, width)
    found[f"separate{width}"] = _separate(width)
    return found


def place2d(net: Network, node: UsdShade.Shader, output: str) -> Field:
    """Return texture coordinates placed about a pivot: divided by scale, turned, less offset."""
    apply = net.fields.apply
    pivot, offset = net.input(node, "pivot", (0, 0)), net.input(node, "offset", (0, 0))
    scale = net.input(node, "scale", (1, 1))
    clockwise = apply("multiply", net.input(node, "rotate", (0,)), net.fields.constant(-1))
    st = apply("subtract", net.input(node, "texcoord", _st(net)), pivot)
    if net.number(node, "operationorder", 0) == 0:
        st = apply("rotate2", apply("divide", st, scale), clockwise)
        st = apply("subtract", st, offset)
    else:
        st = apply("rotate2", apply("subtract", st, offset), clockwise)
        st = apply("divide", st, scale)
    return apply("add", st, pivot)


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


def _st(net: Network) -> Field:
    return net.fields.primvar(DEFAULT_ST, net.fields.constant(0, 0))


def _needs_frame(net: Network, node: UsdShade.Shader) -> None:
    if not net.directional:
        raise StageError("direction in the world is carried as normal or tangent only")
    net.framed = True


def _axis(x: float, y: float, z: float) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        _needs_frame(net, node)
        return net.fields.constant(x, y, z)

    return read


def _single(name: str, width: int) -> Reader:
    return lambda net, node, output: net.input(node, name, (0.0,) * width)


def _operation(operation: str, ports: tuple[tuple[str, float], ...], width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        return net.fields.apply(
            operation, *(net.input(node, name, (number,) * width) for name, number in ports)
        )

    return read


def _comparison(operation: str, width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        values = (net.input(node, "value1", (1,)), net.input(node, "value2", (0,)))
        branches = (net.input(node, name, (0,) * width) for name in ("in1", "in2"))
        return net.fields.apply(operation, *values, *branches)

    return read


def _dot(width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        return net.fields.apply(
            "dot", net.input(node, "in1", (0,) * width), net.input(node, "in2", (0,) * width)
        )

    return read


def _rotate2d(net: Network, node: UsdShade.Shader, output: str) -> Field:
    clockwise = net.fields.apply(
        "multiply", net.input(node, "amount", (0,)), net.fields.constant(-1)
    )
    return net.fields.apply("rotate2", net.input(node, "in", (0, 0)), clockwise)


def _rotate3d(net: Network, node: UsdShade.Shader, output: str) -> Field:
    return net.fields.apply(
        "rotate3",
        net.input(node, "in", (0, 0, 0)),
        net.input(node, "amount", (0,)),
        net.input(node, "axis", (0, 1, 0)),
    )


def _texcoord(net: Network, node: UsdShade.Shader, output: str) -> Field:
    index = int(net.number(node, "index", 0))
    if index != 0:
        raise StageError(f"texture coordinates {index}, expected 0, which USD names st")
    return _st(net)


def _geomcolor(net: Network, node: UsdShade.Shader, output: str) -> Field:
    return primvar(net, "displayColor", net.fields.constant(0, 0, 0))


def _geompropvalue(width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        name = net.text(node, "geomprop", "")
        if not name:
            raise StageError("geompropvalue names no primvar")
        if width == 4:
            net.losses.approximated(node.GetPrim(), f"fourth component of primvar {name} is 1")
        return primvar(net, name, net.input(node, "default", (0,) * width))

    return read


def _combine(widths: tuple[int, ...]) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        return net.fields.join(
            *(net.input(node, f"in{k + 1}", (0,) * width) for k, width in enumerate(widths))
        )

    return read


def _separate(width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        index = _SWIZZLE.get(output.removeprefix("out"), 4)
        if index >= width:
            raise StageError(f"separate{width} has no output {output}")
        return net.fields.pick(net.input(node, "in", (0,) * width), index)

    return read


def _extract(width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        index = int(net.number(node, "index", 0))
        if not 0 <= index < width:
            raise StageError(f"extract asks for component {index} of {width}")
        return net.fields.pick(net.input(node, "in", (0,) * width), index)

    return read


def _convert(source: int, width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        return net.fields.resized(net.input(node, "in", (0,) * source), width)

    return read


def _swizzle(source: int, width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        given, channels = net.input(node, "in", (0,) * source), net.text(node, "channels", "")
        parts = []
        for letter in channels[:width]:
            if letter in "01":
                parts.append(net.fields.constant(float(letter)))
            elif _SWIZZLE.get(letter, 4) < source:
                parts.append(net.fields.pick(given, _SWIZZLE[letter]))
            else:
                raise StageError(f"swizzle asks for channel {letter!r} of {source}")
        if len(parts) != width:
            raise StageError(f"swizzle names {len(parts)} channels, expected {width}")
        return net.fields.join(*parts)

    return read


def _switch(width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        which = int(net.number(node, "which", 0))
        if not 0 <= which < 10:
            raise StageError(f"switch asks for input {which + 1} of 10")
        return net.input(node, f"in{which + 1}", (0,) * width)

    return read


def _ramp(width: int, low: str, high: str, axis: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        fields = net.fields
        along = fields.pick(net.input(node, "texcoord", _st(net)), axis)
        share = fields.apply("clamp", along, fields.constant(0), fields.constant(1))
        ends = (net.input(node, name, (0,) * width) for name in (high, low))
        return fields.apply("mix", *ends, share)

    return read


def _image(kind: str, width: int, *, tiled: bool) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        fields, st = net.fields, net.input(node, "texcoord", _st(net))
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
        smooth = net.text(node, "filtertype", "linear")
        if net.text(node, "framerange", ""):
            net.losses.dropped(node.GetPrim(), "framerange of an image: one file is shown")
        sampling = Sampling(
            raster, (modes[0], modes[1]), (border[0], border[1], border[2], border[3]),
            smooth != "closest",
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
