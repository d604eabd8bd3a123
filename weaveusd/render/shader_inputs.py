"""What the surface shaders have in common on their way to a `Surface`."""

from __future__ import annotations

from collections.abc import Mapping

from pxr import UsdShade

from weaveusd.render.fields import Field
from weaveusd.render.network import Network


def reflectance(net: Network, ior: Field) -> Field:
    """Return the reflectance ``((1 - n) / (1 + n))²`` along the normal, 0 for n below 1."""
    fields, apply = net.fields, net.fields.apply
    one = fields.constant(1)
    bounded = apply("max", ior, one)
    root = apply("divide", apply("subtract", bounded, one), apply("add", bounded, one))
    return apply("multiply", root, root)


def diffuse_under(
    net: Network, shader: UsdShade.Shader, base: Field, weight: str, color: str
) -> Field:
    """Return the diffuse color with what is scattered below the surface mixed in, a loss."""
    share = net.input(shader, weight, (0,))
    if share.numbers == (0.0,):
        return base
    net.losses.approximated(shader.GetPrim(), f"{weight}: light leaves where it enters")
    return net.fields.apply("mix", net.input(shader, color, (1, 1, 1)), base, share)


def note_lost(
    net: Network, shader: UsdShade.Shader, neutral: Mapping[str, tuple[float, ...]]
) -> None:
    """Report every input of `neutral` as dropped that has another value, or varies."""
    for name, value in neutral.items():
        given = shader.GetInput(name)
        if given and net.input(shader, name, value).numbers != value:
            net.losses.dropped(shader.GetPrim(), name)


def note_approximated(
    net: Network, shader: UsdShade.Shader, name: str, neutral: tuple[float, ...], how: str
) -> None:
    """Report an input as approximated, in the words of `how`, where it is not neutral."""
    given = shader.GetInput(name)
    if given and net.input(shader, name, neutral).numbers != neutral:
        net.losses.approximated(shader.GetPrim(), f"{name} {how}")
