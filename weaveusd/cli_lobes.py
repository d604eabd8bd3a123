"""The command `lobes`: how the yarns of presets scatter, drawn or checked."""

from __future__ import annotations

import json
import sys
import time
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from weaveusd.proof.check import Row


class Format(str, Enum):
    """Formats of the figures."""

    png = "png"
    svg = "svg"
    both = "both"


class Lobe(str, Enum):
    """Profiles of the lobes."""

    cauchy = "cauchy"
    gaussian = "gaussian"
    both = "both"


def register(app: typer.Typer) -> None:
    """Add the command `lobes` to `app`."""
    app.command("lobes")(_lobes)


def _lobes(
    presets: Annotated[
        list[str] | None, typer.Argument(metavar="PRESET…", help="See `weaveusd presets`.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the figures.")] = Path("lobes"),
    file_format: Annotated[
        Format, typer.Option("--format", help="Format of the figures.")
    ] = Format.png,
    lobe: Annotated[
        Lobe, typer.Option(help="Profile of the lobes; both draws one against the other.")
    ] = Lobe.cauchy,
    angle: Annotated[
        list[float] | None,
        typer.Option(metavar="DEG", help="Angle of the viewer to the normal; repeat for more."),
    ] = None,
    published: Annotated[
        bool, typer.Option("--published", help="Draw the BSDF as published, not as we use it.")
    ] = False,
    check: Annotated[
        bool, typer.Option("--check", help="Check every law instead, by default of all presets.")
    ] = False,
    quick: Annotated[
        bool, typer.Option("--quick", help="Check fewer angles with fewer samples.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object on stdout.")
    ] = False,
) -> None:
    """Draw how the yarns of presets scatter light, or check that they keep the laws.

    A check that fails exits with 1.
    """
    if check:
        if published:
            raise typer.BadParameter("--check proves the BSDF that is used: leave --published")
        _check(presets or [], lobe, angle, quick=quick, as_json=as_json)
    elif quick:
        raise typer.BadParameter("--quick belongs to --check")
    elif not presets:
        raise typer.BadParameter("expected a preset, or --check")
    else:
        _draw(presets, out, file_format, lobe, angle, published=published, as_json=as_json)


def _draw(
    presets: list[str],
    out: Path,
    file_format: Format,
    lobe: Lobe,
    angles: list[float] | None,
    *,
    published: bool,
    as_json: bool,
) -> None:
    from weaveusd.proof import draw
    from weaveusd.proof.curves import Form

    started = time.perf_counter()
    forms = tuple(Form(gaussian, published) for gaussian in _profiles(lobe))
    files = draw.draw(
        presets,
        out,
        formats=("png", "svg") if file_format is Format.both else (file_format.value,),
        forms=forms,
        angles_deg=angles or draw.ANGLES,
    )
    if as_json:
        seconds = round(time.perf_counter() - started, 3)
        _print_json({"status": "drawn", "files": [str(f) for f in files], "seconds": seconds})
        return
    for file in files:
        typer.echo(str(file))


def _check(
    presets: list[str], lobe: Lobe, angles: list[float] | None, *, quick: bool, as_json: bool
) -> None:
    from weaveusd.proof import check
    from weaveusd.proof.subjects import subjects

    started = time.perf_counter()
    found = subjects(presets)
    usual = check.QUICK_ANGLES if quick else check.ANGLES
    rows = {
        "gaussian" if gaussian else "cauchy": check.check(
            found,
            angles or usual,
            gaussian=gaussian,
            samples=check.QUICK_SAMPLES if quick else check.SAMPLES,
        )
        for gaussian in _profiles(lobe)
    }
    failed = sum(bool(row.faults) for each in rows.values() for row in each)
    if as_json:
        told = [{"lobe": name, **row.as_dict()} for name, each in rows.items() for row in each]
        seconds = round(time.perf_counter() - started, 3)
        status = "failed" if failed else "passed"
        _print_json({"status": status, "failed": failed, "rows": told, "seconds": seconds})
    else:
        for name, each in rows.items():
            _print_rows(name, each)
        typer.echo(f"{failed} of {sum(map(len, rows.values()))} rows are out of bounds")
    if failed:
        raise typer.Exit(1)


def _profiles(lobe: Lobe) -> tuple[bool, ...]:
    """Return for each profile asked for whether it is Gaussian."""
    return {Lobe.cauchy: (False,), Lobe.gaussian: (True,), Lobe.both: (False, True)}[lobe]


def _print_rows(name: str, rows: tuple[Row, ...]) -> None:
    from rich.console import Console

    from weaveusd.proof.table import as_table

    # A pipe has no width of its own, and a folded table cannot be read by a program.
    console = Console(width=None if sys.stdout.isatty() else 200)
    console.print(f"{name.capitalize()} lobes", style="bold", highlight=False)
    console.print(as_table(rows))


def _print_json(value: Any) -> None:
    sys.stdout.write(json.dumps(value, indent=2, ensure_ascii=False) + "\n")
