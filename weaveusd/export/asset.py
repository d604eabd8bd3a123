"""Writes a whole asset into an empty folder: looks with textures, entry, MaterialX, origins."""

from __future__ import annotations

import filecmp
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from weaveusd.contract import (
    CHANNELS,
    LOBE_MAPS,
    MAX_YARNS,
    README_FILE,
    TEXTURE_DIR,
    entry_layer,
    lobe_file,
)
from weaveusd.export.entry import new_layer, write_entry
from weaveusd.export.exact import write_exact
from weaveusd.export.files import CLOTH_ITSELF, LookFiles
from weaveusd.export.glslfx import glslfx_text
from weaveusd.export.layers import define_prim
from weaveusd.export.lobe_maps import lobe_maps
from weaveusd.export.lobes import yarn_lobes
from weaveusd.export.look import define_look
from weaveusd.export.materialx import write_materialx
from weaveusd.export.moments import moment_files, moment_sums, write_moment_maps
from weaveusd.export.names import safe_name
from weaveusd.export.network_mitsuba import optics_of
from weaveusd.export.readme import readme_text
from weaveusd.export.standard import standard_shading
from weaveusd.export.textures import Progress, write_textures

if TYPE_CHECKING:
    from weaveusd.shading.material import ClothMaterial


def write_asset(
    material: ClothMaterial,
    folder: Path,
    *,
    colorways: Mapping[str, ClothMaterial] | None = None,
    previews: Mapping[str, Sequence[str]] | None = None,
    also: Collection[str] = (),
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
    colorways
        Cloths by the name of their variant, the first of them `material`, which is the default;
        their names are safe too. Each has a look layer of its own, and those of its textures
        that differ from the default's. None for a cloth without variants.
    previews
        Files of the pictures that will lie in `contract.PREVIEW_DIR`, by colorway or of "" where
        there are none, the first the thumbnail.
    also
        Networks on request: ``exact``, a MaterialX document with our own node, and ``glslfx``,
        our shader for Storm. Names of other doors are for the README's losses alone.
    jobs
        Threads that encode textures, by default one for each core.
    progress
        Told the share of the work done, 0…1.

    Raises
    ------
    ValueError
        The name, the folder, the number of yarns, a fit or a texture is not as stated.
    WeaveusdError
        A file could not be written.
    """
    looks = {"": material} if colorways is None else dict(colorways)
    _check(material, looks, folder)
    covers = []
    files = []
    for index, (colorway, cloth) in enumerate(looks.items()):
        at = CLOTH_ITSELF if index == 0 else LookFiles(colorway)
        share = _shared(progress, index, len(looks))
        covers.append(_write_textures(cloth, folder / at.folder, jobs, share))
        repainted = cloth.provenance.draft_wif != material.provenance.draft_wif
        files.append(replace(_without_twins(cloth, folder, at), own_draft=repainted))
        _write_look(cloth, folder, files[-1], covers[-1], glslfx="glslfx" in also)
        if "exact" in also:
            write_exact(cloth, folder, files[-1])
    entry = folder / entry_layer(material.name)
    names = () if colorways is None else tuple(colorways)
    write_entry(material.name, entry, dict(zip(names, files, strict=False)), previews)
    text = readme_text(material, covers[0], colorways, previews=previews, also=also)
    (folder / README_FILE).write_text(text, encoding="utf-8")
    return entry


def _check(material: ClothMaterial, looks: Mapping[str, ClothMaterial], folder: Path) -> None:
    for name in (material.name, *(colorway for colorway in looks if colorway)):
        if safe_name(name) != name:
            raise ValueError(f"{name!r} is no safe name, {safe_name(name)!r} is")
    if next(iter(looks.values()), None) is not material:
        raise ValueError("the first colorway is expected to be the material")
    if not folder.is_dir() or any(folder.iterdir()):
        raise ValueError(f"{folder}: expected an empty folder")
    for cloth in looks.values():
        if cloth.name != material.name:
            raise ValueError(f"a colorway is named {cloth.name!r}, expected {material.name!r}")
        _check_yarns(cloth)


def _check_yarns(material: ClothMaterial) -> None:
    yarns, fits = len(material.weave.yarns), material.fits
    counts = {yarns, len(material.normalization), len(fits.yarns)}
    if not 1 <= yarns <= MAX_YARNS or len(counts) > 1:
        raise ValueError(
            f"{yarns} yarns with {len(material.normalization)} normalizations and "
            f"{len(fits.yarns)} fits, expected 1 to {MAX_YARNS} with one each"
        )
    for fit in (fits.together, fits.isotropic, *fits.yarns, *fits.isotropic_yarns):
        standard_shading(fit)


def _shared(progress: Progress | None, index: int, count: int) -> Progress | None:
    """Return what tells `progress` of the look `index` of `count`."""
    if progress is None:
        return None
    return lambda share: progress((index + share) / count)


def _write_textures(
    material: ClothMaterial, folder: Path, jobs: int | None, progress: Progress | None
) -> float:
    """Write textures, moment and lobe maps into the new `folder`; return the mean opacity."""
    folder.mkdir()
    sums = moment_sums(material)
    with lobe_maps(material, folder) as add_lobes:
        cover = write_textures(
            material.textures,
            folder,
            yarn_lobes(material.fits),
            color_space=material.color_space,
            also=[add_lobes, sums.add],
            jobs=jobs,
            progress=progress,
        )
    write_moment_maps(sums.maps(), folder, material.textures.repeat_mm, material.color_space)
    return cover


def _without_twins(material: ClothMaterial, folder: Path, files: LookFiles) -> LookFiles:
    """Remove the textures of a colorway that are those of the default, and say which it keeps."""
    if not files.colorway:
        return files
    own = set()
    textures = (name for channel in CHANNELS.values() for name in channel.files)
    for file in (*textures, *map(lobe_file, LOBE_MAPS), *moment_files(material.weave)):
        path, twin = folder / files.folder / file, folder / TEXTURE_DIR / file
        if twin.exists() and filecmp.cmp(path, twin, shallow=False):
            path.unlink()
        else:
            own.add(file)
    if not own:
        (folder / files.folder).rmdir()
    return LookFiles(files.colorway, frozenset(own))


def _write_look(
    material: ClothMaterial, folder: Path, files: LookFiles, cover: float, *, glslfx: bool
) -> None:
    layer = new_layer(material.name)
    root = define_prim(layer, material.name, "Scope")
    define_look(root, material, cover, files, glslfx=glslfx)
    (folder / files.look).write_text(layer.ExportToString(), encoding="utf-8")
    write_materialx(material, folder / files.materialx, files)
    if glslfx:
        text = glslfx_text(optics_of(material))
        (folder / files.glslfx).write_text(text, encoding="utf-8")
    (folder / files.draft).write_bytes(material.provenance.draft_wif)
    (folder / files.recipe).write_bytes(material.provenance.recipe_toml)
