"""What a surface shader asks for and the picture does not show."""

from __future__ import annotations

from collections.abc import Mapping

from pxr import UsdShade

from weaveusd.render.network import Network


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
