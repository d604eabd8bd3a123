"""Whether the color texture says in which space it is."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.contract import TEXTURE_DIR, ColorSpace
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

TAG = Code(
    "color-space-tag",
    Status.FAIL,
    "The linear color texture states another color space than the cloth.",
)

OIIO_NAMES: dict[ColorSpace, tuple[str, ...]] = {
    "lin_rec709": ("", "lin_rec709_scene", "lin_rec709", "Linear", "linear"),
    "acescg": ("lin_ap1_scene", "lin_ap1", "ACEScg", "acescg"),
}
"""What OpenImageIO may call a color space; an EXR that states none is Rec.709."""


@check(
    id="texture/color-space",
    why="Programs that open the file without the stage believe what it says of itself.",
    needs=("material", "textures"),
    codes=(TAG,),
)
def color_tags(asset: OpenAsset) -> Iterator[Finding]:
    """The linear color texture states the color space of the cloth."""
    file = "base_color.exr"
    stated = asset.textures.header(file).color_space
    if stated not in OIIO_NAMES[asset.color_space]:
        yield TAG(
            f"states {stated!r}, but weave:colorSpace is {asset.color_space}",
            f"{TEXTURE_DIR}/{file}",
        )
