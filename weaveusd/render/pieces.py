"""What one prim shows: its shapes, each with a look."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from pxr import Usd, UsdGeom

from weaveusd.render import curves, lights, meshes, shapes, unbound
from weaveusd.render.field_texture import attribute_name
from weaveusd.render.geometry import Balls, Facets, Placed, Shape, Strands
from weaveusd.render.look import Look
from weaveusd.render.materials import Looks
from weaveusd.render.mesh_store import MeshStore, Wanted
from weaveusd.render.model import Losses
from weaveusd.render.reading import UnreadableError, authored
from weaveusd.render.xforms import Placing, singular

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]


class Pieces:
    """Turns prims into shapes in the material bound to them, else in colors of their own.

    `shining` says of each shape whether a light makes it shine.
    """

    def __init__(
        self, time: Usd.TimeCode, looks: Looks, shining: lights.Lights, losses: Losses
    ) -> None:
        self.time, self.losses = time, losses
        self.looks, self.lights = looks, shining
        self.meshes = MeshStore(time, losses)
        self.bare = unbound.Bare(time, losses)

    def of(self, prim: Usd.Prim, placing: Placing) -> list[Placed]:
        """Return a prim's shapes, one for each look of its.

        Raises
        ------
        UnreadableError
            When nothing of it can be shown.
        """
        matrix = self.matrix(prim, placing)
        both_sides = _both_sides(prim, self.time)
        if prim.IsA(UsdGeom.Mesh):
            pieces = self._mesh(prim, matrix, placing)
        elif prim.IsA(UsdGeom.BasisCurves):
            pieces = self._curves(prim)
        else:
            pieces = self._solid(prim, matrix, placing)
        path = str(prim.GetPath())
        return [Placed(path, s, matrix[None], look, both_sides) for s, look in pieces]

    def _mesh(
        self, prim: Usd.Prim, matrix: Doubles, placing: Placing
    ) -> Iterator[tuple[Shape, Look]]:
        surface = self.meshes.surface(prim)
        if surface is None:
            return
        light = self.lights.of(prim, self.time)
        for part in meshes.parts(prim, surface, self.time, self.losses):
            bound = self.looks.of(part.prim)
            if bound is None:
                facets = self.meshes.facets(prim, surface, part, None, unbound.DISPLAY)
                facets, look = self.bare.mesh(facets)
            else:
                wanted = [
                    Wanted(name, attribute_name(name), width) for name, width in bound.primvars
                ]
                facets = self.meshes.facets(prim, surface, part, bound.uv, wanted)
                look = bound
            if light:
                area = meshes.surface_area(surface, matrix)
                look = self.lights.shine(light, look, area, placing)
            yield facets, look

    def _solid(
        self, prim: Usd.Prim, matrix: Doubles, placing: Placing
    ) -> Iterator[tuple[Shape, Look]]:
        shape: Balls | Facets
        if prim.IsA(UsdGeom.Points):
            shape = shapes.points_as_balls(prim, self.time, self.losses)
        else:
            shape = shapes.solid(prim, self.time)
        bound = self.looks.of(prim)
        if bound is not None and bound.uv is not None:
            self.losses.approximated(
                prim, f"{prim.GetTypeName()} has no texture coordinates {bound.uv} in USD"
            )
        if bound is not None:
            pieces: list[tuple[Shape, Look]] = [(shape, bound)]
        else:
            pieces = list(self.bare.solid(prim, shape))
        light = self.lights.of(prim, self.time)
        for piece, look in pieces:
            if light and not isinstance(piece, Strands):
                area = shapes.surface_area(piece, matrix)
                look = self.lights.shine(light, look, area, placing)
            if isinstance(piece, Facets) and look.uv is None:
                piece = replace(piece, uv=None)
            yield piece, look

    def _curves(self, prim: Usd.Prim) -> Iterator[tuple[Shape, Look]]:
        tubes, cut = curves.strands(prim, self.time, self.losses)
        bound = self.looks.of(prim)
        if bound is None:
            yield from self.bare.curves(prim, tubes, cut)
            return
        if bound.uv is not None:
            self.losses.approximated(prim, f"curves have no texture coordinates {bound.uv}")
        if bound.emission is not None or self.lights.of(prim, self.time):
            self.losses.dropped(prim, "light of curves")
            bound = replace(bound, emission=None)
        yield tubes, bound

    def matrix(self, prim: Usd.Prim, placing: Placing) -> Doubles:
        """Return the matrix of a prim in stage units; UnreadableError where nothing is seen."""
        if not np.array_equal(placing.authored(prim)[3], (0, 0, 0, 1)):
            self.losses.approximated(prim, "perspective part of its transform is ignored")
        matrix = placing.unscaled(prim)
        if not np.isfinite(matrix).all():
            raise UnreadableError("its transform holds a value that is no finite number")
        if singular(matrix):
            raise UnreadableError("shape is flattened by its transform")
        return matrix


def _both_sides(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    """Return whether the back shows: yes, unless the stage itself says no."""
    attribute = UsdGeom.Gprim(prim).GetDoubleSidedAttr()
    return bool(authored(attribute, time)) if attribute.HasAuthoredValue() else True
