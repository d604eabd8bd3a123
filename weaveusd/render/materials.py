"""What a prim is made of: the bound material as a Mitsuba BSDF."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pxr import Usd, UsdShade

from weaveusd import contract
from weaveusd.errors import InputError, StageError
from weaveusd.render import cloth, preview
from weaveusd.render.model import Losses

PREVIEW = "preview"
CONTEXTS = (contract.MITSUBA_CONTEXT, PREVIEW)
"""Render contexts that can be asked for; the first falls back to the second."""

DEFAULT_GRAY = 0.18
"""Reflectance of what has neither material nor display color, as in usdview."""


@dataclass(frozen=True, slots=True)
class Look:
    """A material ready for shapes: the BSDF's dictionary, and what a shape must bring.

    `opaque` BSDFs have a black back until they are made two-sided; `pierced` ones let light pass
    straight through some of their points.
    """

    bsdf: dict[str, Any]
    uv: str | None = None
    emission: dict[str, Any] | None = None
    opaque: bool = True
    pierced: bool = False


@dataclass(slots=True)
class Looks:
    """Translates every material once."""

    context: str
    time: Usd.TimeCode
    losses: Losses
    _known: dict[str, Look | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.context not in CONTEXTS:
            raise InputError(
                f"unknown render context '{self.context}': expected {' or '.join(CONTEXTS)}"
            )

    def of(self, prim: Usd.Prim) -> Look | None:
        """Return the look of the material bound to `prim` or above it; None where none serves."""
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(UsdShade.Tokens.full)
        if not material:
            if _has_unresolved_binding(prim):
                self.losses.dropped(prim, "its material binding names no material")
            return None
        path = str(material.GetPath())
        if path not in self._known:
            self._known[path] = self._translate(material)
        return self._known[path]

    def _translate(self, material: UsdShade.Material) -> Look | None:
        """Return the look in the wanted context, else in the universal one."""
        if self.context == contract.MITSUBA_CONTEXT:
            look = self._exact(material)
            if look is not None:
                return look
        shader = _surface(material, UsdShade.Tokens.universalRenderContext)
        if shader is None:
            self.losses.dropped(material.GetPrim(), "material has no surface that is understood")
            return None
        if shader.GetShaderId() != preview.SHADER_ID:
            self.losses.dropped(shader.GetPrim(), f"surface shader {shader.GetShaderId()}")
            return None
        try:
            made = preview.translate(shader, self.time, self.losses)
        except StageError as error:
            self.losses.dropped(shader.GetPrim(), str(error))
            return None
        return Look(made.bsdf, made.uv, made.emission, made.opaque, pierced=not made.opaque)

    def _exact(self, material: UsdShade.Material) -> Look | None:
        shader = _surface(material, contract.MITSUBA_CONTEXT)
        if shader is None:
            return None
        if shader.GetShaderId() != contract.CLOTH_SHADER_ID:
            self.losses.dropped(
                shader.GetPrim(),
                f"surface shader {shader.GetShaderId()}, expected {contract.CLOTH_SHADER_ID}",
            )
            return None
        bsdf, uv = cloth.translate(shader, self.time, self.losses)
        return Look(bsdf, uv, opaque=False, pierced=True)


def default_look(color: dict[str, Any]) -> Look:
    """Return the look of what binds nothing but has a display color."""
    return Look({"type": "diffuse", "reflectance": color})


PLAIN = default_look({"type": "rgb", "value": [DEFAULT_GRAY] * 3})
VERTEX_COLORED = default_look({"type": "mesh_attribute", "name": "vertex_color"})


def _surface(material: UsdShade.Material, context: str) -> UsdShade.Shader | None:
    """Return the shader that feeds the surface output of exactly this context, or None."""
    output = material.GetSurfaceOutput(context)
    if not output:
        return None
    for attribute in UsdShade.Utils.GetValueProducingAttributes(output, True):
        shader = UsdShade.Shader(attribute.GetPrim())
        if shader:
            return shader
    return None


def _has_unresolved_binding(prim: Usd.Prim) -> bool:
    while prim and not prim.IsPseudoRoot():
        relation = prim.GetRelationship(UsdShade.Tokens.materialBinding)
        if relation and relation.GetTargets():
            return True
        prim = prim.GetParent()
    return False
