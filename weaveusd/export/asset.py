"""Writes a whole asset into an empty folder: textures, look, entry, MaterialX, draft."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pxr import Sdf

from weaveusd.contract import (
    DRAFT_FILE,
    LOOK_LAYER,
    MATERIALX_FILE,
    MAX_YARNS,
    TEXTURE_DIR,
    entry_layer,
)
from weaveusd.export.layers import define_prim
from weaveusd.export.look import define_look
from weaveusd.export.materialx import write_materialx
from weaveusd.export.names import safe_name
from weaveusd.export.standard import standard_shading
from weaveusd.export.textures import Progress, write_textures

if TYPE_CHECKING:
    from weaveusd.shading.material import ClothMaterial


def write_asset(
    material: ClothMaterial,
    folder: Path,
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Path:
    """Write the asset of `material` into the empty `folder` and return its entry layer.

    The entry layer references the look layer, which holds the material with its networks. All
    paths are anchored with ``./`` and stay in `folder`, so that the asset can be moved. The
    same material gives the same bytes; the number of the version appears in no file, since
    content decides whether there is a new version.

    Parameters
    ----------
    material
        Cloth to write; its name is one that `safe_name` returned.
    folder
        Existing folder without files.
    jobs
        Threads that encode textures, by default one for each core.
    progress
        Told the share of the work done, 0…1.

    Raises
    ------
    ValueError
        The name, the folder, the number of yarns, the fit or a texture is not as stated.
    WeaveusdError
        A file could not be written.
    """
    _check(material, folder)
    textures = folder / TEXTURE_DIR
    textures.mkdir()
    shadings = [standard_shading(fit) for fit in material.fits.yarns]
    per_yarn = {
        "roughness": [shading.openpbr_roughness for shading in shadings],
        "anisotropy": [shading.openpbr_anisotropy for shading in shadings],
    }
    cover = write_textures(
        material.textures,
        textures,
        per_yarn,
        color_space=material.color_space,
        jobs=jobs,
        progress=progress,
    )
    _write_look(material, folder / LOOK_LAYER, cover)
    entry = folder / entry_layer(material.name)
    _write_entry(material.name, entry)
    write_materialx(material, folder / MATERIALX_FILE)
    (folder / DRAFT_FILE).write_bytes(material.provenance.draft_wif)
    return entry


def _check(material: ClothMaterial, folder: Path) -> None:
    if safe_name(material.name) != material.name:
        raise ValueError(f"{material.name!r} is no safe name, {safe_name(material.name)!r} is")
    if not folder.is_dir() or any(folder.iterdir()):
        raise ValueError(f"{folder}: expected an empty folder")
    yarns = len(material.weave.yarns)
    fits = material.fits
    counts = {yarns, len(material.normalization), len(fits.yarns)}
    if not 1 <= yarns <= MAX_YARNS or len(counts) > 1:
        raise ValueError(
            f"{yarns} yarns with {len(material.normalization)} normalizations and "
            f"{len(fits.yarns)} fits, expected 1 to {MAX_YARNS} with one each"
        )
    for fit in (fits.together, fits.isotropic, *fits.yarns):
        standard_shading(fit)


def _write_look(material: ClothMaterial, path: Path, cover: float) -> None:
    layer = _new_layer(material.name)
    define_look(define_prim(layer, material.name, "Scope"), material, cover)
    path.write_text(layer.ExportToString(), encoding="utf-8")


def _write_entry(name: str, path: Path) -> None:
    layer = _new_layer(name)
    root = define_prim(layer, name, "Scope")
    root.referenceList.prependedItems = [Sdf.Reference(f"./{LOOK_LAYER}")]
    root.assetInfo = {"identifier": Sdf.AssetPath(f"./{path.name}"), "name": name}
    path.write_text(layer.ExportToString(), encoding="utf-8")


def _new_layer(default_prim: str) -> Sdf.Layer:
    """Return a layer in metres, for texture coordinates are, with y up."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.defaultPrim = default_prim
    layer.pseudoRoot.SetInfo("metersPerUnit", 1.0)
    layer.pseudoRoot.SetInfo("upAxis", "Y")
    return layer
