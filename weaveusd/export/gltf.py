"""A binary glTF: a flat panel of the cloth, for viewers on the web and in offices.

What glTF 2.0 knows of a cloth: color, normals, occlusion, a rough dielectric that is anisotropic
across the fibre (KHR_materials_anisotropy), and gaps that are cut out.
"""

from __future__ import annotations

import json
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from weaveusd._version import __version__
from weaveusd.errors import WeaveusdError
from weaveusd.export.attributes import tidy
from weaveusd.export.gltf_pictures import (
    ANISOTROPY,
    BASE_COLOR,
    NORMAL,
    SURFACE,
    Pictures,
    write_pictures,
)
from weaveusd.export.panel import panel_corners, panel_size_mm
from weaveusd.export.standard import standard_shading

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles
    from weaveusd.shading.material import ClothMaterial

MAX_BYTES = (1 << 32) - 1
"""Size of a binary glTF: lengths in it have 32 bits."""

_FLOAT, _SHORT = 5126, 5123
_VERTICES, _INDICES = 34962, 34963
_LINEAR, _LINEAR_MIPMAP, _REPEAT = 9729, 9987, 10497


def write_gltf(material: ClothMaterial, asset: Path, files: LookFiles, path: Path) -> None:
    """Write the look `files` of the asset in folder `asset` as the new binary glTF `path`.

    The panel is of whole repeats, near 100 mm, in the plane of x and y, in metres. Texture
    coordinates are metres from its upper left corner, v down; KHR_texture_transform turns them
    into repeats. The same asset gives the same bytes.

    Raises
    ------
    InputError
        A texture is missing or broken.
    WeaveusdError
        The pictures are too large together, or the disk refused.
    """
    with tempfile.TemporaryDirectory(prefix="weaveusd-") as folder:
        pictures = write_pictures(asset, files, material.fits.yarns, Path(folder))
        geometry = _geometry(panel_size_mm(material.weave.repeat_mm))
        document = _document(material, pictures, geometry)
        try:
            with path.open("xb") as out:
                _write(out, document, [*geometry.values()], [*pictures.files.values()])
        except OSError as error:
            raise WeaveusdError(f"{error.filename or path}: {error.strerror or error}") from error


def _geometry(size_mm: tuple[float, float]) -> dict[str, Any]:
    """Return the arrays of the panel by the names of their attributes, and its indices."""
    corners = np.array(panel_corners(size_mm))
    left, top = corners[3]
    return {
        "POSITION": np.pad(corners, ((0, 0), (0, 1))).astype("<f4"),
        "NORMAL": np.tile(np.array([0, 0, 1], "<f4"), (4, 1)),
        "TANGENT": np.tile(np.array([1, 0, 0, 1], "<f4"), (4, 1)),
        "TEXCOORD_0": np.abs(corners - (left, top)).astype("<f4"),
        "indices": np.array([0, 1, 2, 0, 2, 3], "<u2"),
    }


