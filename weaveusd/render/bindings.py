"""Which material a prim is bound to: directly, by inheritance, by collection, for a purpose."""

from __future__ import annotations

from pxr import Usd, UsdShade

from weaveusd.render.model import Losses
from weaveusd.stage import captured_diagnostics

PURPOSE = UsdShade.Tokens.full
"""Bindings for final pictures go first; those for all purposes serve where there are none."""


def bound_material(prim: Usd.Prim, losses: Losses) -> UsdShade.Material | None:
    """Return the material of a prim or GeomSubset, None where none serves.

    As USD resolves it: the nearest ancestor's binding wins, unless one above is stronger than
    its descendants, and a collection's before a direct one. A binding whose target is missing
    or no material is a loss, and what it would have dressed has no material.
    """
    with captured_diagnostics() as complaints:
        material, relation = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(PURPOSE)
    if material:
        return material
    fault = _fault(relation) if relation else _nearest_fault(prim)
    if fault:
        losses.dropped(prim, fault)
    elif complaints:
        losses.dropped(prim, f"its material binding: {complaints[0][:200]}")
    return None


def _nearest_fault(prim: Usd.Prim) -> str:
    """Return what is wrong with a binding that reaches the prim, empty where none does."""
    while prim and not prim.IsPseudoRoot():
        for purpose in (f":{PURPOSE}", ""):
            relation = prim.GetRelationship(f"{UsdShade.Tokens.materialBinding}{purpose}")
            if relation and relation.GetTargets():
                return _fault(relation)
        prim = prim.GetParent()
    return ""


def _fault(relation: Usd.Relationship) -> str:
    targets = relation.GetForwardedTargets()
    if not targets:
        return "its material binding has no target"
    target = relation.GetStage().GetPrimAtPath(targets[-1])
    if not target:
        return f"its material binding names {targets[-1]}, which is not"
    return f"its material binding names {targets[-1]}, which is no material"
