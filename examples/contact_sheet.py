"""Every preset in one picture: the channels of its asset, and a close render of it.

python examples/contact_sheet.py OUT.png [PRESET …]
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import OpenImageIO as oiio  # noqa: N813

import weaveusd
from weaveusd.contract import CHANNELS, TEXTURE_DIR
from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif
from weaveusd.errors import WeaveusdError
from weaveusd.yarn.recipe import preset_names, read_preset

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from weaveusd.yarn.model import Recipe

    Floats = NDArray[np.float32]
    Picture = NDArray[np.uint8]

TILE, GAP, LABEL, TITLE, MARGIN = 82, 8, 15, 25, 12
"""Pixels: side of a channel's tile, between tiles, height of a label and of a title, border."""

COLUMNS, CARDS = 6, 2
"""Tiles side by side beside a render, and fabrics side by side."""

RENDER = 2 * TILE + GAP + LABEL
FINER = 4
"""Texels along the side of a tile's pixel."""

COARSE_MM, FINE_MM, FINE_PITCH_MM = 4.0, 2.0, 0.2
"""Side of what a tile shows; the finer one where ends lie closer than the pitch."""

VIEW = 1.5
"""Side of what a render shows, in tiles."""

ARC = math.radians(24)
"""The rendered swatch is bent over a cylinder, by this angle on either side."""

SPP = 256
INK, PAPER = (0.12, 0.12, 0.12), 255
SYSTEMS = np.array([(0, 0, 0), (0.13, 0.45, 0.75), (0.95, 0.62, 0.12)], np.float32)
FONT, BOLD = "DroidSans", "DroidSans-Bold"  # they come with OpenImageIO

STAGE = """#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 0.001
)
def Scope "Cloth" ( references = @{entry}@ ) {{ }}
def Mesh "Swatch" ( prepend apiSchemas = ["MaterialBindingAPI"] )
{{
    rel material:binding = </Cloth/Material>
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = {counts}
    int[] faceVertexIndices = {indices}
    point3f[] points = {points}
    normal3f[] normals = {normals} ( interpolation = "vertex" )
    texCoord2f[] primvars:st = {st} ( interpolation = "vertex" )
}}
def Mesh "Table"
{{
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-90, -90, -40), (90, -90, -40), (90, 90, -40), (-90, 90, -40)]
    color3f[] primvars:displayColor = [(0.18, 0.18, 0.18)]
}}
def Camera "Eye"
{{
    float focalLength = 200
    float horizontalAperture = {aperture}
    float verticalAperture = {aperture}
    float2 clippingRange = (1, 1000)
    double3 xformOp:translate = (0, 0, 100)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def DistantLight "Lamp"
{{
    float inputs:angle = 0
    float inputs:intensity = 3.3
    float3 xformOp:rotateXYZ = (-55, 0, 66)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}}
def DomeLight "Sky"
{{
    float inputs:intensity = 0.32
}}
"""


def main(output: Path, names: list[str]) -> None:
    """Publish and render every preset of `names`, fabrics first, and write the sheet."""
    recipes = sorted((read_preset(name) for name in names), key=lambda r: r.kind != "fabric")
    cards = []
    with tempfile.TemporaryDirectory() as folder:
        for recipe in recipes:
            print(f"{recipe.name} …", flush=True)
            cards.append(card(recipe, Path(folder)))
    cards += [np.full_like(cards[0], PAPER)] * (-len(cards) % CARDS)
    rows = [np.concatenate(cards[k : k + CARDS], 1) for k in range(0, len(cards), CARDS)]
    sheet = np.pad(np.concatenate(rows), ((MARGIN, 0), (MARGIN, 0), (0, 0)), constant_values=PAPER)
    write_png(sheet, output)
    print(f"wrote {output}, {output.stat().st_size / 1e6:.1f} MB")


def card(recipe: Recipe, folder: Path) -> Picture:
    """Return the title, the render and the channels of one preset."""
    side_mm = FINE_MM if 10 / recipe.ends_per_cm < FINE_PITCH_MM else COARSE_MM
    view_mm = VIEW * side_mm
    draft = folder / f"{recipe.name}.wif"
    draft.write_bytes(write_wif(make_draft(recipe.weave or "plain")))
    asset = weaveusd.publish(
        draft,
        preset=recipe.name,
        root=folder,
        texels_per_mm=FINER * TILE / side_mm,
        patch_mm=(1.2 * view_mm, 1.2 * view_mm),
    ).asset
    stage = folder / f"{recipe.name}.usda"
    stage.write_text(stage_text(asset.entry, view_mm), encoding="utf-8")
    rendered = folder / f"{recipe.name}.png"
    weaveusd.render(stage, rendered, width=RENDER, height=RENDER, spp=SPP)

    page = np.full(card_shape(), PAPER, np.uint8)
    top = TITLE
    page[top : top + RENDER, :RENDER] = read(rendered)
    texts = [(0, TITLE - 8, recipe.title, 15, BOLD)]
    texts.append((0, top + RENDER + LABEL - 4, f"render, {view_mm:g} mm wide", 12, FONT))
    below = f"channels, {side_mm:g} mm wide"
    for (name, tile), (x, y) in zip(
        tiles(asset.folder / TEXTURE_DIR, side_mm, FINER * TILE), places(), strict=False
    ):
        page[top + y : top + y + TILE, x : x + TILE] = tile
        texts.append(
            (
                x,
                top + y + TILE + LABEL - 4,
                name.removeprefix("ambient_").replace("_", " "),
                11,
                FONT,
            )
        )
    x, y = list(places())[len(CHANNELS)]
    texts += [
        (x, top + y + 12 + 16 * k, line, 12, FONT)
        for k, line in enumerate([recipe.name, *below.split(", ")])
    ]
    return written(page, texts)


