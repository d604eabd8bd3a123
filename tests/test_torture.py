"""A publish that is killed, runs out of disk or races leaves old versions and new ones, whole.

`benchmarks/torture.py` does it; here a few trials of each kind.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

TORTURE = Path(__file__).parents[1] / "benchmarks" / "torture.py"


def torture(**trials: int) -> dict[str, object]:
    """Run one part and return its count."""
    numbers = {"steps": 0, "kills": 0, "sizes": 0, "rounds": 0, **trials}
    arguments = [f"--{part}={number}" for part, number in numbers.items()]
    done = subprocess.run(
        [sys.executable, str(TORTURE), "--json", *arguments], capture_output=True, text=True
    )
    assert done.stdout, done.stderr
    (count,) = json.loads(done.stdout)
    assert count["faults"] == []
    assert done.returncode == 0
    return count


def test_a_kill_before_any_step_on_disk_leaves_old_or_new_and_the_next_run_cleans_up():
    count = torture(steps=500)
    assert count["trials"] > 50
    assert count["old"] > 20
    assert count["new"] > 10
    assert count["remains"] > 50


@pytest.mark.slow
def test_publishers_killed_at_random_lose_nothing():
    count = torture(kills=15)
    assert count["notes"]["killed"] == 15


@pytest.mark.slow
def test_a_full_disk_refuses_a_cloth_or_takes_it_whole():
    count = torture(sizes=10)
    assert count["notes"]["refused"] >= 3
    assert count["notes"]["published"] >= 2
    assert (count["old"], count["new"]) == (count["notes"]["refused"], count["notes"]["published"])


@pytest.mark.slow
def test_eight_publishers_of_a_cloth_make_one_version_of_it_again_and_again():
    count = torture(rounds=4)
    assert (count["trials"], count["new"]) == (32, 4)
    assert count["notes"] == {"published": 4, "unchanged": 28}
