"""The OpenPBR surface as a `Surface`."""

from __future__ import annotations

from pxr import UsdShade

from weaveusd.render.fields import Field
from weaveusd.render.network import Network
from weaveusd.render.shader_inputs import diffuse_under, note_approximated, note_lost, reflectance
from weaveusd.render.surface import Surface

SHADER_IDS = ("ND_open_pbr_surface_surfaceshader",)


def read(net: Network, shader: UsdShade.Shader) -> Surface:
    """Return the surface of OpenPBR 1.1.

    With r its roughness and a its anisotropy, ``α_t = r² sqrt(2 / (1 + (1 - a)²))`` lies along
    the tangent and ``α_b = (1 - a) α_t`` across it, so a fibre's tangent is across the fibre.
    """
    fields, apply = net.fields, net.fields.apply
    _note(net, shader)
    color = net.input(shader, "specular_color", (1, 1, 1))
    base = apply(
        "multiply",
        net.input(shader, "base_color", (0.8, 0.8, 0.8)),
        net.input(shader, "base_weight", (1,)),
    )
    ior = net.input(shader, "specular_ior", (1.5,))
    weight = apply("multiply", net.input(shader, "specular_weight", (1,)), color)
    coat_roughness = net.input(shader, "coat_roughness", (0,))
    return Surface(
        base_color=diffuse_under(net, shader, base, "subsurface_weight", "subsurface_color"),
        metalness=net.input(shader, "base_metalness", (0,)),
        metal_f90=fields.constant(1, 1, 1),
        f0=apply("multiply", reflectance(net, ior), weight),
        f90=color,
        alpha=_alpha(net, shader),
        coat=net.input(shader, "coat_weight", (0,)),
        coat_f0=reflectance(net, net.input(shader, "coat_ior", (1.6,))),
        coat_alpha=apply("multiply", coat_roughness, coat_roughness),
        coat_color=net.input(shader, "coat_color", (1, 1, 1)),
        opacity=net.input(shader, "geometry_opacity", (1,)),
        emission=apply(
            "multiply",
            net.input(shader, "emission_color", (1, 1, 1)),
            net.input(shader, "emission_luminance", (0,)),
        ),
        transmission=net.input(shader, "transmission_weight", (0,)),
        transmission_color=net.input(shader, "transmission_color", (1, 1, 1)),
        ior=net.number(shader, "specular_ior", 1.5),
        thin_walled=net.number(shader, "geometry_thin_walled", 0) != 0,
        normal=net.direction(shader, "geometry_normal"),
        tangent=net.direction(shader, "geometry_tangent"),
    )


def _alpha(net: Network, shader: UsdShade.Shader) -> Field:
    fields, apply = net.fields, net.fields.apply
    one, two = fields.constant(1), fields.constant(2)
    roughness = net.input(shader, "specular_roughness", (0.3,))
    anisotropy = net.input(shader, "specular_roughness_anisotropy", (0,))
    ratio = apply("subtract", one, apply("clamp", anisotropy, fields.constant(0), one))
    stretch = apply(
        "sqrt", apply("divide", two, apply("add", one, apply("multiply", ratio, ratio)))
    )
    along = apply("multiply", apply("multiply", roughness, roughness), stretch)
    return fields.join(along, apply("multiply", along, ratio))


def _note(net: Network, shader: UsdShade.Shader) -> None:
    """Report what the layers cannot show and this surface asks for."""
    note_lost(
        net,
        shader,
        {
            "fuzz_weight": (0.0,),
            "thin_film_weight": (0.0,),
            "transmission_scatter": (0.0, 0.0, 0.0),
            "transmission_dispersion_scale": (0.0,),
            "coat_roughness_anisotropy": (0.0,),
        },
    )
    note_approximated(
        net, shader, "base_diffuse_roughness", (0.0,), "is 0: diffuse light is Lambert's"
    )
    note_approximated(
        net, shader, "transmission_depth", (0.0,), "is 0: what is refracted is tinted once"
    )
    if net.input(shader, "base_metalness", (0,)).numbers != (0.0,):
        note_approximated(
            net, shader, "specular_color", (1.0, 1.0, 1.0), "of a metal does not tint its edge"
        )
    if net.input(shader, "coat_weight", (0,)).numbers != (0.0,):
        net.losses.approximated(
            shader.GetPrim(), "coat follows the base's normal and neither darkens nor roughens it"
        )
