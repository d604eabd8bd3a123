"""Whether the textures have the size that the material states."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.contract import TEXTURE_DIR
from weaveusd.errors import InputError
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

SIZE = Code("texture-size", Status.FAIL, "A texture has another size than the material states.")


@check(
    id="texture/resolution",
    why="The channels of a texel belong together only where all textures share one grid.",
    needs=("material",),
    codes=(SIZE,),
)
def texture_resolution(asset: OpenAsset) -> Iterator[Finding]:
    """Every texture is as wide and high as the material states."""
    expected = asset.cloth("textureWidth"), asset.cloth("textureHeight")
    for file in asset.texture_files:
        try:
            header = asset.textures.header(file)
        except InputError:
            continue  # texture/files reports it
        if None not in expected and (header.width, header.height) != expected:
            yield SIZE(
                f"{header.width} x {header.height} texels, expected {expected[0]} x {expected[1]}",
                f"{TEXTURE_DIR}/{file}",
            )
