"""What usdview imports: finds the package weaveusd around this file, and its plugin in it.

`weaveusd env` puts this folder on PYTHONPATH and nothing else: a folder of site-packages there
would hide usdview's own `pxr` behind one without usdview.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

if "weaveusd" not in sys.modules:
    _package = Path(__file__).resolve().parents[2]
    _spec = importlib.util.spec_from_file_location(
        "weaveusd", _package / "__init__.py", submodule_search_locations=[str(_package)]
    )
    if _spec is None or _spec.loader is None:
        raise ImportError(f"{_package}: not the package weaveusd")
    _module = importlib.util.module_from_spec(_spec)
    sys.modules["weaveusd"] = _module
    _spec.loader.exec_module(_module)

from weaveusd.usdview.plugin import ClothContainer

__all__ = ["ClothContainer"]
