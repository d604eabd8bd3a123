"""Meshes of a stage, each read once, and their parts with what looks ask for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd

from weaveusd.render import polygons
from weaveusd.render.geometry import Facets
from weaveusd.render.meshes import Part, Surface, corner_primvar, find_primvar, read_surface
from weaveusd.render.model import Losses
from weaveusd.render.reading import UnreadableError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Wanted:
    """A primvar that a look asks for, and the attribute of Mitsuba's mesh that carries it.

    Its `width` components are followed by zeros, up to `slots`.
    """

    primvar: str
    attribute: str
    width: int
    slots: int = 3


@dataclass(slots=True)
class MeshStore:
    """Reads meshes, those of native instances once for all that share them."""

    time: Usd.TimeCode
    losses: Losses
    _surfaces: dict[str, Surface | None] = field(default_factory=dict)
    _facets: dict[tuple[str | None, ...], Facets] = field(default_factory=dict)

    def surface(self, prim: Usd.Prim) -> Surface | None:
        """Return the mesh `prim`, or None, with a loss, where there is nothing to show."""
        shared = _shared_path(prim)
        if shared in self._surfaces:
            return self._surfaces[shared]
        try:
            made: Surface | None = read_surface(prim, self.time, self.losses)
        except UnreadableError as reason:
            self.losses.dropped(prim, f"mesh {reason}")
            made = None
        if shared is not None:
            self._surfaces[shared] = made
        return made

    def facets(
        self, prim: Usd.Prim, surface: Surface, part: Part, uv: str | None,
        wanted: Sequence[Wanted],
    ) -> Facets:  # fmt: skip
        """Return one part with the texture coordinates `uv` and the primvars that are `wanted`.

        What is missing is left out, but for texture coordinates: they are 0, and a loss says so.
        """
        names = (uv, *(w.primvar for w in wanted))
        key = (_shared_path(part.prim), *(self._origin(prim, name) for name in names))
        if key[0] is not None and key in self._facets:
            return self._facets[key]
        values: dict[str, Doubles] = {}
        if surface.normals is not None:
            values["normals"] = surface.normals
        if uv is not None:
            values["uv"] = self._coordinates(prim, surface, uv)
        for w in wanted:
            found = corner_primvar(prim, w.primvar, w.width, surface, self.time, self.losses)
            if found is not None:
                values[w.attribute] = np.pad(found, ((0, 0), (0, w.slots - w.width)))
        made = _split(surface, part, values)
        if key[0] is not None:
            self._facets[key] = made
        return made

    def _coordinates(self, prim: Usd.Prim, surface: Surface, uv: str) -> Doubles:
        found = corner_primvar(prim, uv, 2, surface, self.time, self.losses)
        if found is not None:
            return found
        self.losses.approximated(prim, f"has no texture coordinates {uv}: 0 is used")
        return np.zeros((surface.indices.size, 2))

    def _origin(self, prim: Usd.Prim, name: str | None) -> str | None:
        """Return where the value of a primvar comes from; what is shared by instances is equal."""
        primvar = find_primvar(prim, name) if name else None
        if not primvar:
            return None if name is None else f"without {name}"
        attribute = primvar.GetAttr()
        shared = _shared_path(attribute.GetPrim())
        return f"{shared or attribute.GetPrim().GetPath()}.{attribute.GetName()}"


def _split(surface: Surface, part: Part, values: dict[str, Doubles]) -> Facets:
    """Return a part as triangles whose vertices hold one value each."""
    mesh = polygons.split(part.triangles, surface.indices, values)
    at = {name: value[mesh.source] for name, value in values.items()}
    points = surface.points[surface.indices[mesh.source]]
    return Facets(points, mesh.triangles, at.pop("normals", None), at.pop("uv", None), at)


def _shared_path(prim: Usd.Prim) -> str | None:
    """Return the path in the prototype of what lies in a native instance, else None."""
    return str(prim.GetPrimInPrototype().GetPath()) if prim.IsInstanceProxy() else None
