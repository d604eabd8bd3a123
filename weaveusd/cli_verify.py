"""The command `verify`: whether a published asset is still what was published."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from weaveusd.cli_output import Json, print_json, say


def register(app: typer.Typer) -> None:
    """Add the command `verify` to `app`."""
    app.command("verify")(_verify)


def _verify(
    asset: Annotated[
        Path,
        typer.Argument(metavar="ASSET", help="Entry layer or folder of a version, or of them all."),
    ],
    as_json: Json = False,
) -> None:
    """Recompute every hash of a published asset; exit 4 when a file is missing, added, changed."""
    from weaveusd import pipeline

    started = time.perf_counter()
    found = pipeline.verify(asset)
    if as_json:
        print_json({**found.as_dict(), "seconds": round(time.perf_counter() - started, 3)})
    else:
        for version in found.versions:
            count = len(version.differences)
            many = f"{count} difference{'s' if count > 1 else ''}"
            say(f"{version.folder}: {many if count else 'intact'}")
            for difference in version.differences:
                say(f"  {difference.kind:<8} {difference.path}: {difference.message}")
    if not found.intact:
        raise typer.Exit(4)
