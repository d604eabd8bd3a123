"""What U3M 1.1 asks of a file, in our words, and a reader that finds what breaks it.

From the schema and the notes beside it (github.com/vizoogmbh/u3m, u3m1.1/spec).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

SHARES = {"alpha", "anisotropy_rotation", "metalness", "transmission"}
"""Inputs from 0 to 1."""

NUMBERS = SHARES | {
    "anisotropy_value", "clearcoat_value", "clearcoat_roughness", "displacement", "ior",
    "roughness", "sheen_value", "sheen_tint", "specular_value", "specular_tint",
    "subsurface_radius", "subsurface_value",
}  # fmt: skip
COLORS = {"basecolor", "subsurface_color"}
NORMALS = {"normal", "clearcoat_normal"}
BLENDS = {"add", "subtract", "multiply", "divide", "max", "min", "overlay"}
REPEATS = {"normal", "mirror_x", "mirror_y", "mirror_xy"}
CONSTRUCTIONS = {
    "unknown", "other", "Canvas", "Dobby", "Doubleweave", "Jacquard", "Oxford", "Plain weave",
    "Poplin", "Ripstop", "Satin", "Twill", "Twill - left hand (S)", "Twill - right hand (Z)",
}  # fmt: skip
"""Those of the enumeration that a woven cloth can be."""

FIBRES = {
    "unknown", "other", "Abaca", "Acetate", "Acrylic", "Alpaca", "Angora", "Aramid", "Camelhair",
    "Cashmere", "Cotton", "Cupro", "Elastane", "Hemp", "Jute", "Linen", "Lyocell", "Modacrylic",
    "Modal", "Mohair", "Nylon", "Polyamid", "Polyester", "Polyethylene", "Polypropylen", "Ramie",
    "Rayon", "Silk", "Spandex", "Triacetate", "Wool",
}  # fmt: skip

UUID4 = re.compile(r"[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}")
DEVICE = re.compile(r"(con|prn|aux|nul|clock\$|com[1-9]|lpt[1-9])(\.|$)", re.IGNORECASE)
FORBIDDEN = re.compile(r'[\x00-\x1f<>:"\\|$%]')
PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff")


def faults(document: Any, folder: Path) -> Iterator[str]:
    """Yield what breaks U3M 1.1 in `document`, whose pictures lie below `folder`."""
    yield from keys(document, "file", {"schema", "material", "custom"})
    if document["schema"] != "1.1":
        yield f"schema: {document['schema']}"
    material = document["material"]
    yield from keys(
        material, "material",
        {"id", "name", "description", "created", "modified", "front", "back", "side", "physics",
         "metadata"},
    )  # fmt: skip
    if not UUID4.fullmatch(material["id"]):
        yield f"id: {material['id']}"
    if not material["name"] or not isinstance(material["description"], str):
        yield "name or description"
    for key in ("created", "modified"):
        datetime.fromisoformat(material[key].replace("Z", "+00:00"))
    for side in ("front", "back", "side"):
        if material[side] is not None:
            yield from visualization(material[side], side, folder)
    if material["physics"] is not None:
        yield from physics(material["physics"])
    if not any(material[part] for part in ("front", "back", "side", "physics")):
        yield "neither pictures nor physics"


def keys(value: dict[str, Any], where: str, expected: set[str]) -> Iterator[str]:
    """Yield keys that are missing or unknown: the schema allows neither."""
    for key in sorted(set(value) ^ expected):
        yield f"{where}: {key} is {'unknown' if key in value else 'missing'}"


def visualization(look: dict[str, Any], where: str, folder: Path) -> Iterator[str]:
    yield from keys(look, where, NUMBERS | COLORS | NORMALS | {"shader", "preview"})
    if look["shader"] != "principled":
        yield f"{where}: shader {look['shader']}"
    for name in sorted(NUMBERS | COLORS | NORMALS):
        yield from keys(look[name], f"{where}.{name}", {"constant", "texture"})
        yield from constant(look[name]["constant"], name)
        texture = look[name]["texture"]
        if texture is not None:
            extra = {"mode", "factor"} if name in COLORS else {"scale"}
            extra = {"factor", "offset"} if name in NUMBERS else extra
            yield from keys(texture, f"{where}.{name}.texture", extra | {"image"})
            if name in COLORS and texture["mode"] not in BLENDS:
                yield f"{name}: mode {texture['mode']}"
            yield from image(texture["image"], name, folder)


def constant(value: Any, name: str) -> Iterator[str]:
    if name in NUMBERS:
        if type(value) is not float or (name in SHARES and not 0 <= value <= 1):
            yield f"{name}: constant {value}"
        return
    low = 0 if name in COLORS else -1
    yield from keys(value, name, set("rgb" if name in COLORS else "xyz"))
    if not all(type(v) is float and low <= v <= 1 for v in value.values()):
        yield f"{name}: constant {value}"


def image(picture: dict[str, Any], name: str, folder: Path) -> Iterator[str]:
    yield from keys(picture, name, {"path", "width", "height", "dpi", "repeat"})
    yield from keys(picture["dpi"], name, {"x", "y"})
    yield from keys(picture["repeat"], name, {"mode", "rotation"})
    if picture["repeat"]["mode"] not in REPEATS:
        yield f"{name}: repeat {picture['repeat']}"
    if min(picture["width"], picture["height"], *picture["dpi"].values()) <= 0:
        yield f"{name}: size {picture}"
    parts = picture["path"].split("/")
    if any(p in ("", ".", "..", "~") or p[-1] in ". " or DEVICE.match(p) for p in parts):
        yield f"{name}: path {picture['path']}"
    if FORBIDDEN.search(picture["path"]) or not picture["path"].endswith(PICTURES):
        yield f"{name}: path {picture['path']}"
    if not (folder / picture["path"]).is_file():
        yield f"{name}: no file {picture['path']}"


def physics(stated: dict[str, Any]) -> Iterator[str]:
    yield from keys(
        stated, "physics",
        {"thickness", "weight", "devices", "composition", "material_type", "construction"},
    )  # fmt: skip
    if not (stated["thickness"] >= 0 and stated["weight"] >= 0):
        yield "thickness or weight"
    if stated["devices"] != {"fab": "null"}:
        yield f"devices: {stated['devices']}"
    parts = stated["composition"]["parts"]
    if not parts or abs(sum(part["ratio"] for part in parts) - 1) > 1e-9:
        yield f"composition: {parts}"
    for part in parts:
        yield from keys(part, "part", {"ratio", "type", "name"})
        yield from named(part, FIBRES)
    yield from named(stated["material_type"], {"Woven"})
    yield from named(stated["construction"], CONSTRUCTIONS)


def named(value: dict[str, Any], known: set[str]) -> Iterator[str]:
    """Yield a type that is not known; `other` has a name, and nothing else has."""
    if value["type"] not in known or (value["type"] == "other") != isinstance(value["name"], str):
        yield f"{value}"
