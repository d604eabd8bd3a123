"""Autodesk's standard_surface as a `Surface`."""

from __future__ import annotations

from pxr import UsdShade

from weaveusd.render.fields import Field
from weaveusd.render.network import Network
from weaveusd.render.shader_inputs import diffuse_under, note_approximated, note_lost, reflectance
from weaveusd.render.surface import Surface

SHADER_IDS = (
    "ND_standard_surface_surfaceshader",
    "ND_standard_surface_surfaceshader_100",
)

_MOST_ANISOTROPIC = 0.98


def read(net: Network, shader: UsdShade.Shader) -> Surface:
    """Return the surface of standard_surface 1.0.1.

    With r its roughness and a its anisotropy, ``α_t = r²/s`` lies along the tangent and
    ``α_b = r² s`` across it, ``s² = 1 - a``; `specular_rotation` turns the tangent about the
    normal, 1 being a full turn.
    """
    apply = net.fields.apply
    _note(net, shader)
    color = apply(
        "multiply",
        net.input(shader, "specular_color", (1, 1, 1)),
        net.input(shader, "specular", (1,)),
    )
    base = apply(
        "multiply",
        net.input(shader, "base_color", (0.8, 0.8, 0.8)),
        net.input(shader, "base", (1,)),
    )
    coat_roughness = net.input(shader, "coat_roughness", (0.1,))
    normal = net.direction(shader, "normal")
    return Surface(
        base_color=diffuse_under(net, shader, base, "subsurface", "subsurface_color"),
        metalness=net.input(shader, "metalness", (0,)),
        metal_f90=net.fields.constant(1, 1, 1),
        f0=apply("multiply", reflectance(net, net.input(shader, "specular_IOR", (1.5,))), color),
        f90=color,
        alpha=_alpha(net, shader),
        coat=net.input(shader, "coat", (0,)),
        coat_f0=reflectance(net, net.input(shader, "coat_IOR", (1.5,))),
        coat_alpha=apply("multiply", coat_roughness, coat_roughness),
        coat_color=net.input(shader, "coat_color", (1, 1, 1)),
        opacity=_opacity(net, shader),
        emission=apply(
            "multiply",
            net.input(shader, "emission_color", (1, 1, 1)),
            net.input(shader, "emission", (0,)),
        ),
        transmission=net.input(shader, "transmission", (0,)),
        transmission_color=net.input(shader, "transmission_color", (1, 1, 1)),
        ior=net.number(shader, "specular_IOR", 1.5),
        thin_walled=net.number(shader, "thin_walled", 0) != 0,
        normal=normal,
        tangent=_tangent(net, shader, normal),
    )


def _alpha(net: Network, shader: UsdShade.Shader) -> Field:
    fields, apply = net.fields, net.fields.apply
    roughness = net.input(shader, "specular_roughness", (0.2,))
    anisotropy = apply(
        "clamp",
        net.input(shader, "specular_anisotropy", (0,)),
        fields.constant(0),
        fields.constant(_MOST_ANISOTROPIC),
    )
    aspect = apply("sqrt", apply("subtract", fields.constant(1), anisotropy))
    square = apply("multiply", roughness, roughness)
    return fields.join(apply("divide", square, aspect), apply("multiply", square, aspect))


def _tangent(net: Network, shader: UsdShade.Shader, normal: Field | None) -> Field | None:
    tangent, turns = net.direction(shader, "tangent"), net.input(shader, "specular_rotation", (0,))
    if turns.numbers == (0.0,):
        return tangent
    fields = net.fields
    return fields.apply(
        "rotate3",
        tangent or fields.constant(1, 0, 0),
        fields.apply("multiply", turns, fields.constant(360)),
        normal or fields.constant(0, 0, 1),
    )


def _opacity(net: Network, shader: UsdShade.Shader) -> Field:
    opacity = net.input(shader, "opacity", (1, 1, 1))
    if opacity.numbers is not None and len(set(opacity.numbers)) > 1:
        net.losses.approximated(shader.GetPrim(), "colored opacity is shown as its luminance")
    return net.fields.pick(net.fields.apply("luminance", opacity), 0)


def _note(net: Network, shader: UsdShade.Shader) -> None:
    """Report what the layers cannot show and this surface asks for."""
    note_lost(
        net,
        shader,
        {
            "sheen": (0.0,),
            "thin_film_thickness": (0.0,),
            "transmission_scatter": (0.0, 0.0, 0.0),
            "transmission_dispersion": (0.0,),
            "transmission_extra_roughness": (0.0,),
            "coat_anisotropy": (0.0,),
            "coat_affect_color": (0.0,),
            "coat_affect_roughness": (0.0,),
        },
    )
    note_approximated(net, shader, "diffuse_roughness", (0.0,), "is 0: diffuse light is Lambert's")
    note_approximated(
        net, shader, "transmission_depth", (0.0,), "is 0: what is refracted is tinted once"
    )
    if net.input(shader, "metalness", (0,)).numbers != (0.0,):
        note_approximated(
            net, shader, "specular_color", (1.0, 1.0, 1.0), "of a metal does not tint its edge"
        )
    coated = net.input(shader, "coat", (0,)).numbers != (0.0,)
    if coated and (net.connected(shader, "coat_normal") or net.connected(shader, "normal")):
        net.losses.approximated(shader.GetPrim(), "coat follows the base's normal")
