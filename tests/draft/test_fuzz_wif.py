"""A short run of the fuzz target; `python fuzz/fuzz_wif.py` makes long ones."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

FUZZ = Path(__file__).parents[2] / "fuzz" / "fuzz_wif.py"


def test_hundreds_of_mutated_drafts_are_read_or_refused() -> None:
    run = subprocess.run(
        [sys.executable, FUZZ, "--runs", "600", "--seed", "3", "--slow", "10"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout + run.stderr
    assert "600 runs" in run.stdout
    assert " 0 faults" in run.stdout
