"""Pattern nodes of MaterialX as fields."""

from __future__ import annotations

from pxr import UsdShade

from weaveusd.errors import StageError
from weaveusd.render import mtlx_directions, mtlx_images
from weaveusd.render.fields import Field
from weaveusd.render.network import Network, Reader
from weaveusd.render.nodes_usd import primvar, primvar_reader

WIDTHS = {
    "float": 1, "integer": 1, "boolean": 1, "vector2": 2,
    "color3": 3, "vector3": 3, "color4": 4, "vector4": 4,
}  # fmt: skip
"""Components of the types of MaterialX."""

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
    "atan2": ("atan2", (("iny", 0), ("inx", 1))),
    "luminance": ("luminance", (("in", 0),)),
    "magnitude": ("magnitude", (("in", 0),)),
    "normalize": ("normalize", (("in", 0),)),
}

# Operation, and the first value by default; the second is 0.
_COMPARISONS = {
    "ifgreater": ("if_greater", 1.0),
    "ifgreatereq": ("if_greater_equal", 1.0),
    "ifequal": ("if_equal", 0.0),
}


def readers() -> dict[str, Reader]:
    """Return the readers of all nodes that are carried, by `info:id`."""
    found: dict[str, Reader] = {
        "ND_place2d_vector2": mtlx_images.place2d,
        "ND_crossproduct_vector3": _operation("cross", (("in1", 0), ("in2", 0)), 3),
        "ND_rotate2d_vector2": _rotate2d,
        "ND_rotate3d_vector3": _rotate3d,
        "ND_dotproduct_vector2": _dot(2),
        "ND_dotproduct_vector3": _dot(3),
        "ND_texcoord_vector2": mtlx_images.texcoord,
        "ND_geomcolor_color3": _geomcolor,
        "ND_normal_vector3": mtlx_directions.axis(0, 0, 1),
        "ND_tangent_vector3": mtlx_directions.axis(1, 0, 0),
        "ND_bitangent_vector3": mtlx_directions.axis(0, 1, 0),
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
        found[f"ND_normalmap{suffix}"] = mtlx_directions.normalmap
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
        "image": mtlx_images.image(kind, width, tiled=False),
        "tiledimage": mtlx_images.image(kind, width, tiled=True),
        "geompropvalue": primvar_reader(width, "geomprop", "default"),
        "extract": _extract(width),
        "switch": _switch(width),
        "ramplr": mtlx_images.ramp(width, "valuel", "valuer", 0),
        "ramptb": mtlx_images.ramp(width, "valueb", "valuet", 1),
    }
    for category, (operation, ports) in _OPERATIONS.items():
        found[category] = _operation(operation, ports, width)
    for category, (operation, first) in _COMPARISONS.items():
        found[category] = _comparison(operation, first, width)
    found[f"separate{width}"] = _separate(width)
    return found


def _single(name: str, width: int) -> Reader:
    return lambda net, node, output: net.input(node, name, (0.0,) * width)


def _operation(operation: str, ports: tuple[tuple[str, float], ...], width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        return net.fields.apply(
            operation, *(net.input(node, name, (number,) * width) for name, number in ports)
        )

    return read


def _comparison(operation: str, first: float, width: int) -> Reader:
    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        values = (net.input(node, "value1", (first,)), net.input(node, "value2", (0,)))
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


def _geomcolor(net: Network, node: UsdShade.Shader, output: str) -> Field:
    return primvar(net, "displayColor", net.fields.constant(0, 0, 0))


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