def card_shape() -> tuple[int, int, int]:
    """Return height, width and colors of a card, with the space to its right and below."""
    width = RENDER + COLUMNS * (TILE + GAP) + 2 * MARGIN
    return TITLE + RENDER + LABEL + MARGIN, width, 3


def places() -> Iterator[tuple[int, int]]:
    """Yield the upper left corners of tiles, beside the render."""
    for row in range(2):
        for column in range(COLUMNS):
            yield RENDER + GAP + column * (TILE + GAP), row * (TILE + LABEL + GAP)


def tiles(folder: Path, side_mm: float, texels: int) -> Iterator[tuple[str, Picture]]:
    """Yield name and picture of each channel, of the lower left `texels`² of its texture."""
    for name, channel in CHANNELS.items():
        path = folder / channel.files[0]
        pixels = read(path, float)
        # A patch of whole repeats is not always as high as a tile: it tiles.
        rows = np.arange(-texels, 0) % len(pixels)
        columns = np.arange(texels) % pixels.shape[1]
        shown = as_color(name, pixels)[rows[:, None], columns]
        mean = shown.reshape(TILE, FINER, TILE, FINER, 3).mean((1, 3))
        yield name, np.rint(255 * np.clip(mean, 0, 1)).astype(np.uint8)


def as_color(name: str, pixels: Floats) -> Floats:
    """Return a channel's file, (H, W, c) with integers in 0…1, as display colors (H, W, 3)."""
    if name == "yarn_id":
        ids = np.rint(255 * pixels[..., 0]).astype(int)
        hues = (0.13 + 0.381966 * np.arange(256))[:, None] + np.array([0, 1 / 3, 2 / 3])
        colors = 0.58 + 0.36 * np.cos(2 * np.pi * hues)
        colors[0] = 0
        return colors[ids].astype(np.float32)
    if name == "system":
        return SYSTEMS[np.rint(255 * pixels[..., 0]).astype(int)]
    if name == "height":
        pixels = 1 - pixels / min(float(pixels.min()), -1e-6)
    if name == "fibre_angle":
        pixels = np.dstack([0.5 + 0.5 * pixels, np.full(pixels.shape[:2], 0.5, np.float32)])
    return np.broadcast_to(pixels, (*pixels.shape[:2], 3))


def stage_text(entry: Path, view_mm: float) -> str:
    """Return a stage in mm: the cloth bent over a lying cylinder, lit from the left.

    Fibres along the warp shine where sin a (1 + l_z) = l_y cos a, l the direction to the lamp: a
    quarter of the way down.
    """
    size = 1.1 * view_mm
    steps = 48
    angle = np.linspace(-ARC, ARC, steps + 1)
    radius = size / (2 * ARC)
    points, normals, st = [], [], []
    for k, a in enumerate(angle):
        for x in (-size / 2, size / 2):
            points.append((x, radius * math.sin(a), radius * (math.cos(a) - 1)))
            normals.append((0.0, math.sin(a), math.cos(a)))
            st.append(((x + size / 2) / 1000, k * size / steps / 1000))  # metres
    indices = [i for k in range(steps) for i in (2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2)]
    return STAGE.format(
        entry=f"./{entry.relative_to(entry.parents[2])}",
        counts=[4] * steps, indices=indices, points=points, normals=normals, st=st,
        aperture=200 * view_mm / 100,
    )  # fmt: skip


def read(path: Path, kind: type = np.uint8) -> NDArray:
    """Return the pixels (H, W, c) of an image, of integers in 0…1 for float."""
    image = oiio.ImageBuf(str(path))
    pixels = image.get_pixels(oiio.UINT8 if kind is np.uint8 else oiio.FLOAT)
    if pixels is None:
        raise OSError(f"{path}: {image.geterror()}")
    return pixels


def written(page: Picture, texts: list[tuple[int, int, str, int, str]]) -> Picture:
    """Return the page with texts: x, y of the base line, the text, its size and font."""
    image = oiio.ImageBuf(np.ascontiguousarray(page))
    for x, y, text, size, font in texts:
        if not oiio.ImageBufAlgo.render_text(image, x, y, text, size, font, INK):
            raise OSError(f"cannot write {text!r}: {image.geterror()}")
    return image.get_pixels(oiio.UINT8)


def write_png(picture: Picture, path: Path) -> None:
    """Write the picture as small as PNG makes it."""
    image = oiio.ImageBuf(np.ascontiguousarray(picture))
    image.specmod().attribute("png:compressionLevel", 9)
    if not image.write(str(path)):
        raise OSError(f"{path}: {image.geterror()}")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    try:
        main(Path(sys.argv[1]), sys.argv[2:] or list(preset_names()))
    except (WeaveusdError, OSError) as error:
        sys.exit(f"contact_sheet: {error}")
