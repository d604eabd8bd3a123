"""Publishing a finished version again, elsewhere: a copy with the same bytes."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

from weaveusd.contract import MANIFEST_FILE
from weaveusd.errors import InputError
from weaveusd.export.names import safe_name
from weaveusd.export.publish import PublishedAsset, publish_asset
from weaveusd.export.versions import NEXT


def adopt_asset(
    folder: Path, root: Path, check: Callable[[Path], object], version: str = NEXT
) -> PublishedAsset:
    """Publish a copy of the version in `folder`, its manifest too, as `publish_asset` does.

    Raises
    ------
    InputError
        The manifest names no asset, or as `publish_asset` does.
    VersionConflictError, WeaveusdError
        As `publish_asset` does.
    """

    def copy(target: Path) -> None:
        # A link stays a link, which `publish_asset` refuses.
        shutil.copytree(folder, target, symlinks=True, dirs_exist_ok=True)

    return publish_asset(root, _name(folder), copy, check, version)


def _name(folder: Path) -> str:
    path = folder / MANIFEST_FILE
    try:
        name = json.loads(path.read_text(encoding="utf-8"))["asset"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f"{path}: no manifest of a published asset") from error
    if not isinstance(name, str) or safe_name(name) != name:
        raise InputError(f"{path}: asset {str(name)[:80]!r}, expected a name that is published")
    return name
