"""The layered surface as a Mitsuba BSDF: coat, anisotropic mirror, diffuse base.

Mitsuba's `principled` adds a highlight to a full diffuse base and so reflects more than it
receives; it takes no F0, no direction of its highlight and one roughness of coat. This BSDF
has what `Surface` names, and each layer gets only what those above let through.

Import this module after `weaveusd.render.variant.prepare`.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import mitsuba as mi

from weaveusd.render.field_texture import texture_of
from weaveusd.render.layers import Layers
from weaveusd.render.plugin import plugin_base
from weaveusd.render.surface import Surface

PLUGIN = "weaveusd_layered"

_INPUTS = ("base_color", "metalness", "metal_f90", "f0", "f90", "alpha", "coat", "coat_f0",
           "coat_alpha", "coat_color", "opacity", "normal", "tangent")  # fmt: skip


def layered_bsdf(surface: Surface, uv: str | None) -> dict[str, Any]:
    """Return the dictionary of a surface's BSDF, without its transmission and emission.

    `uv` is the primvar that the mesh carries as its texture coordinates. The BSDF has a front
    only, but for a surface with `clear_base`: that has two sides, and what opacity lets through
    below the highlights goes straight on. Any other opacity is left to a mask around it.
    """
    _register(mi.variant())
    given = {name: getattr(surface, name) for name in _INPUTS}
    textures = {name: texture_of(f, uv) for name, f in given.items() if f is not None}
    return {"type": PLUGIN, "clear_base": surface.clear_base, **textures}


@cache
def _register(variant: str) -> None:
    mi.register_bsdf(PLUGIN, _plugin_class(variant))


def _plugin_class(variant: str) -> type:
    """Return the plugin's class: it derives from the BSDF of one variant."""

    class LayeredBSDF(plugin_base()):  # type: ignore[misc]
        """Mitsuba's side of `Layers` for the variant of its creation."""

        def __init__(self, props: Any) -> None:
            clear = bool(props["clear_base"])
            self.layers = Layers({n: props[n] for n in _INPUTS if n in props}, clear)
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.SpatiallyVarying
            if clear:
                sides |= mi.BSDFFlags.BackSide
            components = [
                mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.Anisotropic | sides,
                mi.BSDFFlags.DiffuseReflection | sides,
            ]
            if clear:
                components.append(mi.BSDFFlags.Null | sides)
            super().__init__(props, self.layers, components)

        def traverse(self, callback: Any) -> None:
            for name, texture in self.layers.textures.items():
                callback.put(name, texture, mi.ParamFlags.Differentiable)

        def to_string(self) -> str:
            return f"LayeredBSDF[{variant}]"

    return LayeredBSDF
