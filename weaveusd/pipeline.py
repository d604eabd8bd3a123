"""The road from a draft to a published, rendered and judged asset."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from weaveusd.colorways import read_recipe as read_recipe
from weaveusd.errors import InputError
from weaveusd.making import make_material as make_material
from weaveusd.making import read_draft as read_draft
from weaveusd.publishing import Publication as Publication
from weaveusd.publishing import publish as publish

if TYPE_CHECKING:
    from weaveusd.export.publish import PublishedAsset
    from weaveusd.render.run import RenderResult
    from weaveusd.validate.model import Report
    from weaveusd.validate.verify import Verification

Progress = Callable[[float], None]
PathLike = str | os.PathLike[str]


def render(
    stage: PathLike,
    output: PathLike,
    *,
    scene: str | None = None,
    colorway: str | None = None,
    **settings: Any,
) -> RenderResult:
    """Render `stage` to the image `output`; settings as in `weaveusd.render.run.render`.

    With the name of an example scene, `stage` is a published cloth that the scene wears, in the
    `colorway` that is named or else the cloth's own choice.
    """
    from weaveusd.render.run import render

    if scene is None:
        if colorway is not None:
            raise InputError(f"colorway {colorway!r}: expected a scene that wears the cloth")
        return render(stage, output, **settings)
    from weaveusd.render.scenes import dress, scene_path

    with tempfile.TemporaryDirectory() as folder:
        worn = Path(folder) / f"{scene}.usda"
        dressed = dress(scene_path(scene), Path(stage), worn, colorway or "")
        return render(dressed, output, **settings)


def validate(
    stage: PathLike,
    *,
    profile: str = "quick",
    waivers: PathLike | None = None,
    report: PathLike | None = None,
    progress: Progress | None = None,
) -> Report:
    """Return what the checks of `profile` find in the asset whose entry layer is `stage`.

    The stage is opened in a child process: one that crashes USD costs a finding. `profile` is the
    name of one or its TOML file, `waivers` a TOML file of findings to let pass, and into the
    folder `report` go a page, JSON and JUnit XML.

    Raises
    ------
    StageError
        The stage cannot be opened.
    InputError
        Profile or waivers are broken, or the folder cannot be written.
    """
    import datetime

    from weaveusd.validate.apart import validate_apart
    from weaveusd.validate.profiles import find_profile
    from weaveusd.validate.waivers import apply_waivers, read_waivers

    chosen = find_profile(profile)
    waived = () if waivers is None else read_waivers(waivers)
    today = datetime.datetime.now(datetime.timezone.utc).date()
    if report is None:
        found = validate_apart(stage, profile=chosen, progress=progress)
        return apply_waivers(found, waived, today)
    from weaveusd.validate.report.write import write_report

    with tempfile.TemporaryDirectory(prefix="weaveusd-") as folder:
        exhibits = Path(folder) / "exhibits.json"
        found = validate_apart(stage, profile=chosen, progress=progress, exhibits=exhibits)
        found = apply_waivers(found, waived, today)
        write_report(found, exhibits, Path(report), made=today.isoformat())
    return found


def verify(asset: PathLike) -> Verification:
    """Return how the files of a published asset differ from those that were published."""
    from weaveusd.validate.verify import verify

    return verify(asset)


def adopt(folder: PathLike, *, root: PathLike, version: str = "next") -> PublishedAsset:
    """Publish the finished version in `folder`, made elsewhere by `publish`, below `root` as well.

    The files are copied, byte for byte, and appear at once or not at all as `publish` has them
    do; content that is there already is `unchanged`.

    Raises
    ------
    InputError
        `folder` is no version that is as it was published, or `version` or `root` is broken.
    VersionConflictError
        The version asked for exists with other content.
    WeaveusdError
        The disk refused.
    """
    from weaveusd.export.adopt import adopt_asset
    from weaveusd.validate.verify import verify

    def check(version_folder: Path) -> None:
        versions = verify(version_folder).versions
        if len(versions) != 1:
            raise InputError(f"{folder}: {len(versions)} versions, expected the folder of one")
        for difference in versions[0].differences:
            raise InputError(f"{folder}: {difference.path} {difference.message}")

    check(Path(folder))
    return adopt_asset(Path(folder), Path(root), check, version)


def report_text(report: Report) -> str:
    """Return the report as plain text, worst finding first."""
    from weaveusd.validate.text import as_text

    return as_text(report)


def presets(name: str | None = None) -> list[dict[str, Any]]:
    """Return every preset, or the one of that name, as JSON types with all their numbers.

    Angles are in radians. Raises InputError for a name that is none.
    """
    from dataclasses import asdict

    from weaveusd.yarn.recipe import preset_names, read_preset

    return [asdict(read_preset(n)) for n in (preset_names() if name is None else (name,))]


def preset_swatch(name: str, width: int, height: int) -> str:
    """Return a preset's cloth as text for a terminal, `width` columns of `height` / 2 lines."""
    from weaveusd.swatch import swatch, swatch_text
    from weaveusd.yarn.recipe import read_preset

    return swatch_text(swatch(read_preset(name), width=width, height=height))


def environment() -> dict[str, str]:
    """Return the environment variables that let other USD programs know the schema.

    They also let usdview find its plugin; PYTHONPATH holds nothing but that.
    """
    from weaveusd.stage import schema_dir

    plugin = Path(__file__).resolve().parent / "usdview"
    folders = (schema_dir() / "weaveCloth", plugin)
    return {
        "PXR_PLUGINPATH_NAME": os.pathsep.join(map(str, folders)),
        "PYTHONPATH": str(plugin / "python"),
    }
