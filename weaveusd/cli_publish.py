"""The command `publish`: a draft becomes a version of an asset, and a pipeline is told."""

from __future__ import annotations

import re
import time
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from weaveusd.cli_output import Json, print_json, progress_bar, say
from weaveusd.errors import WeaveusdError


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
        with progress_bar(f"publishing {draft.name}") as progress:
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
            print_json(
                {
                    "status": "failed", "asset": name, "version": None, "entry": None,
                    "material": None, "files": [], "error": str(error),
                    "seconds": round(time.perf_counter() - started, 3),
                    "findings": getattr(error, "findings", []),
                }
            )  # fmt: skip
        raise
    if as_json:
        print_json(done.as_dict())
        return
    asset = done.asset
    megabytes = sum(f.bytes for f in asset.files) / 1e6
    extent = f"{len(asset.files)} files, {megabytes:.1f} MB, {done.seconds:.1f} s"
    say(f"{asset.status} {asset.asset} {asset.version}: {extent}")
    say(f"  entry     {asset.entry}")
    say(f"  material  {asset.material}")
    for finding in done.findings:
        say(f"  {finding['status']:<5} {finding['code']}: {finding['message']}")
    for yarn in done.colors_out_of_reach:
        color, reached = (_color(yarn[key]) for key in ("color", "reached"))
        say(f"  note  {yarn['yarn']} is {color}; its fibres reach {reached} in this weave")


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
