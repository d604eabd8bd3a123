"""What a report shows of an asset beside findings, as JSON types, from its files alone."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from weaveusd.contract import (
    CLOTH_ATTRIBUTES,
    DRAFT_FILE,
    MANIFEST_FILE,
    README_FILE,
    YARN_ATTRIBUTES,
)
from weaveusd.errors import InputError, WeaveusdError
from weaveusd.validate.checks.energy import yarn_optics_of
from weaveusd.validate.drafts import read_draft
from weaveusd.validate.integrity import MAX_BYTES
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.report.channels import channel_pictures
from weaveusd.validate.report.drape import drape_picture
from weaveusd.validate.report.drawings import draft_svg, lobe_svg
from weaveusd.validate.report.moments import moment_pictures

MAX_TEXT = 20_000
"""Characters of the asset's own page that are shown."""

MAX_LOBES = 12
"""Yarns whose lobes are drawn; the table has them all."""

TOLD = ("Origin", "Weave", "Size", "Textures")


def gather(asset: OpenAsset) -> dict[str, Any]:
    """Return everything that `weaveusd.validate.report.page` shows of `asset`.

    A part that the asset is too broken for is left out, with its reason under `absent`.
    """
    absent: dict[str, str] = {}

    def part(name: str, make: Callable[[], Any], empty: Any) -> Any:
        try:
            return make()
        except (WeaveusdError, OSError, ValueError, TypeError, KeyError) as error:
            absent[name] = " ".join(str(error).split())[:300]
            return empty

    exhibits = list(asset.shown.values())
    exhibits += part("channels", lambda: channel_pictures(asset), [])
    exhibits += part("moment maps", lambda: moment_pictures(asset), [])
    if any(exhibit.group == "Renders" for exhibit in exhibits):
        exhibits += part("drape", lambda: drape_picture(asset), [])
    return {
        "name": str(asset.root.GetName()) if asset.root else asset.entry.stem,
        "exhibits": [exhibit.as_dict() for exhibit in exhibits],
        "draft": part("draft", lambda: draft_svg(read_draft(asset.folder / DRAFT_FILE)), ""),
        "lobes": part("lobes", lambda: _lobes(asset), []),
        "cloth": part("cloth", lambda: _cloth(asset), []),
        "yarns": part("yarns", lambda: _yarns(asset), []),
        "files": part("files", lambda: _files(asset), []),
        "readme": part("readme", lambda: _readme(asset), ""),
        "absent": absent,
    }


def _lobes(asset: OpenAsset) -> list[dict[str, str]]:
    drawn = []
    for yarn in asset.yarns[:MAX_LOBES]:
        optics = yarn_optics_of(asset, yarn)
        if optics is not None:
            drawn.append({"yarn": yarn, "svg": lobe_svg(optics)})
    return drawn


def _cloth(asset: OpenAsset) -> list[list[str]]:
    """Return name, value, unit and meaning of what is stated about the cloth."""
    return [
        [a.name, _shown(asset.cloth(a.name)), a.unit, a.meaning]
        for a in CLOTH_ATTRIBUTES
        if a.group in TOLD and not a.type.endswith("[]")
    ]


def _yarns(asset: OpenAsset) -> list[list[str]]:
    """Return a table, the first row its head: an attribute a row, a yarn a column."""
    head = ["", *asset.yarns]
    rows = [
        [f"{a.name} [{a.unit}]" if a.unit else a.name,
         *(_shown(asset.yarn(yarn, a.name)) for yarn in asset.yarns)]
        for a in YARN_ATTRIBUTES
    ]  # fmt: skip
    return [head, *rows]


def _files(asset: OpenAsset) -> list[list[str]]:
    """Return path, bytes and SHA-256 of the files that the manifest lists."""
    path = asset.folder / MANIFEST_FILE
    if not path.is_file():
        raise InputError("the asset has no manifest: it is not published yet")
    with path.open("rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise InputError(f"the manifest is larger than {MAX_BYTES} bytes")
    listed = json.loads(data)["files"]
    return [[str(f["path"]), str(f["bytes"]), str(f["sha256"])] for f in listed]


def _readme(asset: OpenAsset) -> str:
    """Return the asset's own page, on which its makers state their losses."""
    path = asset.folder / README_FILE
    if not path.is_file():
        raise InputError("the asset has no page of its own")
    with path.open("rb") as file:
        return file.read(MAX_TEXT).decode("utf-8", "replace")


def _shown(value: Any) -> str:
    if value is None:
        return "—"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (int, str)):
        return str(value)[:400]
    try:
        return ", ".join(f"{float(component):.4g}" for component in value)
    except (TypeError, ValueError):
        return str(value).strip("@")[:400]
