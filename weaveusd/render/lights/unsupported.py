"""What a light asks for and Mitsuba's emitters cannot do: named, never silent."""

from __future__ import annotations

from pxr import Gf, Usd, UsdGeom, UsdLux

from weaveusd.render.lights.inputs import Inputs

_NEUTRAL_SHADOWS = {
    "color": Gf.Vec3f(0.0),
    "distance": -1.0,
    "enable": True,
    "falloff": -1.0,
}
"""Shadow settings with the values that change nothing; falloffGamma needs a falloff."""


def note_unsupported(inputs: Inputs) -> None:
    """Report shaders, filters, links that exclude, and shadow settings that change a picture."""
    _note_shader(inputs)
    _note_filters(inputs)
    _note_shadows(inputs)
    light = UsdLux.LightAPI(inputs.prim)
    for name, verb, collection in (
        ("light link", "is lit", light.GetLightLinkCollectionAPI()),
        ("shadow link", "casts a shadow", light.GetShadowLinkCollectionAPI()),
    ):
        left_out = _left_out(inputs.prim, collection)
        if left_out:
            more = f" and {len(left_out) - 1} more" if len(left_out) > 1 else ""
            inputs.losses.dropped(
                inputs.prim, f"{name}: {left_out[0]}{more} {verb} although it is left out"
            )


def _note_shader(inputs: Inputs) -> None:
    shader = inputs.prim.GetAttribute("light:shaderId")
    if shader and shader.HasAuthoredValue():
        own = inputs.prim.GetPrimDefinition().GetAttributeFallbackValue("light:shaderId")
        stated = shader.Get(inputs.time)
        if stated and stated != own:
            kind = inputs.prim.GetTypeName()
            inputs.losses.approximated(inputs.prim, f"shader {stated} is shown as {kind}")


def _note_filters(inputs: Inputs) -> None:
    for name in ("light:filters", "filters"):
        relation = inputs.prim.GetRelationship(name)
        for target in relation.GetTargets() if relation else ():
            inputs.losses.dropped(inputs.prim, f"light filter {target}")


def _note_shadows(inputs: Inputs) -> None:
    asked = [
        name
        for name, neutral in _NEUTRAL_SHADOWS.items()
        if inputs.value(f"shadow:{name}", neutral) != neutral
    ]
    if asked:
        names = ", ".join(f"shadow:{name}" for name in asked)
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
