"""The entry layer: the root of an asset, its identity, its colorways and its previews."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pxr import Sdf

from weaveusd.contract import COLORWAYS, LOOK_LAYER, PREVIEW_DIR
from weaveusd.export.layers import apply_schemas, define_prim

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles

PREVIEWS_API = "AssetPreviewsAPI"


def write_entry(
    name: str, path: Path, colorways: Mapping[str, LookFiles], previews: Sequence[str] = ()
) -> None:
    """Write the entry layer of the asset `name` as `path`.

    Its root references the look layer, or has a variant for each of `colorways` that references
    its own, the first being chosen. `previews` are names of pictures; the first is the thumbnail
    that UsdMediaAssetPreviewsAPI calls default, the others stand beside it under their names.
    """
    layer = new_layer(name)
    root = define_prim(layer, name, "Scope")
    if colorways:
        _define_variants(root, colorways)
    else:
        root.referenceList.prependedItems = [Sdf.Reference(f"./{LOOK_LAYER}")]
    info: dict[str, object] = {"identifier": Sdf.AssetPath(f"./{path.name}"), "name": name}
    if previews:
        apply_schemas(root, [PREVIEWS_API])
        info["previews"] = {
            "thumbnails": {
                ("default" if index == 0 else picture): {
                    "defaultImage": Sdf.AssetPath(f"./{PREVIEW_DIR}/{picture}.png")
                }
                for index, picture in enumerate(previews)
            }
        }
    root.assetInfo = info
    path.write_text(layer.ExportToString(), encoding="utf-8")


def new_layer(default_prim: str) -> Sdf.Layer:
    """Return a layer in metres, for texture coordinates are, with y up."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.defaultPrim = default_prim
    layer.pseudoRoot.SetInfo("metersPerUnit", 1.0)
    layer.pseudoRoot.SetInfo("upAxis", "Y")
    return layer


def _define_variants(root: Sdf.PrimSpec, colorways: Mapping[str, LookFiles]) -> None:
    variants = Sdf.VariantSetSpec(root, COLORWAYS)
    for colorway, files in colorways.items():
        spec = Sdf.VariantSpec(variants, colorway).primSpec
        spec.referenceList.prependedItems = [Sdf.Reference(f"./{files.look}")]
    root.variantSetNameList.prependedItems = [COLORWAYS]
    root.variantSelections[COLORWAYS] = next(iter(colorways))
