"""What every command prints with: lines, one JSON object, a bar where people look."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any

import typer

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout.")]


def say(line: str) -> None:
    """Print a line for people; what is no text in a path is shown as an escape."""
    encoding = sys.stdout.encoding or "utf-8"
    sys.stdout.write(line.encode(encoding, "backslashreplace").decode(encoding) + "\n")


def json_text(value: Any) -> str:
    """Return `value` as the text of JSON that commands print and write, with its last newline.

    A path need not be text; what of it is none stands there as an escape.
    """
    text = json.dumps(value, indent=2, ensure_ascii=False)
    lone = any("\ud800" <= c <= "\udfff" for c in text)
    return (json.dumps(value, indent=2) if lone else text) + "\n"


def print_json(value: Any) -> None:
    """Print `value` as JSON."""
    sys.stdout.write(json_text(value))


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float], None] | None]:
    """Show a bar on stderr while the body runs, where stderr is a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)
