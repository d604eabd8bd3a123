"""Publish three cloths and write the report of each: `make report`.

python examples/report.py out/report --profile standard
"""

from __future__ import annotations

import argparse
from pathlib import Path

import weaveusd
from weaveusd.pipeline import validate

DRAFTS = Path(__file__).parent / "drafts"
CLOTHS = (("twill_2_2", "linen"), ("satin_5", "charmeuse"), ("houndstooth", "houndstooth"))
"""Draft and preset of each."""


def main() -> None:
    """Publish, judge and say where the pages are."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--profile", default="standard")
    parser.add_argument("--resolution", type=int, default=1024)
    arguments = parser.parse_args()
    for draft, preset in CLOTHS:
        done = weaveusd.publish(
            DRAFTS / f"{draft}.wif",
            preset=preset,
            root=arguments.folder / "assets",
            resolution=arguments.resolution,
        )
        folder = arguments.folder / done.asset.asset
        report = validate(done.asset.entry, profile=arguments.profile, report=folder)
        print(f"{report.status.name:<5} {folder / 'report.html'}")


if __name__ == "__main__":
    main()
