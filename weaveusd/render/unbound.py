"""What shapes without a material look like: displayColor and displayOpacity, else gray."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Usd, UsdGeom

from weaveusd.render import materials
from weaveusd.render.curves import Curves, curve_colors
from weaveusd.render.geometry import Balls, Facets, Placed, Shape, Strands
from weaveusd.render.look import Look
from weaveusd.render.mesh_store import Wanted
from weaveusd.render.model import Losses
from weaveusd.render.reading import UnreadableError, as_rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]
    Indices = NDArray[np.int64]

MAX_COLORS = 64
"""Colors of one prim's points or curves, which Mitsuba gives no colors of their own."""

_GRAY = (materials.DEFAULT_GRAY,) * 3


DISPLAY = (
    Wanted("displayColor", "vertex_color", 3),
    Wanted("displayOpacity", "vertex_opacity", 1, slots=1),
)
"""What a mesh without a material carries."""


def _pierced(base: Look, opacity: Any) -> Look:
    bsdf = {"type": "twosided", "bsdf": base.bsdf}
    mask = {"type": "mask", "opacity": opacity, "bsdf": bsdf}
    return Look(mask, opaque=False, pierced=True)


_ATTRIBUTE = {"type": "mesh_attribute", "name": "vertex_opacity"}
_PIERCED = {
    colored: _pierced(base, _ATTRIBUTE)
    for colored, base in ((True, materials.VERTEX_COLORED), (False, materials.PLAIN))
}


def _mesh_look(facets: Facets) -> tuple[Facets, Look]:
    colored, opacity = "vertex_color" in facets.attributes, facets.attributes.get("vertex_opacity")
    if opacity is not None and opacity.min() < 1:
        bounded = {**facets.attributes, "vertex_opacity": np.clip(opacity, 0, 1)}
        return replace(facets, attributes=bounded), _PIERCED[colored]
    kept = {k: v for k, v in facets.attributes.items() if k != "vertex_opacity"}
    look = materials.VERTEX_COLORED if colored else materials.PLAIN
    return replace(facets, attributes=kept), look


@dataclass(slots=True)
class Bare:
    """Gives looks to shapes that Mitsuba gives no colors of their own, one for each color."""

    time: Usd.TimeCode
    losses: Losses
    _known: dict[tuple[float, ...], Look] = field(
        default_factory=lambda: {(*_GRAY, 1.0): materials.PLAIN}
    )
    _meshes: dict[int, tuple[Facets, Facets, Look]] = field(default_factory=dict)

    def mesh(self, facets: Facets) -> tuple[Facets, Look]:
        """Return a mesh and its look after the color and opacity of its vertices, if any."""
        if id(facets) not in self._meshes:
            # What was asked about is kept: its id must not pass to another one.
            self._meshes[id(facets)] = (facets, *_mesh_look(facets))
        _, shown, look = self._meshes[id(facets)]
        return shown, look

    def solid(self, prim: Usd.Prim, shape: Balls | Facets) -> Iterator[tuple[Shape, Look]]:
        """Yield a solid, or the points of a cloud, in their colors."""
        opacity = self._opacity(prim)
        count = len(shape.radii) if isinstance(shape, Balls) else 1
        colors = self._colors(prim, count)
        if colors is None or not isinstance(shape, Balls) or len(colors) == 1:
            yield shape, self._look(_GRAY if colors is None else tuple(colors[0].tolist()), opacity)
            return
        for color, mine in self._by_color(prim, colors):
            yield Balls(shape.centers[mine], shape.radii[mine]), self._look(color, opacity)

    def curves(self, prim: Usd.Prim, tubes: Strands, cut: Curves) -> Iterator[tuple[Shape, Look]]:
        """Yield curves in their colors."""
        opacity = self._opacity(prim)
        colors = curve_colors(prim, cut, self.time, self.losses)
        if colors is None:
            yield tubes, self._look(_GRAY, opacity)
            return
        for color, mine in self._by_color(prim, colors):
            yield replace(tubes, segments=tubes.segments[mine]), self._look(color, opacity)

    def colored_copies(
        self, prim: Usd.Prim, placed: Placed, colors: Doubles | None
    ) -> Iterator[tuple[Look, Shape, Indices | None]]:
        """Yield the look and the shape of a prototype for the copies of each color of theirs."""
        if colors is None or placed.look is not materials.PLAIN:
            yield placed.look, placed.shape, None
            return
        for color, mine in self._by_color(prim, colors):
            yield self._look(color, 1.0), placed.shape, mine

    def _by_color(
        self, prim: Usd.Prim, colors: Doubles
    ) -> Iterator[tuple[tuple[float, ...], Indices]]:
        """Yield each color and the places where it is; too many of them become their mean."""
        distinct, which = np.unique(colors, axis=0, return_inverse=True)
        if len(distinct) > MAX_COLORS:
            self.losses.approximated(prim, f"more than {MAX_COLORS} colors are shown as their mean")
            yield tuple(colors.mean(axis=0).tolist()), np.arange(len(colors))
            return
        for number, color in enumerate(distinct):
            yield tuple(color.tolist()), np.flatnonzero(which.reshape(-1) == number)

    def _colors(self, prim: Usd.Prim, count: int) -> Doubles | None:
        """Return the displayColor, (1, 3) or (count, 3); None without one."""
        values = self._primvar(prim, "displayColor", 3)
        if values is None or not len(values):
            return None
        return values if len(values) == count else values[:1]

    def _opacity(self, prim: Usd.Prim) -> float:
        """Return the displayOpacity of a whole prim."""
        values = self._primvar(prim, "displayOpacity", 1)
        if values is None or not len(values):
            return 1.0
        if np.ptp(values) > 0:
            self.losses.approximated(prim, "displayOpacity is shown as its mean")
        return float(np.clip(values.mean(), 0, 1))

    def _primvar(self, prim: Usd.Prim, name: str, width: int) -> Doubles | None:
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        if not primvar or not primvar.HasValue():
            return None
        try:
            return as_rows(primvar.ComputeFlattened(self.time), width, f"primvar {name}")
        except UnreadableError as reason:
            self.losses.dropped(prim, str(reason))
            return None

    def _look(self, color: tuple[float, ...], opacity: float) -> Look:
        key = (*color, opacity)
        if key not in self._known:
            look = materials.default_look({"type": "rgb", "value": list(color)})
            self._known[key] = look if opacity >= 1 else _pierced(look, opacity)
        return self._known[key]
