"""UsdPreviewSurface, in USD's own nodes or through MaterialX, as a `Surface`."""

from __future__ import annotations

from pxr import UsdShade

from weaveusd.render.fields import Field
from weaveusd.render.network import Network
from weaveusd.render.shader_inputs import note_lost, reflectance
from weaveusd.render.surface import Surface

SHADER_IDS = ("UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader")

_TRANSPARENT, _PRESENCE = "transparent", "presence"


def read(net: Network, shader: UsdShade.Shader) -> Surface:
    """Return the surface: a metal or a dielectric by `metallic`, or F0 from `specularColor`.

    F90 is white, but that of a metal its color. GGX's α is roughness².
    """
    fields, apply = net.fields, net.fields.apply
    note_lost(net, shader, {"displacement": (0.0,), "occlusion": (1.0,)})
    one, white = fields.constant(1), fields.constant(1, 1, 1)
    base = net.input(shader, "diffuseColor", (0.18, 0.18, 0.18))
    ior = net.input(shader, "ior", (1.5,))
    if ior.numbers is not None and ior.numbers[0] < 1:
        net.losses.approximated(shader.GetPrim(), "ior below 1 is taken as 1")
    from_ior = reflectance(net, ior)
    f0, metal = fields.resized(from_ior, 3), net.input(shader, "metallic", (0,))
    if net.number(shader, "useSpecularWorkflow", 0) != 0:
        f0, metal = net.input(shader, "specularColor", (0, 0, 0)), fields.constant(0)
    roughness = net.input(shader, "roughness", (0.5,))
    alpha = apply("multiply", roughness, roughness)
    coat_roughness = net.input(shader, "clearcoatRoughness", (0.01,))
    opacity = _opacity(net, shader)
    return Surface(
        base_color=base,
        metalness=metal,
        metal_f90=base,
        f0=f0,
        f90=white,
        alpha=fields.join(alpha, alpha),
        coat=net.input(shader, "clearcoat", (0,)),
        coat_f0=from_ior,
        coat_alpha=apply("multiply", coat_roughness, coat_roughness),
        coat_color=white,
        opacity=opacity,
        emission=net.input(shader, "emissiveColor", (0, 0, 0)),
        transmission=fields.constant(0),
        transmission_color=white,
        ior=1.5,
        thin_walled=True,
        normal=net.direction(shader, "normal", in_world=False),
        clear_base=opacity is not one and _mode(net, shader) == _TRANSPARENT,
    )


def _mode(net: Network, shader: UsdShade.Shader) -> str:
    """Return how opacity works; with a threshold every point is there or is not."""
    if net.number(shader, "opacityThreshold", 0) > 0:
        return _PRESENCE
    return net.text(shader, "opacityMode", _TRANSPARENT)


def _opacity(net: Network, shader: UsdShade.Shader) -> Field:
    opacity = net.input(shader, "opacity", (1,))
    threshold = net.number(shader, "opacityThreshold", 0)
    if threshold > 0:
        return net.fields.apply("at_least", opacity, net.fields.constant(threshold))
    return opacity
