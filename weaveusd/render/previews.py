"""The preview pictures of an asset: a swatch, a drape, and the cloth in its own size."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pxr import Gf, Sdf, Usd, UsdGeom

from weaveusd.contract import of_colorway
from weaveusd.render.run import render
from weaveusd.render.scenes import dress, scene_path

if TYPE_CHECKING:
    import os

PIXELS_PER_MM = 12
"""Of the picture in the cloth's own size: 304.8 pixels an inch."""

FIELD_MM = (64.0, 76.0)
"""What that picture shows, from left to right and from top to bottom: swatch, rule and chips."""

CAMERA = "/World/ScaleCamera"


@dataclass(frozen=True, slots=True)
class _Picture:
    """A picture: its scene, width in pixels, samples a pixel, and whether it is to scale."""

    scene: str
    width: int
    spp: int
    to_scale: bool = False


_PICTURES = {
    "draped": _Picture("cornell_drape", 512, 96),
    "swatch": _Picture("swatch", 512, 64),
    "scale": _Picture("swatch", round(FIELD_MM[0] * PIXELS_PER_MM), 48, to_scale=True),
}

PREVIEWS = tuple(_PICTURES)
"""Names of the pictures; the first one is the asset's thumbnail."""

MAX_PREVIEWED = 16
"""Colorways of an asset that have pictures, each a render of its own."""


def pictures_of(colorways: Sequence[str] = ()) -> dict[str, tuple[str, ...]]:
    """Return the files of the pictures that an asset has, by the colorway that they show.

    The first of `colorways`, the default, has all of them and the next ones the thumbnail, up to
    `MAX_PREVIEWED` of them; a cloth without colorways, "", has all.
    """
    default, *others = colorways[:MAX_PREVIEWED] or [""]
    pictures = {default: tuple(f"{name}.png" for name in PREVIEWS)}
    return pictures | {name: (of_colorway(f"{PREVIEWS[0]}.png", name),) for name in others}


def render_previews(
    entry: str | os.PathLike[str],
    folder: Path,
    pictures: Mapping[str, Sequence[str]],
    *,
    progress: Callable[[float], None] | None = None,
) -> None:
    """Render `pictures`, as `pictures_of` names them, of the cloth `entry` into the new `folder`.

    `entry` is its entry layer. ``scale.png`` is seen straight from above, without perspective, and
    states its density: on paper its millimetres are millimetres, as the rule in it shows.

    Raises
    ------
    StageError
        The asset cannot be opened or is broken.
    RendererUnavailableError
        Nothing on this machine can render; the message says what to install.
    """
    tell = progress or (lambda share: None)
    folder.mkdir()
    wanted = [(colorway, file) for colorway, files in pictures.items() for file in files]
    with tempfile.TemporaryDirectory() as scratch:
        for index, (colorway, file) in enumerate(wanted):
            picture = _PICTURES[file.partition(".")[0]]
            stage = dress(
                scene_path(picture.scene), Path(entry), Path(scratch) / f"{index}.usda", colorway
            )
            camera, height = None, None
            if picture.to_scale:
                _add_camera(stage)
                camera, height = CAMERA, round(FIELD_MM[1] * PIXELS_PER_MM)
            render(
                stage,
                folder / file,
                camera=camera,
                width=picture.width,
                height=height,
                spp=picture.spp,
                progress=_part(tell, index, len(wanted)),
            )
            if picture.to_scale:
                _state_density(folder / file)


def _part(tell: Callable[[float], None], index: int, count: int) -> Callable[[float], None]:
    return lambda share: tell((index + share) / count)


def _add_camera(path: Path) -> None:
    """Author an orthographic camera that looks down on the swatch, into the layer `path`."""
    stage = Usd.Stage.Open(str(path))
    camera = UsdGeom.Camera.Define(stage, Sdf.Path(CAMERA))
    camera.CreateProjectionAttr(UsdGeom.Tokens.orthographic)
    # A tenth of a scene unit is the unit of an aperture.
    unit = 1e-3 / UsdGeom.GetStageMetersPerUnit(stage)
    camera.CreateHorizontalApertureAttr(10 * FIELD_MM[0] * unit)
    camera.CreateVerticalApertureAttr(10 * FIELD_MM[1] * unit)
    camera.CreateClippingRangeAttr(Gf.Vec2f(100 * unit, 900 * unit))
    matrix = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), -90))
    camera.AddTransformOp().Set(matrix.SetTranslateOnly(Gf.Vec3d(0, 500 * unit, 0)))
    stage.GetRootLayer().Save()


def _state_density(path: Path) -> None:
    import OpenImageIO

    picture = OpenImageIO.ImageBuf(str(path))
    for axis in ("XResolution", "YResolution"):
        picture.specmod().attribute(axis, float(PIXELS_PER_MM * 10))
    picture.specmod().attribute("ResolutionUnit", "cm")
    picture.write(str(path))
