"""OpenUSD's validators and NVIDIA's find no error in a layer or a package of an asset."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys

import pytest
from pxr import UsdValidation

from weaveusd.stage import open_stage, teach_sdr

# The command as installed, once Sdr knows MaterialX: USD from PyPI reads none by itself.
NVIDIA = """
import sys
from weaveusd.stage import teach_sdr
teach_sdr()
from usd_validation_nvidia import cli_main
sys.exit(cli_main())
"""

BESIDE_THE_DEFAULT_PRIM = "The prim <Panel> (/Panel) is a sibling of the default prim"
"""A warning that stands: a panel below the default prim would come with every reference."""


def files(entry):
    return [entry, *sorted(entry.parent.glob("*.usdz"))]


def test_openusd_finds_no_error(asset):
    teach_sdr()
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    for path in files(asset):
        errors = UsdValidation.ValidationContext(validators).Validate(open_stage(path))
        assert [f"{path.name}: {e.GetName()}: {e.GetMessage()}" for e in errors] == []


def test_nvidia_finds_no_error(asset, tmp_path):
    if importlib.util.find_spec("usd_validation_nvidia") is None:
        pytest.skip("the package usd-validation-nvidia is not installed")
    report = tmp_path / "report.json"
    command = [sys.executable, "-c", NVIDIA, "--no-fix", "--no-stamp", "--json-output", report]
    done = subprocess.run([*command, asset.parent], capture_output=True, text=True)
    assert report.is_file(), done.stderr
    issues = [i for rule in json.loads(report.read_text())["rules"] for i in rule["issues"]]
    packages = len(list(asset.parent.glob("*.usdz")))
    assert [issue["severity"] for issue in issues] == ["WARNING"] * packages, issues
    assert all(issue["message"].startswith(BESIDE_THE_DEFAULT_PRIM) for issue in issues)
