"""Another OpenUSD, with MaterialX of its own, knows every node and input that we write.

NVIDIA's usd-exchange brings that OpenUSD. It cannot stand beside usd-core, so it is installed
into an environment in the cache when the test is run for the first time.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import MaterialX
import pytest

from weaveusd.stage import schema_dir

VERSION = "3.0.1"
SCRIPT = Path(__file__).with_name("known_nodes.py")

pytestmark = pytest.mark.slow


def cache() -> Path:
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base, "weaveusd", f"usd-exchange-{VERSION}-py{sys.version_info.minor}")


@pytest.fixture(scope="session")
def python() -> Path:
    """The Python of the environment, made where it is not there yet; skipped where it cannot be."""
    home = cache()
    interpreter = home / "bin" / "python"
    ready = home / "ready"
    if not ready.is_file():
        shutil.rmtree(home, ignore_errors=True)
        venv.create(home, with_pip=True)
        done = subprocess.run(
            [interpreter, "-m", "pip", "install", "--quiet", f"usd-exchange=={VERSION}"],
            capture_output=True, text=True,
        )  # fmt: skip
        if done.returncode:
            shutil.rmtree(home, ignore_errors=True)
            pytest.skip(f"usd-exchange cannot be installed: {done.stderr.strip()[-300:]}")
        ready.touch()
    return interpreter


@pytest.fixture(scope="session")
def libraries(tmp_path_factory) -> Path:
    """The definition of standard_surface: usd-exchange brings that of OpenPBR alone."""
    folder = tmp_path_factory.mktemp("materialx")
    bxdf = Path(MaterialX.__file__).parent / "libraries" / "bxdf"
    shutil.copy(bxdf / "standard_surface.mtlx", folder)
    return folder


@pytest.mark.parametrize("kind", ["denim", "chiffon", "damask"])
def test_usd_exchange_knows_every_node_and_input(kind, published, python, libraries, tmp_path):
    entry = published(kind) / f"{kind}.usda"
    for path in (entry, *sorted(entry.parent.glob("*.usdz"))):
        done = subprocess.run(
            [python, SCRIPT, path, schema_dir() / "weaveCloth" / "shaders.usda"],
            capture_output=True, text=True, cwd=tmp_path,
            env={"PATH": os.environ["PATH"], "PXR_MTLX_PLUGIN_SEARCH_PATHS": str(libraries)},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        report = json.loads(done.stdout)
        assert report["materialx"], "this OpenUSD has no MaterialX"
        assert report["shaders"] >= 20
        assert report["unknown"] == []
        assert report["composition"] == []
