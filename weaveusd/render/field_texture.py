"""Fields as Mitsuba textures: images, primvars and what a network computes with them.

Import this module after `weaveusd.render.variant.prepare`.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from weaveusd.render.fields import Field, compute, walk
from weaveusd.render.operations import Components

UV_WIDTH = 2


def attribute_name(primvar: str) -> str:
    """Return the name under which a mesh carries a primvar for networks, three numbers a vertex."""
    return f"vertex_primvar_{primvar}"


def texture_of(field: Field, uv: str | None) -> Any:
    """Return Mitsuba's texture of a field; `uv` is the primvar in the mesh's own coordinates."""
    return _class_of(mi.variant())(field, uv)


def color_of(field: Field, uv: str | None) -> Any:
    """Return a dictionary for a constant color (3), else the texture."""
    if field.numbers is not None:
        return {"type": "rgb", "value": list(field.numbers)}
    return texture_of(field, uv)


def evaluate(field: Field, uv: str | None, si: Any, active: Any) -> Components:
    """Return the components of a field at the interactions `si`."""

    def leaf(node: Field, args: list[Components]) -> Components:
        if node.kind == "picture":
            return _texel(node, args[0], active)
        if node.detail == uv and node.width == UV_WIDTH:
            return [si.uv.x, si.uv.y]
        return _primvar(node, args[0], si, active)

    return compute(field, leaf)


def address(x: Any, texels: int, mode: str) -> tuple[Any, Any]:
    """Return where a row of texels over 0…1 is read for `x`, and the share it has there.

    The row itself repeats. Held half a texel inside, it clamps; folded, it mirrors. Beyond a
    border the share falls to 0 over one texel, as a linear filter has it.
    """
    half = 0.5 / texels
    if mode == "repeat":
        return x, 1.0
    if mode == "mirror":
        x = 1 - dr.abs(x - 2 * dr.floor(x * 0.5) - 1)
    inside = dr.clip(x, half, 1 - half)
    if mode != "border":
        return inside, 1.0
    return inside, dr.clip(dr.minimum(x, 1 - x) * texels + 0.5, 0.0, 1.0)


def _texel(node: Field, st: Components, active: Any) -> Components:
    sampling = node.detail
    raster, wrap = sampling.raster, sampling.wrap
    if (raster.columns, raster.rows) != (1, 1):
        st, wrap = [st[0] / raster.columns, st[1] / raster.rows], ("border", "border")
    u, share_u = address(st[0], raster.size[0], wrap[0])
    v, share_v = address(st[1], raster.size[1], wrap[1])
    found: Components = raster.channels_at(mi.Point2f(u, v), active, sampling.smooth)
    if "border" not in wrap:
        return found
    share = share_u * share_v
    if not sampling.smooth:
        share = dr.select(share >= 0.5, 1.0, 0.0)
    return [b + (t - b) * share for t, b in zip(found, sampling.border, strict=True)]


def _primvar(node: Field, fallback: Components, si: Any, active: Any) -> Components:
    name = attribute_name(node.detail)
    shape = si.shape
    if shape is None:
        return fallback
    present = shape.has_attribute(name)
    if not dr.is_jit_v(mi.Float) and not present:
        return fallback
    found = shape.eval_attribute_3(name, si, active & present)
    return [dr.select(present, found[k], fallback[k]) for k in range(node.width)]


@cache
def _class_of(variant: str) -> type:
    """Return the texture's class: it derives from the Texture of one variant."""

    class FieldTexture(mi.Texture):  # type: ignore[misc]
        """Mitsuba's side of a field for the variant of its creation."""

        def __init__(self, field: Field, uv: str | None) -> None:
            mi.Texture.__init__(self, mi.Properties())
            self.field, self.uv = field, uv
            # Opaque numbers keep kernels alike, so that other materials reuse them.
            self.numbers = None if field.numbers is None else [mi.Float(v) for v in field.numbers]
            dr.make_opaque(self.numbers)
            for node in walk(field):
                if node.kind == "picture":
                    node.detail.raster.prepare(node.detail.smooth)

        def components(self, si: Any, active: Any) -> Components:
            if self.numbers is not None:
                return self.numbers
            return evaluate(self.field, self.uv, si, active)

        def eval(self, si: Any, active: Any = True) -> Any:
            return self.eval_3(si, active)

        def eval_1(self, si: Any, active: Any = True) -> Any:
            return mi.Float(self.components(si, active)[0])

        def eval_3(self, si: Any, active: Any = True) -> Any:
            found = self.components(si, active)
            return mi.Color3f(*(found * 3 if len(found) == 1 else [*found, 0.0])[:3])

        def mean(self) -> Any:
            return mi.Float(np.mean(self.field.numbers or 0.5))

        def is_spatially_varying(self) -> bool:
            # An emitter would draw points from the texture's own square: its coordinates are not
            # those of the surface, so points are drawn from the surface.
            return False

        def to_string(self) -> str:
            return f"FieldTexture[{self.field.kind}, {self.field.width} components, {variant}]"

    return FieldTexture
