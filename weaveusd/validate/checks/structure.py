"""Whether the entry layer is built as others expect of an asset."""

from __future__ import annotations

from collections.abc import Iterator

from pxr import UsdGeom, UsdShade

from weaveusd import contract
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset, applied_schemas
from weaveusd.validate.registry import Code, check

ROOT = Code("root-not-scope", Status.FAIL, "The default prim is missing or not a Scope.")
MATERIAL = Code(
    "material-missing", Status.FAIL, "The default prim holds no Material with the cloth schema."
)
METADATA = Code(
    "stage-metadata", Status.FAIL, "The entry layer does not state metersPerUnit or upAxis."
)
LOOK = Code("look-not-referenced", Status.FAIL, "The entry layer does not reference its look.")
UNCHOSEN = Code("colorway-unchosen", Status.FAIL, "There are colorways, and none is chosen.")
INFO = Code("asset-info", Status.FAIL, "The asset's identifier or name is missing or wrong.")


@check(
    id="structure/asset",
    why="Pipelines reference an asset by its default prim, trust its units and read its "
    "identity from assetInfo; a material at the root fails other houses' checks.",
    codes=(ROOT, MATERIAL, METADATA, UNCHOSEN, LOOK, INFO),
)
def asset_structure(asset: OpenAsset) -> Iterator[Finding]:
    """The entry layer has a Scope with one cloth material, units, a look and an identity."""
    layer = asset.stage.GetRootLayer()
    for name in (UsdGeom.Tokens.metersPerUnit, UsdGeom.Tokens.upAxis):
        if not layer.pseudoRoot.HasInfo(name):
            yield METADATA(f"{name} is not authored", asset.short(layer.realPath))

    root = asset.root
    if not root or root.GetTypeName() != "Scope":
        found = f"a {root.GetTypeName() or 'typeless prim'}" if root else "no default prim"
        yield ROOT(f"{found}, expected a Scope as default prim", asset.short(layer.realPath))
        return

    material = root.GetChild(contract.MATERIAL_NAME)
    if not (
        material
        and material.IsA(UsdShade.Material)
        and contract.CLOTH_API in applied_schemas(material)
    ):
        yield MATERIAL(
            f"expected a Material {contract.MATERIAL_NAME!r} with {contract.CLOTH_API}",
            str(root.GetPath()),
        )

    if asset.colorways and not asset.chosen:
        yield UNCHOSEN(
            f"none of {', '.join(asset.colorways[:8])} is chosen, expected one as the default",
            str(root.GetPath()),
        )
    # Those of a variant are in a spec of their own.
    specs = [spec for spec in root.GetPrimStack() if spec.layer == layer]
    references = [r for spec in specs for r in spec.referenceList.GetAddedOrExplicitItems()]
    expected = f"./{asset.file_of_look(contract.LOOK_LAYER)}"
    if expected not in [reference.assetPath for reference in references]:
        yield LOOK(f"expected a reference to @{expected}@", str(root.GetPath()))

    info = root.GetAssetInfo()
    identifier = getattr(info.get("identifier"), "path", "")
    if not identifier or info.get("name") != root.GetName():
        yield INFO(
            f"assetInfo has identifier {identifier!r} and name {info.get('name')!r}, "
            f"expected an identifier and the name {root.GetName()!r}",
            str(root.GetPath()),
        )
