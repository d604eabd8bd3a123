"""A `Surface` as what a shape needs: BSDF, emission, and the primvars that they follow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from weaveusd.contract import DEFAULT_ST
from weaveusd.render.field_texture import UV_WIDTH, color_of, texture_of
from weaveusd.render.fields import Field, Fields, walk
from weaveusd.render.layered import layered_bsdf
from weaveusd.render.surface import Surface

MIN_ETA = 1.001


@dataclass(frozen=True, slots=True)
class Look:
    """A material ready for shapes: the BSDF's dictionary, and what a shape must bring.

    `uv` names the primvar that the mesh carries as its own texture coordinates, `primvars` those
    that it carries as attributes: (name, components), see `field_texture.attribute_name`. What
    a shape lacks is taken as the network's fallback. `opaque` BSDFs have a black back until
    they are made two-sided; `pierced` ones let light pass straight through some of their points.
    """

    bsdf: dict[str, Any]
    uv: str | None = None
    emission: dict[str, Any] | None = None
    opaque: bool = True
    pierced: bool = False
    primvars: tuple[tuple[str, int], ...] = ()


def make_look(surface: Surface, fields: Fields) -> Look:
    """Return the look of a surface.

    Refraction is Mitsuba's `roughdielectric`, or `thindielectric` for thin walls, blended in by
    `transmission`. Opacity that is not 1 is a `mask`, unless the surface's base is clear.
    """
    read = _read(surface)
    uv = _main_coordinates(surface, read)
    bsdf, opaque = _bsdf(surface, fields, uv)
    masked = not surface.clear_base and surface.opacity.numbers != (1.0,)
    if masked:
        # mask refuses to lie inside twosided, so the two-sided surface lies inside the mask.
        if opaque:
            bsdf = {"type": "twosided", "bsdf": bsdf}
        opacity = fields.apply("clamp", surface.opacity, fields.constant(0), fields.constant(1))
        bsdf, opaque = {"type": "mask", "opacity": texture_of(opacity, uv), "bsdf": bsdf}, False
    emission = None
    if surface.emission.numbers is None or max(surface.emission.numbers) > 0:
        positive = fields.apply("max", surface.emission, fields.constant(0, 0, 0))
        emission = {"type": "area", "radiance": color_of(positive, uv)}
    others = sorted({(f.detail, f.width) for f in read if (f.detail, f.width) != (uv, UV_WIDTH)})
    return Look(
        bsdf, uv, emission, opaque, pierced=masked or surface.clear_base, primvars=tuple(others)
    )


def _bsdf(surface: Surface, fields: Fields, uv: str | None) -> tuple[dict[str, Any], bool]:
    """Return the BSDF without a mask, and whether it has a front only."""
    if _is_diffuse(surface):
        bounded = fields.apply("clamp", surface.base_color, fields.constant(0), fields.constant(1))
        return {"type": "diffuse", "reflectance": color_of(bounded, uv)}, True
    layered = layered_bsdf(surface, uv)
    opaque = not surface.clear_base
    if surface.transmission.numbers == (0.0,):
        return layered, opaque
    front = {"type": "twosided", "bsdf": layered} if opaque else layered
    dielectric = fields.apply("invert", surface.metalness, fields.constant(1))
    weight = fields.apply("multiply", surface.transmission, dielectric)
    weight = fields.apply("clamp", weight, fields.constant(0), fields.constant(1))
    return {
        "type": "blendbsdf",
        "weight": texture_of(weight, uv),
        "bsdf_0": front,
        "bsdf_1": _refraction(surface, fields, uv),
    }, False


def _is_diffuse(surface: Surface) -> bool:
    nothing = (surface.metalness, surface.coat, surface.transmission)
    return (
        all(f.numbers == (0.0,) for f in nothing)
        and surface.f0.numbers == (0.0, 0.0, 0.0)
        and surface.normal is None
        and not surface.clear_base
    )


def _refraction(surface: Surface, fields: Fields, uv: str | None) -> dict[str, Any]:
    color = fields.apply(
        "clamp", surface.transmission_color, fields.constant(0), fields.constant(1)
    )
    eta = max(surface.ior, MIN_ETA)
    if surface.thin_walled:
        return {
            "type": "thindielectric",
            "int_ior": eta,
            "specular_transmittance": color_of(color, uv),
        }
    smooth = fields.apply("clamp", surface.alpha, fields.constant(2e-3), fields.constant(1))
    bsdf = {
        "type": "roughdielectric",
        "distribution": "ggx",
        "int_ior": eta,
        "alpha_u": texture_of(fields.pick(smooth, 0), uv),
        "alpha_v": texture_of(fields.pick(smooth, 1), uv),
        "specular_transmittance": color_of(color, uv),
    }
    if surface.normal is None:
        return bsdf
    half = fields.constant(0.5)
    encoded = fields.apply("add", fields.apply("multiply", surface.normal, half), half)
    return {
        "type": "normalmap",
        "normalmap": texture_of(encoded, uv),
        "use_shadowing_function": False,
        "bsdf": bsdf,
    }


def _read(surface: Surface) -> list[Field]:
    """Return the primvars that a surface follows."""
    roots = (getattr(surface, name) for name in surface.__dataclass_fields__)
    found = walk(*(r for r in roots if isinstance(r, Field)))
    return [f for f in found if f.kind == "primvar"]


def _main_coordinates(surface: Surface, read: list[Field]) -> str | None:
    """Return the primvar that becomes the mesh's coordinates, which give it its tangents.

    It is the one that the normal follows, else the tangent, else the emission, of which
    emitters ask away from a mesh, else the first; `st` where only tangents are asked for.
    """
    for root in (surface.normal, surface.tangent, surface.emission):
        for node in walk(root):
            if node.kind == "primvar" and node.width == UV_WIDTH:
                return str(node.detail)
    first = next((str(f.detail) for f in read if f.width == UV_WIDTH), None)
    return DEFAULT_ST if first is None and _needs_tangents(surface) else first


def _needs_tangents(surface: Surface) -> bool:
    if surface.normal is not None or surface.tangent is not None:
        return True
    if surface.alpha.numbers is not None:
        return surface.alpha.numbers[0] != surface.alpha.numbers[1]
    return len(set(map(id, surface.alpha.args))) > 1
