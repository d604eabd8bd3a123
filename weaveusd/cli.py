"""The command line: arguments, printing, exit status.

With ``--json`` exactly one object goes to stdout; everything for people goes to stderr, and a
progress bar only to a terminal. The exit status is that of the error raised (errors.py), 0
for success and 2 for a mistake in the arguments.
"""

from __future__ import annotations

import json
import re
import shlex
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from weaveusd import cli_draft, cli_lobes, cli_presets
from weaveusd._version import __version__
from weaveusd.errors import WeaveusdError

app = typer.Typer(
    name="weaveusd",
    help="Turn a weaving draft into a cloth you can render.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout.")]
DraftFile = Annotated[Path, typer.Argument(metavar="DRAFT", help="A WIF file.")]
StageFile = Annotated[Path, typer.Argument(metavar="STAGE", help="A USD file.")]


DEBUG = "--debug"


class ColorSpace(str, Enum):
    """Space of the colors of a published asset."""

    lin_rec709 = "lin_rec709"
    acescg = "acescg"


class Purpose(str, Enum):
    """What a render draws beside what has no purpose."""

    render = "render"
    proxy = "proxy"
    guide = "guide"


class Context(str, Enum):
    """Whose networks a render reads first."""

    mitsuba = "mitsuba"
    mtlx = "mtlx"
    openpbr = "openpbr"
    preview = "preview"


def _version(wanted: bool) -> None:
    if wanted:
        sys.stdout.write(f"weaveusd {__version__}\n")
        raise typer.Exit


def main() -> NoReturn:
    """Run the command line and exit."""
    debug = DEBUG in sys.argv[1:]
    try:
        status = app([a for a in sys.argv[1:] if a != DEBUG], standalone_mode=False)
    except (typer.Abort, KeyboardInterrupt):
        status = 130
    except WeaveusdError as error:
        status = _fail(str(error), error, error.exit_status, debug=debug)
    except Exception as error:
        # typer keeps its usage errors, which are click's, in a module of its own.
        usage = getattr(error, "format_message", None)
        if usage is not None:
            status = _fail(f"{usage()} (--help shows the usage)", error, 2, debug=debug)
        else:
            what = f"internal error: {type(error).__name__}: {error} ({DEBUG} shows where)"
            status = _fail(what, error, 1, debug=debug)
    sys.exit(status if isinstance(status, int) else 0)


@app.callback()
def _root(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version and exit.", callback=_version, is_eager=True
        ),
    ] = False,
    debug: Annotated[
        bool, typer.Option(DEBUG, help="Show the traceback of an error; stands anywhere.")
    ] = False,
) -> None:
    pass


