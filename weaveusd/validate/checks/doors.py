"""Whether a usdz, a glTF and a U3M beside the asset are whole, and of this cloth."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from weaveusd.contract import GLTF_SUFFIX, U3M_SUFFIX, USDZ_SUFFIX, of_colorway
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

BROKEN = Code("door-broken", Status.FAIL, "A usdz, glTF or U3M is not of its format.")
OTHER = Code("door-disagrees", Status.FAIL, "A usdz, glTF or U3M is not of this cloth.")

ALIGNMENT = 64
MAX_JSON = 4 << 20
"""Bytes of a document that is read."""

MAX_ENTRIES = 4096
"""Files in a package that are looked at."""

SLACK = 1e-6
"""Relative difference between two statements of a length."""

_FAULTS = (
    ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RuntimeError, OSError,
    zipfile.BadZipFile,
)  # fmt: skip
"""What a file of another form can raise where it is read as if it were of its own."""

_PIECE = 1 << 20
_LOCAL_HEADER = 30


@check(
    id="door/files",
    why="Who gets the one file sees nothing of the asset that it was made from.",
    needs=("material",),
    codes=(BROKEN, OTHER),
)
def other_doors(asset: OpenAsset) -> Iterator[Finding]:
    """Every usdz, glTF and U3M beside the asset is whole, with its textures and its size."""
    for suffix, judge in ((USDZ_SUFFIX, _usdz), (GLTF_SUFFIX, _gltf), (U3M_SUFFIX, _u3m)):
        path = asset.folder / of_colorway(f"{asset.entry.stem}{suffix}", asset.colorway)
        if not path.is_file():
            continue
        try:
            for message in judge(path, asset):
                yield OTHER(message, path.name)
        except _FAULTS as error:
            yield BROKEN(" ".join(f"{error}".split())[:200] or type(error).__name__, path.name)


def _usdz(path: Path, asset: OpenAsset) -> Iterator[str]:
    """Yield how the pictures in a package differ from those beside it."""
    with zipfile.ZipFile(path) as archive:
        entries = archive.infolist()[:MAX_ENTRIES]
        if not entries or not entries[0].filename.endswith((".usdc", ".usda", ".usd")):
            raise ValueError("its first file is no layer")
        for entry in entries:
            if entry.compress_type != zipfile.ZIP_STORED:
                raise ValueError(f"{entry.filename} is compressed, expected it to be stored")
            if (start := _start(path, entry)) % ALIGNMENT:
                raise ValueError(f"{entry.filename} begins at {start}, expected a multiple of 64")
        with archive.open(entries[0]) as layer:
            # To its end, where the checksum is compared.
            while layer.read(_PIECE):
                pass
        for entry in entries[1:]:
            beside = asset.folder / entry.filename
            if ".." in Path(entry.filename).parts or not beside.is_file():
                yield f"{entry.filename} is not beside it"
            elif not _same(archive, entry, beside):
                yield f"{entry.filename} is not the one beside it"


def _start(path: Path, entry: zipfile.ZipInfo) -> int:
    """Return where the content of `entry` begins, by its own header."""
    with path.open("rb") as file:
        file.seek(entry.header_offset)
        header = file.read(_LOCAL_HEADER)
    lengths = (int.from_bytes(header[at : at + 2], "little") for at in (26, 28))
    return entry.header_offset + _LOCAL_HEADER + sum(lengths)


def _same(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, beside: Path) -> bool:
    if entry.file_size != beside.stat().st_size:
        return False
    with archive.open(entry) as packed, beside.open("rb") as file:
        while piece := file.read(_PIECE):
            if packed.read(len(piece)) != piece:
                return False
    return True


def _gltf(path: Path, asset: OpenAsset) -> Iterator[str]:
    """Yield how the size of the texture differs from the cloth's."""
    with path.open("rb") as file:
        head = file.read(20)
        stated, length = (int.from_bytes(head[at : at + 4], "little") for at in (8, 12))
        if head[:4] != b"glTF" or head[16:] != b"JSON" or length > MAX_JSON:
            raise ValueError("is no binary glTF")
        document = json.loads(file.read(length))
    if stated != path.stat().st_size:
        raise ValueError(f"has {path.stat().st_size} bytes, its header says {stated}")
    texture = document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
    across, along = texture["extensions"]["KHR_texture_transform"]["scale"]
    yield from _sizes((1000 / across, 1000 / along), asset)


def _u3m(path: Path, asset: OpenAsset) -> Iterator[str]:
    """Yield pictures that are not there, and how their size differs from the cloth's."""
    if path.stat().st_size > MAX_JSON:
        raise ValueError(f"expected at most {MAX_JSON} bytes")
    front = json.loads(path.read_text(encoding="utf-8"))["material"]["front"]
    textures = [v["texture"] for v in front.values() if isinstance(v, dict)]
    images: list[Any] = [texture["image"] for texture in textures if texture]
    for image in images:
        name = Path(image["path"])
        if name.is_absolute() or ".." in name.parts or not (asset.folder / name).is_file():
            yield f"{str(name)[:80]!r} is no picture of the asset"
    if images:
        yield from _sizes((float(images[0]["width"]), float(images[0]["height"])), asset)


def _sizes(found: tuple[float, float], asset: OpenAsset) -> Iterator[str]:
    for length, name in zip(found, ("repeatWidth", "repeatHeight"), strict=True):
        stated = asset.cloth(name)
        if stated is not None and not abs(length - stated) <= SLACK * stated:
            yield f"one texture is {length:.6g} mm, weave:{name} says {stated:.6g}"
