"""A U3M 1.1 material: the cloth for programs that drape and cut garments.

U3M is Vizoo's and Browzwear's open format: a JSON file beside pictures of a known size in mm,
with the parameters of the principled shader and what the cloth weighs and is made of.
"""

from __future__ import annotations

import hashlib
import json
import uuid
from pathlib import Path
from typing import TYPE_CHECKING, Any

from weaveusd.contract import CHANNELS, U3M_DIR, of_colorway
from weaveusd.errors import WeaveusdError
from weaveusd.export.attributes import tidy
from weaveusd.export.bands import size_of
from weaveusd.export.images import INCH_MM
from weaveusd.export.standard import standard_shading
from weaveusd.export.u3m_physics import physics
from weaveusd.export.u3m_pictures import ALPHA, MAPS, Means, Triple, write_maps
from weaveusd.yarn.color import srgb_from_linear

if TYPE_CHECKING:
    from weaveusd.export.files import LookFiles
    from weaveusd.shading.material import ClothMaterial

SCHEMA = "1.1"
TIME = "2000-01-01T00:00:00Z"
"""When every material was made: a date of its own would make the same cloth another file."""

SPECULAR_RANGE = 0.08
"""Reflectance at normal incidence that a `specular_value` of 1 stands for."""

_NOTHING = (
    "clearcoat_value", "clearcoat_roughness", "metalness", "displacement", "sheen_value",
    "sheen_tint", "specular_tint", "subsurface_radius", "subsurface_value", "transmission",
)  # fmt: skip


def write_u3m(material: ClothMaterial, asset: Path, files: LookFiles, path: Path) -> None:
    """Write the look `files` of the asset in folder `asset` as the new U3M file `path`.

    Base color and normals are those of the asset's textures, the other maps go to the folder
    `contract.U3M_DIR` beside them. The back is as the front, which U3M says by null. The id is
    a UUID made of the content: the same asset gives the same bytes.

    Raises
    ------
    InputError
        A texture is missing or broken.
    WeaveusdError
        A map or the file could not be written.
    """
    folder = asset / U3M_DIR
    folder.mkdir(exist_ok=True)
    maps = {name: folder / of_colorway(f"{name}.png", files.colorway) for name in MAPS}
    means = write_maps(asset, files, material.fits.yarns, material.weave.repeat_mm, maps)
    pictures = {name: map_path.relative_to(asset).as_posix() for name, map_path in maps.items()}
    for channel in ("base_color", "normal"):
        pictures[channel] = files.texture(CHANNELS[channel].files[0])
    content: dict[str, Any] = {
        "name": material.name,
        "description": _description(material),
        "created": TIME,
        "modified": TIME,
        "front": _front(material, pictures, means, size_of(maps[ALPHA])),
        "back": None,
        "side": None,
        "physics": physics(material.weave, material.provenance.shafts),
        "metadata": None,
    }
    content["id"] = _identity(content, [asset / name for name in pictures.values()])
    document = {"schema": SCHEMA, "custom": None, "material": content}
    try:
        with path.open("x", encoding="utf-8") as out:
            out.write(json.dumps(document, indent=2, sort_keys=True, ensure_ascii=False) + "\n")
    except OSError as error:
        raise WeaveusdError(f"{path}: {error.strerror or error}") from error


def _description(material: ClothMaterial) -> str:
    source = material.provenance
    return f"{source.draft_title or material.name}, woven of {source.recipe}"


def _front(
    material: ClothMaterial, pictures: dict[str, str], means: Means, texels: tuple[int, int]
) -> dict[str, Any]:
    """Return the visualization of the face: a constant and a texture for each input."""
    shading = standard_shading(material.fits.yarns[0])
    width, height = material.weave.repeat_mm

    def image(name: str) -> dict[str, Any]:
        return {
            "path": pictures[name],
            "width": tidy(width),
            "height": tidy(height),
            "dpi": {
                "x": tidy(texels[0] / width * INCH_MM),
                "y": tidy(texels[1] / height * INCH_MM),
            },
            "repeat": {"mode": "normal", "rotation": 0.0},
        }

    def scalar(name: str) -> dict[str, Any]:
        texture = {"factor": 1.0, "offset": 0.0, "image": image(name)}
        return {"constant": means.numbers[name], "texture": texture}

    base = tidy(shading.base)
    whole = means.numbers[ALPHA] == 1
    return {
        **{name: _constant(0.0) for name in _NOTHING},
        **{name: scalar(name) for name in MAPS},
        "alpha": _constant(1.0) if whole else scalar(ALPHA),
        "basecolor": {
            "constant": _rgb(*srgb_from_linear(_scaled(means.color, base))),
            "texture": {
                "mode": "multiply", "factor": _rgb(base, base, base), "image": image("base_color")
            },
        },
        "normal": {
            "constant": _xyz(*means.normal),
            "texture": {"scale": 1.0, "image": image("normal")},
        },
        "clearcoat_normal": _constant(_xyz(0.0, 0.0, 1.0)),
        "subsurface_color": _constant(_rgb(1.0, 1.0, 1.0)),
        "ior": _constant(tidy(shading.ior)),
        "specular_value": _constant(tidy(material.fits.yarns[0].f0 / SPECULAR_RANGE)),
        "shader": "principled",
        "preview": None,
    }  # fmt: skip


def _constant(value: Any) -> dict[str, Any]:
    return {"constant": value, "texture": None}


def _scaled(color: Triple, factor: float) -> Triple:
    red, green, blue = (factor * component for component in color)
    return red, green, blue


def _rgb(red: float, green: float, blue: float) -> dict[str, float]:
    return {"r": round(red, 6), "g": round(green, 6), "b": round(blue, 6)}


def _xyz(x: float, y: float, z: float) -> dict[str, float]:
    return {"x": x, "y": y, "z": z}


def _identity(content: dict[str, Any], pictures: list[Path]) -> str:
    """Return a UUID of version 4 whose bits are the digest of the material and its pictures."""
    digest = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    for picture in pictures:
        with picture.open("rb") as file:
            while piece := file.read(1 << 20):
                digest.update(piece)
    return str(uuid.UUID(bytes=digest.digest()[:16], version=4))
