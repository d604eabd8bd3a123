"""glTF's surface, as MaterialX spells it, as a `Surface`."""

from __future__ import annotations

import math

from pxr import UsdShade

from weaveusd.render.fields import Field
from weaveusd.render.network import Network
from weaveusd.render.shader_inputs import note_lost, reflectance
from weaveusd.render.surface import Surface

SHADER_IDS = ("ND_gltf_pbr_surfaceshader",)

_OPAQUE, _MASK = 0, 1


def read(net: Network, shader: UsdShade.Shader) -> Surface:
    """Return the surface of glTF 2.0 with its extensions for highlights, coat and glass.

    GGX's α is roughness²; anisotropy s widens it to ``mix(α, 1, s²)`` along the tangent, which
    `anisotropy_rotation` turns counter-clockwise, in radians (KHR_materials_anisotropy).
    """
    fields, apply = net.fields, net.fields.apply
    _note(net, shader)
    weight = net.input(shader, "specular", (1,))
    color = net.input(shader, "specular_color", (1, 1, 1))
    from_ior = reflectance(net, net.input(shader, "ior", (1.5,)))
    f0 = apply("min", apply("multiply", color, from_ior), fields.constant(1))
    coat_roughness = net.input(shader, "clearcoat_roughness", (0,))
    white = fields.constant(1, 1, 1)
    base = net.input(shader, "base_color", (1, 1, 1))
    return Surface(
        base_color=base,
        metalness=net.input(shader, "metallic", (1,)),
        metal_f90=white,
        f0=apply("multiply", f0, weight),
        f90=fields.resized(weight, 3),
        alpha=_alpha(net, shader),
        coat=net.input(shader, "clearcoat", (0,)),
        coat_f0=reflectance(net, fields.constant(1.5)),
        coat_alpha=apply("multiply", coat_roughness, coat_roughness),
        coat_color=white,
        opacity=_opacity(net, shader),
        emission=apply(
            "multiply",
            net.input(shader, "emissive", (0, 0, 0)),
            net.input(shader, "emissive_strength", (1,)),
        ),
        transmission=net.input(shader, "transmission", (0,)),
        transmission_color=base,
        ior=net.number(shader, "ior", 1.5),
        thin_walled=net.number(shader, "thickness", 0) == 0,
        normal=net.direction(shader, "normal"),
        tangent=_tangent(net, shader),
    )


def _alpha(net: Network, shader: UsdShade.Shader) -> Field:
    fields, apply = net.fields, net.fields.apply
    roughness = net.input(shader, "roughness", (1,))
    across = apply("multiply", roughness, roughness)
    strength = net.input(shader, "anisotropy_strength", (0,))
    share = apply("multiply", strength, strength)
    return fields.join(apply("mix", fields.constant(1), across, share), across)


def _tangent(net: Network, shader: UsdShade.Shader) -> Field | None:
    fields = net.fields
    tangent = net.direction(shader, "tangent")
    angle = net.input(shader, "anisotropy_rotation", (0,))
    if angle.numbers == (0.0,):
        return tangent
    clockwise = fields.apply("multiply", angle, fields.constant(-180 / math.pi))
    start, up = tangent or fields.constant(1, 0, 0), fields.constant(0, 0, 1)
    return fields.apply("rotate3", start, clockwise, up)


def _opacity(net: Network, shader: UsdShade.Shader) -> Field:
    mode = int(net.number(shader, "alpha_mode", _OPAQUE))
    if mode == _OPAQUE:
        return net.fields.constant(1)
    alpha = net.input(shader, "alpha", (1,))
    if mode == _MASK:
        return net.fields.apply("at_least", alpha, net.input(shader, "alpha_cutoff", (0.5,)))
    return alpha


def _note(net: Network, shader: UsdShade.Shader) -> None:
    """Report what the layers cannot show and this surface asks for."""
    note_lost(
        net,
        shader,
        {
            "occlusion": (1.0,),
            "iridescence": (0.0,),
            "sheen_color": (0.0, 0.0, 0.0),
            "dispersion": (0.0,),
        },
    )
    if net.input(shader, "thickness", (0,)).numbers != (0.0,) and net.connected(
        shader, "attenuation_distance"
    ):
        net.losses.approximated(shader.GetPrim(), "attenuation by depth is not shown")
    coated = net.input(shader, "clearcoat", (0,)).numbers != (0.0,)
    if coated and (net.connected(shader, "clearcoat_normal") or net.connected(shader, "normal")):
        net.losses.approximated(shader.GetPrim(), "coat follows the base's normal")
