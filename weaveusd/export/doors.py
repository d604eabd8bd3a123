"""Other doors to a cloth: the same textures in the formats of other programs.

Each is made from the files of an asset that has been written, and lies beside them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from weaveusd.contract import GLTF_SUFFIX, U3M_SUFFIX, USDZ_SUFFIX, entry_layer, of_colorway
from weaveusd.export.files import CLOTH_ITSELF, LookFiles
from weaveusd.export.gltf import write_gltf
from weaveusd.export.panel import panel_size_mm
from weaveusd.export.tx import write_tx
from weaveusd.export.u3m import write_u3m
from weaveusd.export.usdz import write_usdz

if TYPE_CHECKING:
    from weaveusd.contract import Door
    from weaveusd.shading.material import ClothMaterial


def write_doors(
    material: ClothMaterial,
    folder: Path,
    doors: Collection[Door],
    *,
    colorways: Mapping[str, ClothMaterial] | None = None,
) -> None:
    """Write `doors` of the asset that `write_asset` has written into `folder`.

    `material` and `colorways` are what it was written from. Each colorway has files of its own.
    The same asset gives the same bytes.

    Raises
    ------
    InputError
        A file of the asset is missing or broken.
    WeaveusdError
        A file would be larger than its format can be, or could not be written.
    """
    for cloth, files in _looks(material, folder, colorways):
        if "tx" in doors:
            write_tx(folder, files)
        if "gltf" in doors:
            name = of_colorway(f"{material.name}{GLTF_SUFFIX}", files.colorway)
            write_gltf(cloth, folder, files, folder / name)
        if "u3m" in doors:
            name = of_colorway(f"{material.name}{U3M_SUFFIX}", files.colorway)
            write_u3m(cloth, folder, files, folder / name)
        if "usdz" in doors:
            name = of_colorway(f"{material.name}{USDZ_SUFFIX}", files.colorway)
            size_mm = panel_size_mm(cloth.weave.repeat_mm)
            entry = folder / entry_layer(material.name)
            write_usdz(entry, folder / name, size_mm, files.colorway)


def _looks(
    material: ClothMaterial, folder: Path, colorways: Mapping[str, ClothMaterial] | None
) -> Iterator[tuple[ClothMaterial, LookFiles]]:
    """Yield the cloth itself and its other colorways, each with where its files are."""
    yield material, CLOTH_ITSELF
    for name, cloth in list((colorways or {}).items())[1:]:
        own = folder / LookFiles(name).folder
        textures = (path.name for path in own.iterdir()) if own.is_dir() else ()
        yield cloth, LookFiles(name, frozenset(textures))
