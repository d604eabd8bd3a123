"""The example scenes, and a scene dressed in a published cloth.

A scene that can be dressed holds a prim `/World/Cloth`; its meshes bind `/World/Cloth/Material`.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from pxr import Sdf, Usd, UsdGeom

from weaveusd import contract
from weaveusd.errors import InputError, StageError
from weaveusd.stage import open_stage

CLOTH_PATH = "/World/Cloth"
SUFFIXES = (".usda", ".usdc", ".usd")

_ROOT_METADATA = ("upAxis", "metersPerUnit", "kilogramsPerUnit", "defaultPrim", "startTimeCode",
                  "endTimeCode", "timeCodesPerSecond", "framesPerSecond")  # fmt: skip


def scenes_dir() -> Path:
    """Return the folder of the example scenes: inside an installed package, else the checkout.

    Raises
    ------
    StageError
        When neither exists.
    """
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "scenes", package.parent / "examples" / "stages"):
        if (folder / "cornell_drape.usda").is_file():
            return folder
    raise StageError(f"{package / 'scenes'}: the example scenes are not installed")


def scene_names() -> list[str]:
    """Return the names of the example scenes, sorted."""
    return sorted(path.stem for path in scenes_dir().glob("*.usda"))


def scene_path(name: str) -> Path:
    """Return the file of an example scene.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    if name not in scene_names():
        raise InputError(f"no scene '{name}': expected one of {', '.join(scene_names())}")
    return scenes_dir() / f"{name}.usda"


def dress(scene: Path, asset_entry: Path, output: Path, colorway: str = "") -> Path:
    """Write a layer in which `scene` wears the cloth of `asset_entry`; return its path.

    The layer sublayers the scene and references the asset's default prim on `/World/Cloth`, both
    by paths relative to `output`, so that the three can be moved together. It appears whole or
    not at all. `colorway` is the variant of the asset that is worn, "" for its own choice.

    Raises
    ------
    InputError
        When the output is no USD file name, its folder does not exist or it is one of the inputs,
        or the asset has no such colorway.
    StageError
        When the scene has no prim `/World/Cloth`, or the asset no material in its default prim.
    """
    _check_output(output, scene, asset_entry)
    stage = open_stage(scene)
    if not stage.GetPrimAtPath(CLOTH_PATH):
        raise StageError(f"{scene}: has no prim {CLOTH_PATH}, where a cloth is referenced")
    published = open_stage(asset_entry)  # a prim lives as long as its stage
    asset = published.GetDefaultPrim()
    if not asset or not asset.GetChild(contract.MATERIAL_NAME):
        raise StageError(
            f"{asset_entry}: has no {contract.MATERIAL_NAME} in its default prim, "
            "expected a published cloth"
        )
    known = asset.GetVariantSet(contract.COLORWAYS).GetVariantNames()
    if colorway and colorway not in known:
        raise InputError(
            f"{asset_entry}: has no colorway {colorway!r}, expected one of {', '.join(known[:64])}"
            if known
            else f"{asset_entry}: has no colorways, found {colorway!r}"
        )
    handle, part = tempfile.mkstemp(suffix=output.suffix, prefix=".dress-", dir=output.parent)
    os.close(handle)
    os.unlink(part)  # USD makes the file itself, with the rights of any new file
    try:
        _write(Path(part), stage, scene, asset_entry, colorway)
        os.replace(part, output)
    finally:
        if os.path.exists(part):
            os.unlink(part)
    return output


def _write(part: Path, stage: Usd.Stage, scene: Path, asset_entry: Path, colorway: str) -> None:
    """Write the layer as `part`, in the folder where it will stay."""
    layer = Sdf.Layer.CreateNew(str(part))
    # A sublayer's root metadata does not reach the stage: units and axis are said again.
    source = stage.GetRootLayer().pseudoRoot
    for name in _ROOT_METADATA:
        if source.HasInfo(name):
            layer.pseudoRoot.SetInfo(name, source.GetInfo(name))
    if not source.HasInfo("metersPerUnit"):
        layer.pseudoRoot.SetInfo("metersPerUnit", UsdGeom.GetStageMetersPerUnit(stage))
    layer.subLayerPaths.append(_anchored(scene, part.parent))
    spec = Sdf.CreatePrimInLayer(layer, CLOTH_PATH)
    spec.referenceList.prependedItems.append(Sdf.Reference(_anchored(asset_entry, part.parent)))
    if colorway:
        spec.variantSelections[contract.COLORWAYS] = colorway
    if not layer.Save():
        raise InputError(f"{part.parent}: cannot be written")


def _anchored(target: Path, folder: Path) -> str:
    """Return the path of `target` from `folder`, starting with ./ or ../ as USD wants it."""
    try:
        relative = Path(os.path.relpath(target.resolve(), folder.resolve())).as_posix()
    except ValueError:
        return target.resolve().as_posix()  # another drive has no way there
    return relative if relative.startswith("../") else f"./{relative}"


def _check_output(output: Path, *inputs: Path) -> None:
    if output.suffix not in SUFFIXES:
        raise InputError(f"{output}: ends in '{output.suffix}', expected {', '.join(SUFFIXES)}")
    if not output.parent.is_dir():
        raise InputError(f"{output}: the folder {output.parent} does not exist")
    for given in inputs:
        if output.resolve() == given.resolve():
            raise InputError(f"{output}: would replace its own input")
