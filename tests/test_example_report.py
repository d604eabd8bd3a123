"""`make report` writes the pages of three assets."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from weaveusd.contract import CHANNELS

SCRIPT = Path(__file__).parents[1] / "examples" / "report.py"


@pytest.mark.slow
def test_the_reports_of_three_cloths_are_written(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(tmp_path), "--profile", "quick", "--resolution", "512"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    lines = done.stdout.splitlines()
    assert len(lines) == 3
    for line in lines:
        status, page = line.split(maxsplit=1)
        assert status == "PASS"
        text = Path(page).read_text(encoding="utf-8")
        assert text.count("data:image/png;base64,") >= len(CHANNELS)
