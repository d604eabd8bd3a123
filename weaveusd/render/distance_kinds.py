"""Yarns of a far cloth: the optics of warp and of weft, of unlike kinds by their shares in a cell.

A strand draws its kind by chance. So the mean over many is that of all kinds, and cells of one
kind cost nothing more.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import drjit as dr
import mitsuba as mi
import numpy as np

from weaveusd.contract import MAX_KINDS
from weaveusd.render.distance_frames import DRAWN, spaced
from weaveusd.render.distance_levels import Levels
from weaveusd.render.optics import YARN_INPUTS

if TYPE_CHECKING:
    from numpy.typing import NDArray


def kind_properties(levels: Levels, optics: NDArray[np.float32]) -> dict[str, Any]:
    """Return what `Kinds` finds in the plugin's properties, from the optics of all yarns."""
    yarns = [[*own, *[own[-1]] * (MAX_KINDS - len(own))] for own in levels.yarns]
    return {
        "kind_counts": mi.TensorXf([float(len(own)) for own in levels.yarns]),
        "kind_optics": mi.TensorXf(optics[:, np.ravel(yarns)]),
        **({} if levels.kinds is None else {"kinds": mi.TensorXf(levels.kinds)}),
    }


class Kinds:
    """The optics of each system's kinds of yarn, in the order of `YARN_INPUTS`."""

    def __init__(self, props: Any) -> None:
        table = props["kind_optics"]
        self.optics = [mi.Float(table[i].array) for i in range(len(YARN_INPUTS))]
        self.first = [[mi.Float(of[MAX_KINDS * k]) for of in self.optics] for k in range(2)]
        self.are_alike = [float(count) == 1 for count in props["kind_counts"].array]
        self.reached = mi.Float(props["kinds"].array) if "kinds" in props else None
        dr.make_opaque(self.first)

    def drawn(self, system: int, cell: Any, active: Any, chance: Any) -> list[list[Any]]:
        """Return the optics of each strand of a system in a cell; `chance` is uniform in 0…1."""
        if self.are_alike[system]:
            return [self.first[system]] * DRAWN
        reached = dr.gather(mi.Vector4f, self.reached, cell * 2 + system, active)
        drawn = []
        for number in range(DRAWN):
            place, kind = spaced(chance, number), mi.UInt32(MAX_KINDS * system)
            for k in range(MAX_KINDS - 1):
                kind += dr.select(place >= reached[k], mi.UInt32(1), 0)
            drawn.append([dr.gather(mi.Float, of, kind, active) for of in self.optics])
        return drawn