def _document(
    material: ClothMaterial, pictures: Pictures, geometry: dict[str, Any]
) -> dict[str, Any]:
    """Return the JSON of the file; buffer views are the arrays of `geometry`, then pictures."""
    names = list(geometry)
    sizes = [array.nbytes for array in geometry.values()]
    sizes += [path.stat().st_size for path in pictures.files.values()]
    starts = [sum(_padded(size) for size in sizes[:index]) for index in range(len(sizes))]
    views: list[dict[str, Any]] = [
        {"buffer": 0, "byteOffset": start, "byteLength": size}
        for start, size in zip(starts, sizes, strict=True)
    ]
    for view, name in zip(views, names, strict=False):
        view["target"] = _INDICES if name == "indices" else _VERTICES
    primitive = {
        "attributes": {name: index for index, name in enumerate(names) if name != "indices"},
        "indices": names.index("indices"),
        "material": 0,
    }
    return {
        "asset": {"version": "2.0", "generator": f"weaveusd {__version__}"},
        "extensionsUsed": [
            "KHR_materials_anisotropy", "KHR_materials_ior", "KHR_texture_transform"
        ],
        "extensionsRequired": ["KHR_texture_transform"],
        "scene": 0,
        "scenes": [{"name": material.name, "nodes": [0]}],
        "nodes": [{"name": material.name, "mesh": 0}],
        "meshes": [{"name": "Panel", "primitives": [primitive]}],
        "materials": [_material(material, [*pictures.files], cover=pictures.cover)],
        "textures": [{"sampler": 0, "source": index} for index in range(len(pictures.files))],
        "samplers": [{
            "magFilter": _LINEAR, "minFilter": _LINEAR_MIPMAP, "wrapS": _REPEAT, "wrapT": _REPEAT,
        }],
        "images": [
            {"name": name, "mimeType": "image/png", "bufferView": len(names) + index}
            for index, name in enumerate(pictures.files)
        ],
        "accessors": [_accessor(index, *item) for index, item in enumerate(geometry.items())],
        "bufferViews": views,
        "buffers": [{"byteLength": starts[-1] + _padded(sizes[-1])}],
    }  # fmt: skip


def _accessor(view: int, name: str, array: Any) -> dict[str, Any]:
    kinds = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
    accessor: dict[str, Any] = {
        "bufferView": view,
        "componentType": _SHORT if name == "indices" else _FLOAT,
        "count": len(array),
        "type": kinds[1 if array.ndim == 1 else array.shape[1]],
    }
    if name == "POSITION":
        accessor |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
    return accessor


def _material(material: ClothMaterial, pictures: list[str], *, cover: float) -> dict[str, Any]:
    shading = standard_shading(material.fits.yarns[0])
    scale = [tidy(1000 / length) for length in material.weave.repeat_mm]

    def texture(name: str) -> dict[str, Any]:
        return {
            "index": pictures.index(name),
            "extensions": {"KHR_texture_transform": {"scale": scale}},
        }

    # Half of the mean: from afar, where a texel is the mean of many, an open cloth stays there.
    mask = {"alphaMode": "MASK", "alphaCutoff": round(cover / 2, 3)} if cover < 1 else {}
    return {
        "name": material.name,
        "doubleSided": True,
        **mask,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*[tidy(shading.base)] * 3, 1.0],
            "baseColorTexture": texture(BASE_COLOR),
            "metallicFactor": 0.0,
            "metallicRoughnessTexture": texture(SURFACE),
        },
        "normalTexture": texture(NORMAL),
        "occlusionTexture": texture(SURFACE),
        "extensions": {
            "KHR_materials_anisotropy": {
                "anisotropyStrength": 1.0,
                "anisotropyTexture": texture(ANISOTROPY),
            },
            "KHR_materials_ior": {"ior": tidy(shading.ior)},
        },
    }


def _write(out: BinaryIO, document: dict[str, Any], arrays: list[Any], files: list[Path]) -> None:
    """Write the header, the chunk of JSON and that of `arrays` and `files`, each padded to 4."""
    text = json.dumps(document, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (_padded(len(text)) - len(text))
    length = document["buffers"][0]["byteLength"]
    total = 12 + 8 + len(text) + 8 + length
    if total > MAX_BYTES:
        raise WeaveusdError(
            f"{out.name}: {total} bytes of pictures, expected at most {MAX_BYTES} in a binary "
            "glTF; a lower resolution has less"
        )
    out.write(b"glTF" + (2).to_bytes(4, "little") + total.to_bytes(4, "little"))
    out.write(len(text).to_bytes(4, "little") + b"JSON" + text)
    out.write(length.to_bytes(4, "little") + b"BIN\0")
    for array in arrays:
        out.write(array.tobytes() + bytes(_padded(array.nbytes) - array.nbytes))
    for path in files:
        with path.open("rb") as source:
            shutil.copyfileobj(source, out, 1 << 20)
        size = path.stat().st_size
        out.write(bytes(_padded(size) - size))


def _padded(size: int) -> int:
    return size + -size % 4
