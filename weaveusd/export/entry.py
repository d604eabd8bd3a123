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
    name: str,
    path: Path,
    colorways: Mapping[str, LookFiles],
    previews: Mapping[str, Sequence[str]] | None = None,
) -> None:
    """Write the entry layer of the asset `name` as `path`.

    Its root references the look layer, or has a variant for each of `colorways` that references
    its own, the first being chosen. `previews` are files of pictures by colorway, of "" where
    there are none; the first is the thumbnail that UsdMediaAssetPreviewsAPI calls default, that of
    the variant chosen, and the others stand beside it under their names.
    """
    pictures = previews or {}
    layer = new_layer(name)
    root = define_prim(layer, name, "Scope")
    if colorways:
        _define_variants(root, colorways, pictures)
    else:
        root.referenceList.prependedItems = [Sdf.Reference(f"./{LOOK_LAYER}")]
    if pictures:
        apply_schemas(root, [PREVIEWS_API])
    identity = {"identifier": Sdf.AssetPath(f"./{path.name}"), "name": name}
    root.assetInfo = identity | _previews(pictures.get("", ()))
    path.write_text(layer.ExportToString(), encoding="utf-8")


def new_layer(default_prim: str) -> Sdf.Layer:
    """Return a layer in metres, for texture coordinates are, with y up."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.defaultPrim = default_prim
    layer.pseudoRoot.SetInfo("metersPerUnit", 1.0)
    layer.pseudoRoot.SetInfo("upAxis", "Y")
    return layer


def _previews(files: Sequence[str]) -> dict[str, object]:
    """Return what an asset's information says of its pictures; nothing where there is none."""
    thumbnails = {
        ("default" if index == 0 else file.partition(".")[0]): {
            "defaultImage": Sdf.AssetPath(f"./{PREVIEW_DIR}/{file}")
        }
        for index, file in enumerate(files)
    }
    return {"previews": {"thumbnails": thumbnails}} if thumbnails else {}


def _define_variants(
    root: Sdf.PrimSpec,
    colorways: Mapping[str, LookFiles],
    pictures: Mapping[str, Sequence[str]],
) -> None:
    variants = Sdf.VariantSetSpec(root, COLORWAYS)
    for colorway, files in colorways.items():
        spec = Sdf.VariantSpec(variants, colorway).primSpec
        spec.referenceList.prependedItems = [Sdf.Reference(f"./{files.look}")]
        if colorway in pictures:
            spec.assetInfo = _previews(pictures[colorway])
    root.variantSetNameList.prependedItems = [COLORWAYS]
    root.variantSelections[COLORWAYS] = next(iter(colorways))
