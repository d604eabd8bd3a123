"""A usdz package: the whole asset in one file that opens from anywhere.

One flattened layer and the pictures it names, stored without compression and aligned to 64
bytes, as USD's file format asks for so that a reader can map the file.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from pxr import Sdf, Usd, UsdShade, UsdUtils

from weaveusd.contract import COLORWAYS
from weaveusd.export.package import write_package
from weaveusd.export.panel import define_panel
from weaveusd.stage import open_stage

PICTURES = (".png", ".exr", ".jpg", ".jpeg", ".avif")
"""Suffixes that the format allows for images; a package holds nothing else beside its layer."""


def write_usdz(
    entry: Path, package: Path, panel_mm: tuple[float, float], colorway: str = ""
) -> None:
    """Write the asset whose entry layer is `entry` into the new file `package`.

    The layer is the composed stage, binary, with the selected variants, or the `colorway` that is
    named: not every viewer knows variants. Beside the asset, outside the default prim, stands a
    panel of `panel_mm` that wears it, so that a viewer has something to show and a reference
    brings the material alone. What a package may not hold is left out: the paths of the draft and
    the recipe, and networks whose source is a file. Inputs that take a value from the material
    state it too, for readers that follow no connection to it. The same asset gives the same bytes.

    Raises
    ------
    StageError
        `entry` is no stage.
    WeaveusdError
        A picture is missing, all are too large together, or the disk refused.
    """
    stage = open_stage(entry)
    if colorway:
        with Usd.EditContext(stage, stage.GetSessionLayer()):
            stage.GetDefaultPrim().GetVariantSet(COLORWAYS).SetVariantSelection(colorway)
    layer = _flattened(stage)
    root = Path(f"{package.stem}.usdc")
    layer.GetPrimAtPath(f"/{layer.defaultPrim}").assetInfo["identifier"] = Sdf.AssetPath(
        f"./{root}"
    )
    define_panel(layer, panel_mm)
    pictures = _relative_pictures(layer, entry.parent)
    with tempfile.TemporaryDirectory(prefix="weaveusd-") as made:
        folder = Path(made)
        layer.Export(f"{folder}/{root}")
        write_package(
            package, [(root.name, folder / root), *((n, entry.parent / n) for n in pictures)]
        )


def _flattened(stage: Usd.Stage) -> Sdf.Layer:
    """Return what `stage` composes to as a layer, without what cannot be packed."""
    flat = Usd.Stage.Open(stage.Flatten(addSourceFileComment=False))
    for prim in list(flat.TraverseAll()):
        for attribute in prim.GetAuthoredAttributes():
            if _stays_outside(attribute.Get()):
                if prim.IsA(UsdShade.Shader):
                    _remove_shader(flat, prim)
                    break
                prim.RemoveProperty(attribute.GetName())
    for prim in flat.TraverseAll():
        for attribute in prim.GetAuthoredAttributes():
            _state_value(flat, attribute)
    layer: Sdf.Layer = flat.GetRootLayer()
    return layer


def _stays_outside(value: object) -> bool:
    return isinstance(value, Sdf.AssetPath) and not value.path.lower().endswith(PICTURES)


def _remove_shader(stage: Usd.Stage, shader: Usd.Prim) -> None:
    """Remove `shader` and every output of its material that is connected to it."""
    path, material = shader.GetPath(), shader.GetParent()
    for attribute in material.GetAuthoredAttributes():
        if any(source.HasPrefix(path) for source in attribute.GetConnections()):
            material.RemoveProperty(attribute.GetName())
    stage.RemovePrim(path)


def _state_value(stage: Usd.Stage, attribute: Usd.Attribute) -> None:
    """Give an attribute that is connected to an input of its material the value of that."""
    for source in attribute.GetConnections():
        value = stage.GetAttributeAtPath(source).Get()
        if value is not None:
            attribute.Set(value)


def _relative_pictures(layer: Sdf.Layer, folder: Path) -> list[str]:
    """Make every path in `layer` relative to `folder`, and return those of pictures, sorted."""
    found: set[str] = set()

    def relative(path: str) -> str:
        file = Path(path)
        if not file.is_absolute():
            return path
        name = file.relative_to(folder.absolute()).as_posix()
        found.add(name)
        return f"./{name}"

    UsdUtils.ModifyAssetPaths(layer, relative)
    return sorted(found)