@app.command()
def publish(
    draft: DraftFile,
    root: Annotated[Path, typer.Option(help="Folder that holds all assets.")],
    preset: Annotated[
        str | None, typer.Option(help="Yarns and sett by name; see `weaveusd presets`.")
    ] = None,
    recipe: Annotated[
        Path | None, typer.Option(help="Yarns and sett from a TOML file of yours.")
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Name of the asset; else the draft's and the recipe's.")
    ] = None,
    resolution: Annotated[
        int | None, typer.Option(help="Texels along the longer side of the patch; 1024.")
    ] = None,
    texels_per_mm: Annotated[
        float | None, typer.Option(help="Texels a millimetre, instead.")
    ] = None,
    repeats: Annotated[
        str | None, typer.Option(metavar="WxH", help="Repeats of the draft in the patch; 1x1.")
    ] = None,
    patch_mm: Annotated[
        str | None, typer.Option(metavar="WxH", help="About how large the patch is, instead.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of every irregularity.")] = 0,
    color_space: Annotated[
        ColorSpace, typer.Option(help="Linear space of the colors; acescg is the wider.")
    ] = ColorSpace.lin_rec709,
    version: Annotated[str, typer.Option(help="`next`, or one such as v003.")] = "next",
    jobs: Annotated[
        int | None, typer.Option(help="Threads that compute and encode; one a core.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Publish a draft as a USD and MaterialX material asset, checked and at once."""
    if (preset is None) == (recipe is None):
        raise typer.BadParameter("expected --preset or --recipe, exactly one of them")
    pair = _pair("--repeats", repeats, r"[1-9]\d{0,5}")
    size = _pair("--patch-mm", patch_mm, r"\d{1,6}(?:\.\d{1,6})?")
    from weaveusd import pipeline

    started = time.perf_counter()
    try:
        with _progress(f"publishing {draft.name}") as progress:
            done = pipeline.publish(
                draft,
                root=root,
                preset=preset,
                recipe=recipe,
                name=name,
                resolution=resolution,
                texels_per_mm=texels_per_mm,
                repeats=pair and (int(pair[0]), int(pair[1])),
                patch_mm=size,
                seed=seed,
                color_space=color_space.value,
                version=version,
                jobs=jobs,
                progress=progress,
            )
    except WeaveusdError as error:
        if as_json:
            _print_json(
                {
                    "status": "failed", "asset": name, "version": None, "entry": None,
                    "material": None, "files": [], "error": str(error),
                    "seconds": round(time.perf_counter() - started, 3),
                    "findings": getattr(error, "findings", []),
                }
            )  # fmt: skip
        raise
    if as_json:
        _print_json(done.as_dict())
        return
    asset = done.asset
    megabytes = sum(f.bytes for f in asset.files) / 1e6
    extent = f"{len(asset.files)} files, {megabytes:.1f} MB, {done.seconds:.1f} s"
    _say(f"{asset.status} {asset.asset} {asset.version}: {extent}")
    _say(f"  entry     {asset.entry}")
    _say(f"  material  {asset.material}")
    for finding in done.findings:
        _say(f"  {finding['status']:<5} {finding['code']}: {finding['message']}")
    for yarn in done.colors_out_of_reach:
        color, reached = (_color(yarn[key]) for key in ("color", "reached"))
        _say(f"  note  {yarn['yarn']} is {color}; its fibres reach {reached} in this weave")


@app.command()
def render(
    stage: StageFile,
    output: Annotated[Path, typer.Option(help="Image to write, .exr (linear) or .png (display).")],
    scene: Annotated[
        str | None,
        typer.Option(
            help="Example scene that wears the cloth STAGE: pillow, skirt, sofa, swatch …"
        ),
    ] = None,
    camera: Annotated[str | None, typer.Option(help="Path of a camera prim.")] = None,
    width: Annotated[int, typer.Option(min=1, max=16384)] = 768,
    height: Annotated[
        int | None, typer.Option(min=1, max=16384, help="By default as the camera's aperture.")
    ] = None,
    spp: Annotated[int, typer.Option(min=1, max=1 << 20, help="Samples a pixel.")] = 64,
    seed: Annotated[int, typer.Option(min=0)] = 0,
    frame: Annotated[
        float | None, typer.Option(help="Time code of the picture; by default the earliest.")
    ] = None,
    purpose: Annotated[
        list[Purpose] | None,
        typer.Option(help="Purpose drawn beside `default`; repeat it for more. By default render."),
    ] = None,
    context: Annotated[
        Context,
        typer.Option(
            help="Networks to read first: the exact ones, those of MaterialX, or the preview's."
        ),
    ] = Context.mitsuba,
    as_json: Json = False,
) -> None:
    """Render a stage with Mitsuba, cloth by its exact BSDF."""
    from weaveusd import pipeline

    with _progress(f"rendering {stage.name}") as progress:
        result = pipeline.render(
            stage,
            output,
            scene=scene,
            camera=camera,
            width=width,
            height=height,
            spp=spp,
            seed=seed,
            context=context.value,
            frame=frame,
            purposes=[p.value for p in purpose or (Purpose.render,)],
            progress=progress,
        )
    if as_json:
        _print_json(
            {
                "output": str(output), "width": result.width, "height": result.height, "spp": spp,
                "variant": result.variant, "seconds": round(result.seconds, 3),
                "losses": [loss.as_dict() for loss in result.losses],
            }
        )  # fmt: skip
        return
    _say(f"rendered {output} in {result.seconds:.1f} s ({result.variant})")
    for loss in result.losses:
        _say(f"  loss: {loss}")


@app.command()
def validate(stage: StageFile, as_json: Json = False) -> None:
    """Judge a published asset from its files alone; exit 4 when it fails."""
    from weaveusd import pipeline

    with _progress(f"validating {stage.name}") as progress:
        report = pipeline.validate(stage, progress=progress)
    if as_json:
        _print_json(report.as_dict())
    else:
        _say(pipeline.report_text(report))
    if not report.passed:
        raise typer.Exit(4)


@app.command()
def env(as_json: Json = False) -> None:
    """Print what usdview and other USD programs need to know the schema.

    For a shell: eval "$(weaveusd env)".
    """
    from weaveusd import pipeline

    variables = pipeline.environment()
    if as_json:
        _print_json(variables)
        return
    for key, value in variables.items():
        _say(f"export {key}={shlex.quote(value)}${{{key}:+:${key}}}")


cli_draft.register(app)
cli_presets.register(app)
cli_lobes.register(app)


def _pair(option: str, text: str | None, number: str) -> tuple[float, float] | None:
    """Return the two numbers of a WxH; a usage error where it is none."""
    if text is None:
        return None
    found = re.fullmatch(f"({number})[xX×]({number})", text, re.ASCII)
    if found is None:
        raise typer.BadParameter(f"{option}: found {text!r}, expected two numbers such as 4x3")
    return float(found[1]), float(found[2])


def _color(components: list[float]) -> str:
    return "(" + ", ".join(f"{c:.2f}" for c in components) + ")"


def _fail(message: str, error: BaseException, status: int, *, debug: bool) -> int:
    if debug:
        traceback.print_exception(error, file=sys.stderr)
    sys.stderr.write(f"weaveusd: {' '.join(message.splitlines())}\n")
    return status


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")


def _print_json(value: Any) -> None:
    sys.stdout.write(json.dumps(value, indent=2, ensure_ascii=False) + "\n")


@contextmanager
def _progress(what: str) -> Iterator[Callable[[float], None] | None]:
    """Show a bar on stderr while the body runs, where stderr is a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)
