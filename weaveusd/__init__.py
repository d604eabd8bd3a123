"""weaveusd turns a weaving draft into a cloth you can render.

Everything public is loaded at its first use, so that `import weaveusd` costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from weaveusd._version import __version__

if TYPE_CHECKING:
    from weaveusd.draft.wif import read_wif
    from weaveusd.pipeline import publish, verify
    from weaveusd.render.run import render
    from weaveusd.validate.run import validate

__all__ = ["__version__", "publish", "read_wif", "render", "validate", "verify"]

_HOMES = {
    "read_wif": "weaveusd.draft.wif",
    "publish": "weaveusd.pipeline",
    "verify": "weaveusd.pipeline",
}


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    if name in ("render", "validate"):
        return import_module(f"weaveusd.{name}")
    raise AttributeError(f"module 'weaveusd' has no attribute {name!r}")
