"""Compiled code that is kept on disk."""

from __future__ import annotations

import importlib.util
import sys

from weaveusd.synth import compiled

OUTER = """
from shade_of_a_test import COLOR
from weaveusd.synth.compiled import compiled, step

@step
def inner():
    return COLOR

@compiled
def outer():
    return inner()
"""


def load(path):
    """The module in a file, executed anew."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_code_is_kept_until_a_file_that_it_was_compiled_from_changes(tmp_path, monkeypatch):
    file = tmp_path / "outer_of_a_test.py"
    file.write_text(OUTER)

    def found(color):
        (constant := tmp_path / f"color_{color}.py").write_text(f"COLOR = {color}\n")
        monkeypatch.setitem(sys.modules, "shade_of_a_test", load(constant))
        return load(file).outer()

    assert found(1) == 1
    assert found(2) == 1
    monkeypatch.setattr(compiled, "SOURCES", "others")
    assert found(2) == 2
