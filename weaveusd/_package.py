"""Packages that are verbs: `weaveusd.render` is a folder of modules and can be called.

The public functions `weaveusd.render(...)` and `weaveusd.validate(...)` have the names of the
packages that do the work. Importing a submodule would replace a function of that name by the
package, so the package itself answers the call.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any


def make_callable(package: str, module: str, function: str) -> None:
    """Let the imported `package` be called as `function` of its submodule `module`.

    The submodule is imported at the first call, so that importing the package stays cheap.
    """

    class VerbPackage(ModuleType):
        def __call__(self, *args: Any, **kwargs: Any) -> Any:
            return getattr(import_module(f"{package}.{module}"), function)(*args, **kwargs)

    sys.modules[package].__class__ = VerbPackage
