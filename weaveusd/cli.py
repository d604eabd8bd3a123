"""The command line: arguments, printing, exit status.

With ``--json`` exactly one object goes to stdout; everything for people goes to stderr, and a
progress bar only to a terminal. The exit status is that of the error raised (errors.py), 0
for success and 2 for a mistake in the arguments.
"""

from __future__ import annotations

import shlex
import sys
import traceback
from enum import Enum
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from weaveusd import (
    cli_draft,
    cli_farm,
    cli_lobes,
    cli_presets,
    cli_publish,
    cli_validate,
    cli_verify,
)
from weaveusd._version import __version__
from weaveusd.cli_output import Json, print_json, progress_bar, say
from weaveusd.errors import WeaveusdError

app = typer.Typer(
    name="weaveusd",
    help="Turn a weaving draft into a cloth you can render.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

StageFile = Annotated[Path, typer.Argument(metavar="STAGE", help="A USD file.")]


DEBUG = "--debug"


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


cli_publish.register(app)


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
    colorway: Annotated[
        str | None, typer.Option(help="Variant of the cloth that the scene wears.")
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
    lod: Annotated[
        str,
        typer.Option(
            metavar="auto|full|LEVEL",
            help="Detail of cloth: as pixels see it, all of it, or one level, 0 the finest.",
        ),
    ] = "full",
    as_json: Json = False,
) -> None:
    """Render a stage with Mitsuba, cloth by its exact BSDF."""
    from weaveusd import pipeline

    with progress_bar(f"rendering {stage.name}") as progress:
        result = pipeline.render(
            stage,
            output,
            scene=scene,
            colorway=colorway,
            camera=camera,
            width=width,
            height=height,
            spp=spp,
            seed=seed,
            context=context.value,
            lod=int(lod) if lod.isdecimal() and lod.isascii() else lod,
            frame=frame,
            purposes=[p.value for p in purpose or (Purpose.render,)],
            progress=progress,
        )
    if as_json:
        print_json(
            {
                "output": str(output), "width": result.width, "height": result.height, "spp": spp,
                "variant": result.variant, "seconds": round(result.seconds, 3),
                "losses": [loss.as_dict() for loss in result.losses],
            }
        )  # fmt: skip
        return
    say(f"rendered {output} in {result.seconds:.1f} s ({result.variant})")
    for loss in result.losses:
        say(f"  loss: {loss}")


cli_validate.register(app)


@app.command()
def env(as_json: Json = False) -> None:
    """Print what usdview needs to know the schema and the plugin, and other programs the schema.

    For a shell: eval "$(weaveusd env)".
    """
    from weaveusd import pipeline

    variables = pipeline.environment()
    if as_json:
        print_json(variables)
        return
    for key, value in variables.items():
        say(f"export {key}={shlex.quote(value)}${{{key}:+:${key}}}")


cli_verify.register(app)
cli_farm.register(app)
cli_draft.register(app)
cli_presets.register(app)
cli_lobes.register(app)


def _fail(message: str, error: BaseException, status: int, *, debug: bool) -> int:
    if debug:
        traceback.print_exception(error, file=sys.stderr)
    sys.stderr.write(f"weaveusd: {' '.join(message.splitlines())}\n")
    return status
