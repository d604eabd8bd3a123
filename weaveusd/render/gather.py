"""One walk over a stage: every shape and light that is seen, with the copies of instancers.

Every kind of prim has its module; what none of them knows becomes a loss, so that nothing
disappears in silence.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom

from weaveusd.render import instances, lights
from weaveusd.render.geometry import Placed
from weaveusd.render.instances import MAX_COPIES, Copies
from weaveusd.render.model import Losses
from weaveusd.render.pieces import Pieces
from weaveusd.render.reading import UnreadableError, authored
from weaveusd.render.xforms import Placing

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

MAX_NESTING = 16
"""Instancers inside prototypes of instancers."""

MAX_LIGHT_COPIES = 256

_FARTHEST = 1e30
"""Stage units; beyond, squares of distances are no numbers."""


@dataclass(slots=True)
class Found:
    """What a walk met: shapes, and lights with the placing of each of their copies."""

    shapes: list[Placed] = field(default_factory=list)
    lights: list[tuple[Usd.Prim, Placing]] = field(default_factory=list)


class Walk:
    """Gathers what is seen of a stage at one time.

    `purposes` are drawn beside `default`.
    """

    def __init__(
        self, stage: Usd.Stage, purposes: tuple[str, ...], pieces: Pieces, losses: Losses
    ) -> None:
        self.stage, self.time, self.losses = stage, pieces.time, losses
        self.purposes = {UsdGeom.Tokens.default_, *purposes}
        self.pieces = pieces
        self._prototypes: dict[str, Found] = {}

    def everything(self) -> Found:
        """Return all that is seen."""
        root = self.stage.GetPseudoRoot()
        found = self._below(root, UsdGeom.Imageable.PurposeInfo(), Placing(1.0, self.time), ())
        found.shapes = list(self._near(self._combined(found.shapes)))
        return found

    def _below(
        self, root: Usd.Prim, info: Any, placing: Placing, open_: tuple[Sdf.Path, ...]
    ) -> Found:
        """Return what is seen of `root` and below; `open_` are the instancers it is in."""
        found = Found()
        # What no specifier defines, as many prototypes, is drawn where an instancer asks for it.
        wanted = Usd.PrimIsActive & Usd.PrimIsLoaded
        if root.IsDefined() and not root.IsAbstract():
            wanted = Usd.PrimDefaultPredicate
        children = Usd.TraverseInstanceProxies(wanted)
        waiting = [(root, info)]
        while waiting:
            prim, above = waiting.pop()
            own = self._purpose(prim, above)
            if self._hidden(prim, own):
                continue
            entered = True
            purpose = own.purpose or UsdGeom.Tokens.default_
            if purpose in self.purposes and not prim.IsPseudoRoot():
                try:
                    entered = self._visit(prim, own, placing, open_, found)
                except UnreadableError as reason:
                    self.losses.dropped(prim, str(reason))
                except Tf.ErrorException as error:
                    self.losses.dropped(prim, _first_line(error))
            if entered and not prim.IsA(UsdGeom.PointInstancer):
                below = prim.GetFilteredChildren(children)
                waiting += [(child, own) for child in reversed(below)]
        return found

    def _visit(
        self, prim: Usd.Prim, info: Any, placing: Placing, open_: tuple[Sdf.Path, ...], found: Found
    ) -> bool:
        """Take in one prim; return whether what lies below it is looked at."""
        if lights.is_light(prim) and not prim.IsA(UsdGeom.Gprim):
            found.lights.append((prim, placing))
        elif prim.IsA(UsdGeom.PointInstancer):
            self._add_copies(prim, info, placing, open_, found)
            return False
        elif prim.IsA(UsdGeom.Gprim):
            found.shapes += self.pieces.of(prim, placing)
        elif _is_unknown(prim):
            self.losses.dropped(prim, f"type {prim.GetTypeName()} is unknown")
        return True

    def _purpose(self, prim: Usd.Prim, above: Any) -> Any:
        imageable = UsdGeom.Imageable(prim)
        return imageable.ComputePurposeInfo(above) if imageable else above

    def _hidden(self, prim: Usd.Prim, info: Any) -> bool:
        """Return whether the prim hides itself and all below, or all of its purpose."""
        if not UsdGeom.Imageable(prim):
            return False
        invisible = UsdGeom.Tokens.invisible
        for name in ("visibility", f"{info.purpose}Visibility"):
            attribute = prim.GetAttribute(name)
            if attribute and attribute.HasAuthoredValue():
                try:
                    if authored(attribute, self.time) == invisible:
                        return True
                except UnreadableError as reason:
                    self.losses.approximated(prim, str(reason))
        return False

    # --- Copies ---------------------------------------------------------------------------------

    def _add_copies(
        self, prim: Usd.Prim, info: Any, placing: Placing, open_: tuple[Sdf.Path, ...], found: Found
    ) -> None:
        """Take in all copies that an instancer makes."""
        world = self.pieces.matrix(prim, placing)
        inside = (*open_, prim.GetPath())
        if len(inside) > MAX_NESTING:
            raise UnreadableError(
                f"instancer lies in {len(open_)} others, expected {MAX_NESTING - 1}"
            )
        for copies in instances.read_copies(prim, self.time, self.losses):
            prototype = copies.prototype
            if any(path.HasPrefix(prototype.GetPath()) for path in inside):
                self.losses.dropped(prim, f"prototype {prototype.GetPath()} holds the instancer")
                continue
            matrices = world @ copies.matrices
            content = self._prototype(prototype, info, inside)
            for shape in content.shapes:
                found.shapes += self._copied(prim, shape, matrices, copies)
            self._copy_lights(prim, content, matrices, found)
        found.shapes = self._combined(found.shapes)

    def _prototype(self, prototype: Usd.Prim, info: Any, inside: tuple[Sdf.Path, ...]) -> Found:
        """Return what a prototype holds, in the space around its root."""
        key = f"{prototype.GetPath()} {info.purpose}"
        if key not in self._prototypes:
            placing = Placing(1.0, self.time).below(prototype)
            self._prototypes[key] = self._below(prototype, info, placing, inside)
        return self._prototypes[key]

    def _copied(
        self, prim: Usd.Prim, placed: Placed, matrices: Doubles, copies: Copies
    ) -> Iterator[Placed]:
        """Yield a shape of a prototype at all places, one for each color of the copies."""
        for look, shape, mine in self.pieces.bare.colored_copies(prim, placed, copies.colors):
            chosen = matrices if mine is None else matrices[mine]
            most = MAX_COPIES // len(placed.matrices)
            if len(chosen) > most:
                self.losses.dropped(prim, f"copies beyond the first {MAX_COPIES}")
                chosen = chosen[:most]
            product = chosen[:, None] @ placed.matrices
            if len(product):
                yield replace(placed, shape=shape, look=look, matrices=product.reshape(-1, 4, 4))

    def _copy_lights(self, prim: Usd.Prim, content: Found, matrices: Doubles, found: Found) -> None:
        for light, placing in content.lights:
            left = MAX_LIGHT_COPIES - len(found.lights)
            if len(matrices) > left:
                self.losses.dropped(prim, f"copies of lights beyond the first {MAX_LIGHT_COPIES}")
            found.lights += [(light, placing.copied(m)) for m in matrices[: max(left, 0)]]

    def _combined(self, found: list[Placed]) -> list[Placed]:
        """Return the shapes with all copies of one together, as many as are allowed."""
        same: dict[tuple[int, int, bool], list[Placed]] = {}
        for placed in found:
            key = (id(placed.shape), id(placed.look), placed.both_sides)
            same.setdefault(key, []).append(placed)
        together = []
        for group in same.values():
            first = group[0]
            if len(group) > 1:
                matrices = np.concatenate([placed.matrices for placed in group])
                if len(matrices) > MAX_COPIES:
                    self.losses.dropped(first.prim, f"copies beyond the first {MAX_COPIES}")
                first = replace(first, matrices=matrices[:MAX_COPIES])
            together.append(first)
        return together

    def _near(self, found: list[Placed]) -> Iterator[Placed]:
        """Yield what lies where numbers can be trusted."""
        for placed in found:
            if np.abs(np.array(placed.bounds())).max() < _FARTHEST:
                yield placed
            else:
                self.losses.dropped(placed.prim, f"reaches beyond {_FARTHEST:g} units")


def _is_unknown(prim: Usd.Prim) -> bool:
    """Return whether no schema defines the type that a prim says it is."""
    name = prim.GetTypeName()
    return bool(name) and not Usd.SchemaRegistry().FindConcretePrimDefinition(name)


def _first_line(error: Exception) -> str:
    return " ".join(str(error).split())[:200]
