"""Seconds that each profile takes to judge an asset, in its child process and with a report.

    python benchmarks/validation.py --resolution 2048 --runs 2

Publishes one asset and judges it with each profile by turns. `wall` is the least time by the
clock, `CPU` the least processor time of the child, all threads together, which other load on the
machine changes little. Checks that run under several profiles must find the same each time.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import weaveusd
from weaveusd.pipeline import validate

DRAFT = Path(__file__).parents[1] / "examples" / "drafts" / "houndstooth.wif"
PROFILES = {"quick": 5.0, "standard": 60.0, "full": None}
"""Seconds that each is meant to take at 2048², on two cores."""


def processor_seconds() -> float:
    """Return the processor time of all children that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--resolution", type=int, default=2048)
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--profiles", nargs="+", default=list(PROFILES))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        done = weaveusd.publish(
            DRAFT, preset="houndstooth", root=folder, resolution=arguments.resolution
        )
        found: dict[str, set[str]] = {}
        walls: dict[str, list[float]] = {name: [] for name in arguments.profiles}
        processors: dict[str, list[float]] = {name: [] for name in arguments.profiles}
        counts = {}
        for run in range(arguments.runs):
            for name in arguments.profiles:
                started, used = time.perf_counter(), processor_seconds()
                report = validate(
                    done.asset.entry, profile=name, report=Path(folder) / f"{name}_{run}"
                )
                walls[name].append(time.perf_counter() - started)
                processors[name].append(processor_seconds() - used)
                counts[name] = len({finding.check for finding in report.findings})
                for finding in report.findings:
                    codes = {f.code for f in report.findings if f.check == finding.check}
                    if found.setdefault(finding.check, codes) != codes:
                        raise SystemExit(f"{finding.check}: found {codes}, before {found}")
    print(f"{arguments.resolution} texels along the longer side, least of {arguments.runs} runs")
    print(f"{'profile':<10}{'checks':>8}{'wall s':>9}{'CPU s':>9}{'meant s':>9}")
    for name in arguments.profiles:
        meant = PROFILES.get(name)
        print(
            f"{name:<10}{counts[name]:>8}{min(walls[name]):>9.1f}{min(processors[name]):>9.1f}"
            f"{f'{meant:g}' if meant else '—':>9}"
        )


if __name__ == "__main__":
    main()
