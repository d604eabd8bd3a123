"""The command `validate`: the judgement of an asset, with profile, waivers and report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from weaveusd.cli_output import Json, print_json, progress_bar, say


def register(app: typer.Typer) -> None:
    """Add the command `validate` to `app`."""
    app.command("validate")(_validate)


def _validate(
    stage: Annotated[Path, typer.Argument(metavar="STAGE", help="A USD file.")],
    profile: Annotated[
        str,
        typer.Option(
            metavar="NAME|FILE", help="quick, standard, full, a studio's own, or a TOML file."
        ),
    ] = "quick",
    waivers: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="TOML file of findings to let pass, and why."),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write a page, JSON and JUnit XML into this folder."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Judge a published asset from its files alone; exit 4 when it fails."""
    from weaveusd import pipeline

    with progress_bar(f"validating {stage.name}") as progress:
        found = pipeline.validate(
            stage, profile=profile, waivers=waivers, report=report, progress=progress
        )
    if as_json:
        print_json(found.as_dict())
    else:
        say(pipeline.report_text(found))
        if report is not None:
            say(f"  report  {report / 'report.html'}")
    if not found.passed:
        raise typer.Exit(4)
