"""From a draft and recipes to a published asset: made, written, judged, given its version."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from weaveusd.colorways import read_colorways
from weaveusd.contract import COLOR_SPACES, DOORS
from weaveusd.errors import InputError, ValidationFailedError
from weaveusd.making import make_material, read_draft
from weaveusd.patch import Patch

if TYPE_CHECKING:
    from weaveusd.contract import ColorSpace, Door
    from weaveusd.export.publish import PublishedAsset
    from weaveusd.shading.material import ClothMaterial

Progress = Callable[[float], None]
PathLike = str | os.PathLike[str]

MAX_JOBS = 1024

_WRITING = 0.85
"""Share of a publish's time that goes into writing textures, for the progress bar."""


@dataclass(frozen=True, slots=True)
class Publication:
    """What `publish` did: the asset, its findings as JSON types, and how long it took.

    `colors_out_of_reach` tells of every yarn that is lighter than its fibres can make it in this
    weave: `yarn`, its `color`, and the color `reached`, linear in the asset's color space; and in
    which `colorway` where there are several. `losses` tells of every network which effects of
    the exact cloth it carries, approximates or drops. `budget` tells what a distance asked for made
    of the resolution, and why.
    """

    asset: PublishedAsset
    findings: list[dict[str, Any]]
    seconds: float
    colors_out_of_reach: list[dict[str, Any]]
    losses: list[dict[str, Any]]
    budget: dict[str, float | str] | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the publication as JSON types."""
        return {
            **self.asset.as_dict(),
            "seconds": round(self.seconds, 3),
            "findings": self.findings,
            "colors_out_of_reach": self.colors_out_of_reach,
            "losses": self.losses,
            **({} if self.budget is None else {"budget": self.budget}),
        }


def publish(
    draft: PathLike,
    *,
    root: PathLike,
    preset: str | None = None,
    recipe: PathLike | None = None,
    colorways: Mapping[str, PathLike] | None = None,
    name: str | None = None,
    resolution: int | None = None,
    texels_per_mm: float | None = None,
    repeats: tuple[int, int] | None = None,
    patch_mm: tuple[float, float] | None = None,
    distance_m: float | None = None,
    seed: int = 0,
    color_space: str = "lin_rec709",
    version: str = "next",
    keep_personal: bool = False,
    previews: bool = False,
    exact: bool = False,
    glslfx: bool = False,
    doors: Collection[str] = (),
    dry_run: bool = False,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Publication:
    """Publish the cloth that `draft` and a preset or recipe make as a version below `root`.

    The asset appears whole and checked, or not at all; the same input gives the same bytes, and
    publishing it again is `unchanged`.

    Parameters
    ----------
    draft
        A WIF file.
    root
        Folder that holds all assets.
    preset, recipe
        Name of a preset, or a recipe's TOML file: exactly one of them.
    colorways
        More presets or recipes of the same draft, by the name of the variant that each becomes;
        what ends in ``.toml`` is a recipe's file, what ends in ``.wif`` a draft whose palette the
        first recipe gets. The first recipe is the default, under its own name.
    name
        Name of the asset; by default the draft file's and the recipe's. It is made safe.
    resolution, texels_per_mm
        Texels along the longer side of the patch, by default 1024; or texels a millimetre.
    repeats, patch_mm
        Repeats of the draft across and along that the textures show, by default one; or the size
        to which the nearest whole repeats are taken. Irregularity does not repeat in a patch.
    distance_m
        Distance from where the cloth is looked at, in place of a resolution: the fewest texels that
        keep its look there (docs/lod.md).
    seed
        Seed of every irregularity, 0 or more.
    color_space
        Space of the linear colors, ``lin_rec709`` or ``acescg``; in the latter a color outside
        Rec.709 keeps its saturation.
    version
        ``next``, or one such as ``v003``.
    keep_personal
        Keep the draft's author, address, e-mail, telephone and fax in the asset's ``draft.wif``.
        They are left out of everything else in any case.
    previews
        Render pictures into the asset: draped, swatch, and to scale, and of 15 other colorways at
        most the draped one. It takes minutes, and they differ in their last bits from machine to
        machine, and with them the asset's content.
    exact
        Write ``exact.mtlx`` too: MaterialX by our own node, for renderers that run its GLSL.
    glslfx
        Give the material a network for Storm and usdview too, which prefer it to MaterialX.
    doors
        Formats of other programs to write beside the asset: ``usdz``, ``gltf``, ``u3m``, ``tx``.
    dry_run
        Make and check the asset in a temporary folder, touch nothing below `root`, and say what
        would have been published: the status is ``would-publish`` or ``unchanged``.
    jobs
        Threads that compute and encode, by default one a core; any number gives the same bytes.
    progress
        Told the share of the work done, 0…1.

    Raises
    ------
    InputError
        The draft, a recipe, a size, seed, color space, version or root is broken, or two
        colorways have one name.
    ValidationFailedError
        The asset failed its own checks; nothing was written.
    VersionConflictError
        The version asked for exists with other content.
    RendererUnavailableError
        Previews are asked for and nothing on this machine can render.
    WeaveusdError
        The disk refused.
    """
    from weaveusd.export.losses import losses_as_json, losses_of
    from weaveusd.export.names import safe_name
    from weaveusd.export.publish import plan_asset, publish_asset

    started = time.perf_counter()
    tell = progress or (lambda share: None)
    patch = Patch(resolution, texels_per_mm, repeats, patch_mm, distance_m)
    if not 0 <= seed < 1 << 31:
        raise InputError(f"seed: found {seed}, expected 0 to {(1 << 31) - 1}")
    space = _color_space(color_space)
    other_doors = _doors(doors)
    if jobs is not None and not 1 <= jobs <= MAX_JOBS:
        raise InputError(f"jobs: found {jobs}, expected 1 to {MAX_JOBS}")
    sources = read_colorways(preset, recipe, colorways or {})
    first = next(iter(sources))
    name = safe_name(name or f"{Path(draft).stem}_{sources[first].recipe.name}")
    read = read_draft(draft, keep_personal=keep_personal)
    cloths = {
        colorway: make_material(
            read,
            source.recipe,
            name,
            patch=patch,
            recipe_toml=source.text,
            palette=source.palette,
            seed=seed,
            color_space=space,
            jobs=jobs,
        )
        for colorway, source in sources.items()
    }
    tell(0.05)
    findings = _recipe_findings(cloths)
    also = [n for n, asked in (("exact", exact), ("glslfx", glslfx)) if asked] + [*other_doors]
    told = {colorway: losses_of(cloth, also) for colorway, cloth in cloths.items()}
    losses = losses_as_json(told.pop(first), told)
    pictures = _pictures(tuple(cloths) if colorways else ()) if previews else {}

    def write(folder: Path) -> None:
        # Imported here: input that is refused should not wait for it.
        from weaveusd.export.asset import write_asset

        entry = write_asset(
            cloths[first],
            folder,
            colorways=cloths if colorways else None,
            previews=pictures,
            also=also,
            jobs=jobs,
            progress=lambda share: tell(0.05 + _WRITING * share * (0.1 if pictures else 1)),
        )
        if pictures:
            from weaveusd.contract import PREVIEW_DIR
            from weaveusd.render.previews import render_previews

            render_previews(
                entry,
                folder / PREVIEW_DIR,
                pictures,
                progress=lambda share: tell(0.05 + _WRITING * (0.1 + 0.9 * share)),
            )
        if other_doors:
            from weaveusd.export.doors import write_doors

            write_doors(cloths[first], folder, other_doors, colorways=cloths if colorways else None)

    def check(folder: Path) -> None:
        from weaveusd.contract import entry_layer
        from weaveusd.validate.model import Status
        from weaveusd.validate.run import validate

        report = validate(
            folder / entry_layer(name),
            jobs=jobs,
            progress=lambda share: tell(0.05 + _WRITING + (0.95 - _WRITING) * share),
        )
        findings.extend(f.as_dict() for f in report.findings if f.status > Status.SKIP)
        if not report.passed:
            worst = max(report.findings, key=lambda f: f.status)
            raise ValidationFailedError(
                f"{name}: nothing published: {worst.code}: {worst.message}", findings
            )

    settle = plan_asset if dry_run else publish_asset
    asset = settle(Path(root), name, write, check, version, losses)
    tell(1.0)
    return Publication(
        asset,
        findings,
        time.perf_counter() - started,
        _colors_out_of_reach(cloths),
        losses,
        patch.budget(sources[first].recipe),
    )


def _pictures(colorways: Sequence[str]) -> dict[str, tuple[str, ...]]:
    from weaveusd.render.previews import pictures_of

    return pictures_of(colorways)


def _color_space(name: str) -> ColorSpace:
    for known in COLOR_SPACES:
        if name == known:
            return known
    raise InputError(f"color space: found {name!r}, expected {' or '.join(COLOR_SPACES)}")


def _doors(names: Collection[str]) -> tuple[Door, ...]:
    for name in names:
        if name not in DOORS:
            raise InputError(f"doors: found {name!r}, expected {', '.join(DOORS)}")
    return tuple(door for door in DOORS if door in names)


def _colors_out_of_reach(cloths: Mapping[str, ClothMaterial]) -> list[dict[str, Any]]:
    return [
        {
            **({"colorway": colorway} if len(cloths) > 1 else {}),
            "yarn": yarn.name,
            "color": [round(c, 6) for c in yarn.color],
            "reached": [round(c, 6) for c in measured.reached],
        }
        for colorway, cloth in cloths.items()
        for yarn, measured in zip(cloth.weave.yarns, cloth.measured, strict=True)
        if measured.reached != yarn.color
    ]


def _recipe_findings(cloths: Mapping[str, ClothMaterial]) -> list[dict[str, Any]]:
    """Return every warning once; what the default does not have names the colorways that do."""
    from weaveusd.validate.model import Finding, Status

    having: dict[str, list[str]] = {}
    for colorway, cloth in cloths.items():
        for warning in cloth.weave.warnings:
            having.setdefault(warning, []).append(colorway)
    default = next(iter(cloths))
    found = []
    for warning, names in having.items():
        where = "" if default in names else f"in the colorway {', '.join(names)}: "
        finding = Finding("recipe/kept", Status.WARN, "recipe-not-kept", where + warning)
        found.append(finding.as_dict())
    return found
