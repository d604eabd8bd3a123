"""The commands `inspect` and `draft`: arguments and printing."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from weaveusd.draft.model import Draft
    from weaveusd.draft.statistics import Description

_REPEATS = re.compile(r"([0-9]{1,6})[xX×]([0-9]{1,6})")
_DRAWN = 60
"""Threads of the largest draft that is drawn in the terminal."""


def register(app: typer.Typer) -> None:
    """Add the commands `inspect` and `draft` to `app`."""
    app.command("inspect")(_inspect)
    app.command("draft")(_draft)


def _inspect(
    draft: Annotated[Path, typer.Argument(metavar="DRAFT", help="WIF, or drawdown as PNG or BMP.")],
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    image: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the draft into a PNG.")
    ] = None,
) -> None:
    """Say what a draft is: size, weave, floats, colors, and what its reader had to decide."""
    from weaveusd.draft.statistics import describe
    from weaveusd.draft_tools import load_draft, save_picture

    loaded = load_draft(draft)
    description = describe(loaded)
    if image is not None:
        save_picture(loaded, image)
    if json:
        import json as json_module

        typer.echo(json_module.dumps(description.as_dict(), indent=2))
    else:
        _print(loaded, description)


def _draft(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="WIF to write.")],
    notation: Annotated[
        str | None,
        typer.Argument(metavar="NOTATION", help="A weave: plain, twill:2/2:Z, satin:5:2 …"),
    ] = None,
    image: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Drawdown as image, dark where warp is up.")
    ] = None,
    color_image: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Colors for --image, of its size.")
    ] = None,
    threading: Annotated[
        str | None, typer.Option(metavar="LIST", help="Shaft of each end: '1-4 3 2'.")
    ] = None,
    tieup: Annotated[
        str | None, typer.Option(metavar="LIST", help="Shafts of each treadle: '1+2 2+3'.")
    ] = None,
    treadling: Annotated[
        str | None, typer.Option(metavar="LIST", help="Treadle of each pick: '(1 2)*4'.")
    ] = None,
    source: Annotated[
        Path | None, typer.Option("--from", metavar="FILE", help="A draft to start from.")
    ] = None,
    mirror: Annotated[bool, typer.Option("--mirror", help="Last end first.")] = False,
    rotate: Annotated[bool, typer.Option("--rotate", help="A quarter turn to the left.")] = False,
    invert: Annotated[bool, typer.Option("--invert", help="Exchange up and down.")] = False,
    repeat: Annotated[
        str, typer.Option(metavar="WxH", help="Repeat along the weft and along the warp.")
    ] = "1x1",
) -> None:
    """Write a draft as WIF: from a notation, an image, three lists, or another draft.

    Changes are made in the order mirror, rotate, invert, repeat.
    """
    lists = (threading, tieup, treadling)
    if any(lists) and not all(lists):
        raise typer.BadParameter("--threading, --tieup and --treadling go together")
    if color_image is not None and image is None:
        raise typer.BadParameter("--color-image colors an --image")
    if sum(map(bool, (notation, image, threading, source))) != 1:
        raise typer.BadParameter(
            "give one of NOTATION, --image, --from, or --threading with --tieup and --treadling"
        )
    match = _REPEATS.fullmatch(repeat)
    if match is None or not all(map(int, match.groups())):
        raise typer.BadParameter("--repeat takes two numbers from 1 on, as 3x2")

    from weaveusd import draft_tools
    from weaveusd.draft.make import make_draft
    from weaveusd.draft.threaded import from_threading

    if notation is not None:
        made = make_draft(notation)
    elif image is not None:
        made = draft_tools.draft_from_image(image, color_image)
    elif source is not None:
        made = draft_tools.load_draft(source)
    else:
        made = from_threading(threading or "", tieup or "", treadling or "")
    changed = draft_tools.transformed(
        made,
        mirrored=mirror,
        rotated=rotate,
        inverted=invert,
        repeats=(int(match[1]), int(match[2])),
    )
    draft_tools.save_draft(changed, output)
    for warning in changed.warnings:
        typer.echo(f"warning: {warning}", err=True)
    typer.echo(f"{output}: {changed.ends} ends, {changed.picks} picks, {changed.shafts} shafts")


def _print(draft: Draft, description: Description) -> None:
    """Print the description for people; a small draft is drawn where the terminal has color."""
    from rich.console import Console

    console = Console()
    console.print(_table(description))
    if console.is_terminal and console.color_system and max(draft.ends, draft.picks) <= _DRAWN:
        from weaveusd.draft.picture import draft_text

        typer.echo(draft_text(draft, console.width))
    for warning in description.warnings:
        typer.echo(f"warning: {warning}", err=True)


def _table(description: Description) -> Table:
    from rich.table import Table
    from rich.text import Text

    d = description
    table = Table(show_header=False, box=None)
    for name, value in (
        ("title", d.title or "–"),
        ("size", f"{d.ends} ends × {d.picks} picks on {d.shafts} shafts"),
        ("repeat", f"{d.repeat_ends} ends × {d.repeat_picks} picks"),
        ("weave", d.structure or "no name known"),
        ("longest float", f"warp {d.longest_warp_float}, weft {d.longest_weft_float} threads"),
        ("floats on the face", f"warp {_counts(d.face_floats['warp'])}"),
        ("", f"weft {_counts(d.face_floats['weft'])}"),
        ("warp on the face", f"{d.warp_face:.0%}"),
        ("interlacing", f"warp {d.warp_interlacing:.0%}, weft {d.weft_interlacing:.0%}"),
        *(("yarn", yarn) for yarn in d.yarns[:16]),
        ("colors", " ".join(d.colors[:16]) + (" …" if len(d.colors) > 16 else "")),
        ("drawdown SHA-256", d.drawdown_sha256),
    ):
        table.add_row(Text(name, style="bold"), Text(value, overflow="fold"))
    return table


def _counts(floats: dict[int, int]) -> str:
    """Return a histogram in words: how many floats of each length, the first eight lengths."""
    said = [f"{count} × {length}" for length, count in list(floats.items())[:8]]
    return ", ".join(said) + (" …" if len(floats) > 8 else "") or "none"
