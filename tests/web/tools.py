"""Node, its packages and a browser for tests: found, or the test is skipped with the reason."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).resolve().parent
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@cache
def _missing() -> str:
    """Return why no script can be run, "" if one can; `npm` installs what package.json names."""
    if shutil.which("node") is None or shutil.which("npm") is None:
        return "node and npm are not installed"
    if not (HERE / "node_modules" / ".package-lock.json").is_file():
        return "its packages are not there: run `npm install` in tests/web"
    return ""


def browser() -> str:
    """Return the browser's path; the test is skipped where there is none."""
    for name in BROWSERS:
        if (path := shutil.which(name)) is not None:
            return path
    pytest.skip("no Chromium is installed")


def run_node(script: str, *arguments: str | os.PathLike[str], timeout: float = 120) -> Any:
    """Return the JSON that `script`, a file of this folder, prints for `arguments`."""
    if reason := _missing():
        pytest.skip(reason)
    done = subprocess.run(
        ["node", HERE / script, *arguments],
        capture_output=True, text=True, timeout=timeout, cwd=HERE,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
