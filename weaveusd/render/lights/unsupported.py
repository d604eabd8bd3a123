"""What a light asks for and Mitsuba's emitters cannot do: named, never silent."""

from __future__ import annotations

from pxr import Usd, UsdGeom, UsdLux

from weaveusd.render.lights.inputs import Inputs

_SHADOWS: dict[str, float] = {"distance": -1.0, "falloff": -1.0}


def note_unsupported(inputs: Inputs) -> None:
    """Report filters, links that exclude something, and shadow settings that change a picture."""
    _note_filters(inputs)
    _note_shadows(inputs)
    light = UsdLux.LightAPI(inputs.prim)
    for name, what, collection in (
        ("light link", "lit", light.GetLightLinkCollectionAPI()),
        ("shadow link", "shadows of", light.GetShadowLinkCollectionAPI()),
    ):
        left_out = _left_out(inputs.prim, collection)
        if left_out:
            more = f" and {len(left_out) - 1} more" if len(left_out) > 1 else ""
            verb = "is lit" if what == "lit" else "casts a shadow"
            inputs.losses.dropped(
                inputs.prim, f"{name}: {left_out[0]}{more} {verb} although it is left out"
            )


def _note_filters(inputs: Inputs) -> None:
    for name in ("light:filters", "filters"):
        relation = inputs.prim.GetRelationship(name)
        for target in relation.GetTargets() if relation else ():
            inputs.losses.dropped(inputs.prim, f"light filter {target}")


def _note_shadows(inputs: Inputs) -> None:
    if not inputs.prim.HasAPI(UsdLux.ShadowAPI):
        return
    asked = [
        name
        for name, neutral in _SHADOWS.items()
        if inputs.value(f"shadow:{name}", neutral) not in (None, neutral)
    ]
    if not inputs.value("shadow:enable", True):
        asked.append("enable")
    if any(inputs.value("shadow:color", (0, 0, 0))):
        asked.append("color")
    if asked:
        names = ", ".join(f"shadow:{name}" for name in sorted(asked))
        inputs.losses.dropped(inputs.prim, f"{names}: its shadows are as the geometry casts them")


def _left_out(prim: Usd.Prim, collection: Usd.CollectionAPI) -> list[str]:
    """Return the paths of the shapes that a collection leaves out; most lights list nothing."""
    rules = (
        collection.GetIncludesRel(),
        collection.GetExcludesRel(),
        collection.GetIncludeRootAttr(),
        collection.GetMembershipExpressionAttr(),
        collection.GetExpansionRuleAttr(),
    )
    if not any(rule and rule.IsAuthored() for rule in rules):
        return []
    members = collection.ComputeMembershipQuery()
    everything = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
    return [
        str(shape.GetPath())
        for shape in Usd.PrimRange(prim.GetStage().GetPseudoRoot(), everything)
        if shape.IsA(UsdGeom.Gprim) and not members.IsPathIncluded(shape.GetPath())
    ]
