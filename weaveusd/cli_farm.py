"""The command `farm-template`: a job that publishes drafts on a render farm."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from weaveusd.cli_publish import register as register_publish
from weaveusd.errors import InputError

OURS = ("--root", "--progress", "--result", "--json")
"""Options of `publish` that the job sets itself, or whose answer no one would read."""


def register(app: typer.Typer) -> None:
    """Add the command `farm-template` to `app`."""
    app.command("farm-template")(_farm_template)


def _farm_template(
    drafts: Annotated[list[Path], typer.Argument(metavar="DRAFT…", help="WIF files, a task each.")],
    root: Annotated[Path, typer.Option(help="Folder of all assets, from that of the job.")],
    options: Annotated[
        str, typer.Option(metavar="TEXT", help="Options of `publish`: '--preset linen --seed 3'.")
    ],
    job_name: Annotated[str, typer.Option(help="Name of the job.")] = "weaveusd publish",
    command: Annotated[str, typer.Option(help="weaveusd, as it is called there.")] = "weaveusd",
) -> None:
    """Print a job of the Open Job Description as YAML that publishes each draft in a task."""
    from weaveusd.integrations.openjd import job_template

    for draft in drafts:
        if not draft.is_file():
            raise InputError(f"{draft}: no such file, expected a WIF file")
    paths = [os.path.abspath(draft) for draft in drafts]
    arguments = _arguments(options, paths[0])
    template = job_template(paths, os.fspath(root), arguments, name=job_name, command=command)
    sys.stdout.write(template)


def _arguments(options: str, draft: str) -> list[str]:
    """Return `options` split as a shell would; a usage error where `publish` refuses them."""
    try:
        arguments = shlex.split(options)
    except ValueError as error:
        raise typer.BadParameter(f"--options: found {options!r}: {error}") from error
    for argument in arguments:
        if (option := argument.split("=")[0]) in OURS:
            raise typer.BadParameter(f"--options: found {option}, which the job decides")
    app = typer.Typer()
    register_publish(app)
    publish = typer.main.get_command(app)
    publish.make_context("publish", [draft, "--root", ".", *arguments])
    return arguments
