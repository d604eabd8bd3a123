"""What a prim is made of: the bound material as a Mitsuba BSDF."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pxr import Sdf, Usd, UsdShade

from weaveusd import contract
from weaveusd.errors import InputError, StageError
from weaveusd.render import (
    cloth,
    gltf_pbr,
    nodes_mtlx,
    nodes_usd,
    openpbr,
    preview,
    standard_surface,
)
from weaveusd.render.bindings import bound_material
from weaveusd.render.fields import Fields
from weaveusd.render.look import Look, make_look
from weaveusd.render.model import Losses
from weaveusd.render.network import Network, Reader
from weaveusd.render.nodes import shader_id, source_of
from weaveusd.render.rasters import Rasters
from weaveusd.render.surface import Surface

PREVIEW = "preview"
MTLX = "mtlx"
OPENPBR = "openpbr"

_ROADS: dict[str, tuple[str, ...]] = {
    contract.MITSUBA_CONTEXT: (contract.MITSUBA_CONTEXT, MTLX, ""),
    MTLX: (MTLX, ""),
    OPENPBR: (MTLX, ""),
    PREVIEW: ("",),
}
"""For each context that can be asked for, the outputs of a material that are tried, in order.

The empty name is the universal output, `outputs:surface`.
"""

CONTEXTS = tuple(_ROADS)

DEFAULT_GRAY = 0.18
"""Reflectance of what has neither material nor display color, as in usdview."""

SURFACES: Mapping[str, Callable[[Network, UsdShade.Shader], Surface]] = {
    identifier: family.read
    for family in (preview, openpbr, standard_surface, gltf_pbr)
    for identifier in family.SHADER_IDS
}
"""Reads a surface shader, by `info:id`."""


@dataclass(slots=True)
class Looks:
    """Translates every material once, and equal networks to one look."""

    context: str
    time: Usd.TimeCode
    losses: Losses
    levels: bool = False  # whether cloths get levels for the distance
    _known: dict[str, Look | None] = field(default_factory=dict)
    _made: dict[tuple[object, ...], Look] = field(default_factory=dict)
    _fields: Fields = field(default_factory=Fields)
    _rasters: Rasters = field(default_factory=Rasters)
    _readers: dict[str, Reader] = field(
        default_factory=lambda: {**nodes_usd.readers(), **nodes_mtlx.readers()}
    )

    def __post_init__(self) -> None:
        if self.context not in CONTEXTS:
            expected = ", ".join(CONTEXTS[:-1])
            raise InputError(
                f"unknown render context '{self.context}': expected {expected} or {CONTEXTS[-1]}"
            )

    def of(self, prim: Usd.Prim) -> Look | None:
        """Return the look of the material bound to `prim` or above it; None where none serves.

        Raises
        ------
        StageError
            When a cloth is broken.
        """
        material = bound_material(prim, self.losses)
        if material is None:
            return None
        path = str(material.GetPath())
        if path not in self._known:
            self._known[path] = self._translate(material)
        return self._known[path]

    def _translate(self, material: UsdShade.Material) -> Look | None:
        """Return the look by the first output that has a shader which is understood."""
        refused: list[UsdShade.Shader] = []
        for context in _ROADS[self.context]:
            try:
                source = source_of(material.GetSurfaceOutput(context))
            except StageError as error:
                self.losses.dropped(material.GetPrim(), str(error))
                continue
            if source is None or source.node is None:
                continue
            understood = self._reader(context, source.node)
            if understood is not None:
                self._note_refused(refused, "another network is shown")
                return understood(source.node)
            refused.append(source.node)
        self._note_refused(refused, "")
        if not refused:
            self.losses.dropped(material.GetPrim(), "material has no surface that is understood")
        return None

    def _reader(
        self, context: str, shader: UsdShade.Shader
    ) -> Callable[[UsdShade.Shader], Look | None] | None:
        """Return what makes a look of a shader in this context, None where nothing does."""
        if context == contract.MITSUBA_CONTEXT:
            return self._cloth if shader_id(shader) == contract.CLOTH_SHADER_ID else None
        return self._surface if shader_id(shader) in SURFACES else None

    def _note_refused(self, shaders: list[UsdShade.Shader], instead: str) -> None:
        for shader in shaders:
            what = f"surface shader {shader_id(shader) or 'without id'}"
            if instead:
                self.losses.approximated(shader.GetPrim(), f"{what}: {instead}")
            else:
                self.losses.dropped(shader.GetPrim(), what)

    def _surface(self, shader: UsdShade.Shader) -> Look | None:
        net = Network(self.time, self.losses, self._fields, self._rasters, self._readers)
        try:
            surface = SURFACES[shader_id(shader)](net, shader)
        except StageError as error:
            self.losses.dropped(shader.GetPrim(), str(error))
            return None
        return self._once(surface.key(), lambda: make_look(surface, self._fields))

    def _cloth(self, shader: UsdShade.Shader) -> Look:
        def make() -> Look:
            bsdf, uv = cloth.translate(shader, self.time, self.losses, levels=self.levels)
            return Look(bsdf, uv, opaque=False, pierced=True)

        sources = (source_of(given) for given in shader.GetInputs())
        key = (_said(source.attribute, self.time) for source in sources if source is not None)
        return self._once(("cloth", *key), make)

    def _once(self, key: tuple[object, ...], make: Callable[[], Look]) -> Look:
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]


def _said(attribute: Usd.Attribute, time: Usd.TimeCode) -> tuple[str, ...]:
    """Return the value of an attribute in words; two files of one name are two."""
    value = attribute.Get(time)
    file = str(value.resolvedPath) if isinstance(value, Sdf.AssetPath) else ""
    space = str(attribute.GetColorSpace()) if attribute.HasColorSpace() else ""
    return attribute.GetName(), repr(value), file, space


def default_look(color: dict[str, Any]) -> Look:
    """Return the look of what binds nothing but has a display color."""
    return Look({"type": "diffuse", "reflectance": color})


PLAIN = default_look({"type": "rgb", "value": [DEFAULT_GRAY] * 3})
VERTEX_COLORED = default_look({"type": "mesh_attribute", "name": "vertex_color"})
