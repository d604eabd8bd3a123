"""UsdUVTexture, UsdTransform2d and UsdPrimvarReader as fields."""

from __future__ import annotations

from pxr import UsdShade

from weaveusd.errors import StageError
from weaveusd.render import color
from weaveusd.render.fields import Field, Sampling
from weaveusd.render.network import Network, Reader
from weaveusd.render.nodes import source_of
from weaveusd.render.rasters import Raster

CHANNELS: dict[str, tuple[int, ...]] = {
    "r": (0,), "g": (1,), "b": (2,), "a": (3,), "rgb": (0, 1, 2), "rgba": (0, 1, 2, 3),
}  # fmt: skip
WRAPS = {
    "repeat": "repeat", "periodic": "repeat", "mirror": "mirror", "clamp": "clamp",
    "black": "border", "constant": "border",
}  # fmt: skip

_READERS = {
    "float": 1, "float2": 2, "float3": 3, "int": 1, "point": 3, "vector": 3, "normal": 3,
}  # fmt: skip
_MTLX_READERS = {"float": 1, "vector2": 2, "vector3": 3, "integer": 1, "boolean": 1}


def readers() -> dict[str, Reader]:
    """Return the readers by `info:id`, those of the nodes' MaterialX twins too."""
    found: dict[str, Reader] = {
        "UsdUVTexture": texture,
        "ND_UsdUVTexture": _mtlx_texture,
        "ND_UsdUVTexture_23": _mtlx_texture,
        "UsdTransform2d": transform,
        "ND_UsdTransform2d": transform,
        "UsdPrimvarReader_float4": primvar_reader(4),
        "ND_UsdPrimvarReader_vector4": primvar_reader(4),
    }
    found |= {f"UsdPrimvarReader_{kind}": primvar_reader(width) for kind, width in _READERS.items()}
    found |= {
        f"ND_UsdPrimvarReader_{k}": primvar_reader(width) for k, width in _MTLX_READERS.items()
    }
    return found


def texture(net: Network, node: UsdShade.Shader, output: str) -> Field:
    """Return an output of a UsdUVTexture: texel · scale + bias, or its fallback."""
    if not net.connected(node, "st") and net.value(node, "st", None) is None:
        net.losses.dropped(node.GetPrim(), "texture follows no primvar: its coordinates are 0")
    return _texture(net, node, output, net.fields.constant(0, 0), "useMetadata")


def transform(net: Network, node: UsdShade.Shader, output: str) -> Field:
    """Return a UsdTransform2d: scaled, turned counter-clockwise in degrees, then shifted."""
    apply = net.fields.apply
    st = apply("multiply", net.input(node, "in", (0, 0)), net.input(node, "scale", (1, 1)))
    turned = apply("rotate2", st, net.input(node, "rotation", (0,)))
    return apply("add", turned, net.input(node, "translation", (0, 0)))


def load(net: Network, node: UsdShade.Shader, name: str, space: str) -> Raster:
    """Return the image that the input `name` of a node names.

    Raises
    ------
    StageError
        When a node feeds the input, or the image cannot be read.
    """
    source = source_of(node.GetInput(name))
    if source is None or source.node is not None:
        raise StageError(f"inputs:{name}: names no file")
    return net.rasters.load(source.attribute, net.time, space)


def wrap_of(net: Network, node: UsdShade.Shader, name: str, mode: str, instead: str) -> str:
    """Return a wrap mode of `Sampling`; an unknown one is a loss and `instead`."""
    if mode in WRAPS:
        return WRAPS[mode]
    net.losses.approximated(node.GetPrim(), f"unknown {name} {mode!r} is shown as {instead}")
    return instead


def primvar_reader(width: int, named: str = "varname", instead: str = "fallback") -> Reader:
    """Return the reader of a node whose inputs name a primvar and what stands in for it."""

    def read(net: Network, node: UsdShade.Shader, output: str) -> Field:
        name = net.text(node, named, "")
        if not name:
            raise StageError(f"inputs:{named} names no primvar")
        if width == 4:
            net.losses.approximated(node.GetPrim(), f"fourth component of primvar {name} is 1")
        return primvar(net, name, net.input(node, instead, (0.0,) * width))

    return read


def primvar(net: Network, name: str, fallback: Field) -> Field:
    """Return a primvar of the surface; a fourth component is 1."""
    fields = net.fields
    if fallback.width < 4:
        return fields.primvar(name, fallback)
    seen = fields.primvar(name, fields.resized(fallback, 3))
    return fields.join(seen, fields.constant(1.0))


def _mtlx_texture(net: Network, node: UsdShade.Shader, output: str) -> Field:
    st = net.fields.primvar("st", net.fields.constant(0, 0))
    return _texture(net, node, "rgba" if output == "out" else output, st, "periodic")


def _texture(
    net: Network, node: UsdShade.Shader, output: str, default_st: Field, default_wrap: str
) -> Field:
    if output not in CHANNELS:
        raise StageError(f"UsdUVTexture has no output {output}")
    fields = net.fields
    space = net.text(node, "sourceColorSpace", "auto")
    if space != "auto" and not color.known(space):
        net.losses.approximated(node.GetPrim(), f"unknown color space {space!r} is taken as auto")
        space = "auto"
    try:
        raster = load(net, node, "file", space)
    except StageError as error:
        net.losses.dropped(node.GetPrim(), f"{error}: the texture's fallback is shown")
        texel = net.input(node, "fallback", (0, 0, 0, 1))
    else:
        wrap = tuple(
            wrap_of(net, node, name, mode if mode != "useMetadata" else stated or "black", "repeat")
            for name, stated in zip(("wrapS", "wrapT"), raster.wrap, strict=True)
            for mode in (net.text(node, name, default_wrap),)
        )
        sampling = Sampling(raster, (wrap[0], wrap[1]))
        texel = fields.picture(sampling, net.input(node, "st", default_st))
        texel = fields.apply("multiply", texel, net.input(node, "scale", (1, 1, 1, 1)))
        texel = fields.apply("add", texel, net.input(node, "bias", (0, 0, 0, 0)))
    return fields.pick(texel, *CHANNELS[output])
