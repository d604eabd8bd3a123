"""The command `publish`: its options, and what they mean."""

from __future__ import annotations

import re
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from weaveusd.cli_hooks import SECONDS, Hooks, ended_by_sigterm
from weaveusd.cli_output import Json
from weaveusd.cli_publishing import publish_and_tell
from weaveusd.cli_telling import Log, ProgressKind, ResultFile
from weaveusd.hooks import hook_command


class ColorSpace(str, Enum):
    """Space of the colors of a published asset."""

    lin_rec709 = "lin_rec709"
    acescg = "acescg"


def register(app: typer.Typer) -> None:
    """Add the command `publish` to `app`."""
    app.command("publish")(_publish)


def _publish(
    draft: Annotated[Path, typer.Argument(metavar="DRAFT", help="A WIF file.")],
    root: Annotated[Path, typer.Option(help="Folder that holds all assets.")],
    preset: Annotated[
        str | None, typer.Option(help="Yarns and sett by name; see `weaveusd presets`.")
    ] = None,
    recipe: Annotated[
        Path | None, typer.Option(help="Yarns and sett from a TOML file of yours.")
    ] = None,
    colorway: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=RECIPE",
            help="Another preset, recipe.toml or palette.wif, as a variant; repeat it for more.",
        ),
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
    distance_m: Annotated[
        float | None,
        typer.Option(help="Fewest texels for cloth seen from so far, in metres, instead."),
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
    keep_personal: Annotated[
        bool,
        typer.Option("--keep-personal", help="Keep author, address … in the asset's draft.wif."),
    ] = False,
    previews: Annotated[
        bool, typer.Option("--previews", help="Render pictures into the asset; takes minutes.")
    ] = False,
    usdz: Annotated[
        bool, typer.Option("--usdz", help="Also a usdz package that opens from anywhere.")
    ] = False,
    gltf: Annotated[bool, typer.Option("--gltf", help="Also a glTF of a flat panel.")] = False,
    u3m: Annotated[
        bool, typer.Option("--u3m", help="Also a U3M 1.1 for garment programs.")
    ] = False,
    tx: Annotated[bool, typer.Option("--tx", help="Also mip-mapped .tx textures.")] = False,
    exact: Annotated[
        bool, typer.Option("--exact", help="Write exact.mtlx, MaterialX by our own node.")
    ] = False,
    glslfx: Annotated[
        bool, typer.Option("--glslfx", help="Add our shader for Storm and usdview.")
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Make and check it, keep nothing, say what would be.")
    ] = False,
    jobs: Annotated[
        int | None, typer.Option(help="Threads that compute and encode; one a core.")
    ] = None,
    pre_hook: Annotated[
        str | None, typer.Option(metavar="CMD", help="Asked before; refuses by failing.")
    ] = None,
    post_hook: Annotated[
        str | None, typer.Option(metavar="CMD", help="Told after; JSON on stdin, like the other.")
    ] = None,
    hook_seconds: Annotated[
        float, typer.Option(min=0.1, max=86400, help="Time that each hook gets.")
    ] = SECONDS,
    progress: Annotated[
        ProgressKind, typer.Option(help="A bar on a terminal, lines for OpenJD, or none.")
    ] = ProgressKind.bar,
    result: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the JSON here, whole.")
    ] = None,
    log_file: Annotated[Path | None, typer.Option(metavar="FILE", help="Add to this log.")] = None,
    as_json: Json = False,
) -> None:
    """Publish a draft as a USD and MaterialX material asset, checked and at once."""
    if (preset is None) == (recipe is None):
        raise typer.BadParameter("expected --preset or --recipe, exactly one of them")
    if as_json and progress is ProgressKind.openjd:
        raise typer.BadParameter("--progress openjd has stdout to itself: --result FILE gets JSON")
    pair = _pair("--repeats", repeats, r"[1-9]\d{0,5}")
    settings = {
        "root": root,
        "preset": preset,
        "recipe": recipe,
        "colorways": _colorways(colorway or []),
        "name": name,
        "resolution": resolution,
        "texels_per_mm": texels_per_mm,
        "distance_m": distance_m,
        "repeats": pair and (int(pair[0]), int(pair[1])),
        "patch_mm": _pair("--patch-mm", patch_mm, r"\d{1,6}(?:\.\d{1,6})?"),
        "seed": seed,
        "color_space": color_space.value,
        "version": version,
        "keep_personal": keep_personal,
        "previews": previews,
        "exact": exact,
        "glslfx": glslfx,
        "doors": [
            name
            for name, wanted in {"usdz": usdz, "gltf": gltf, "u3m": u3m, "tx": tx}.items()
            if wanted
        ],
        "dry_run": dry_run,
        "jobs": jobs,
    }
    hooks = Hooks(
        _command("--pre-hook", pre_hook), _command("--post-hook", post_hook), hook_seconds
    )
    told = ResultFile(result)
    with ended_by_sigterm() as go_on, Log(log_file) as log:
        publish_and_tell(
            draft,
            settings,
            hooks,
            progress=progress,
            told=told,
            log=log,
            as_json=as_json,
            go_on=go_on,
        )


def _colorways(options: list[str]) -> dict[str, str]:
    """Return the recipes by name; a usage error where an option is none, or a name comes twice."""
    found: dict[str, str] = {}
    for option in options:
        name, _, source = option.partition("=")
        if not name or not source:
            expected = "expected a name and a recipe such as blue=blue.toml"
            raise typer.BadParameter(f"--colorway: found {option!r}, {expected}")
        if name in found:
            raise typer.BadParameter(f"--colorway: {name!r} comes twice")
        found[name] = source
    return found


def _command(option: str, text: str | None) -> tuple[str, ...] | None:
    """Return the arguments of a hook; a usage error where there are none."""
    try:
        return None if text is None else hook_command(text)
    except ValueError as error:
        raise typer.BadParameter(f"{option}: found {text!r}: {error}") from error


def _pair(option: str, text: str | None, number: str) -> tuple[float, float] | None:
    """Return the two numbers of a WxH; a usage error where it is none."""
    if text is None:
        return None
    found = re.fullmatch(f"({number})[xX×]({number})", text, re.ASCII)
    if found is None:
        raise typer.BadParameter(f"{option}: found {text!r}, expected two numbers such as 4x3")
    return float(found[1]), float(found[2])
