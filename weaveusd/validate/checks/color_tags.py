"""Whether the color texture says in which space it is."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.contract import ColorSpace
from weaveusd.errors import InputError
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.moment_maps import MAP_FILES
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

TAG = Code(
    "color-space-tag",
    Status.FAIL,
    "A linear color texture states another color space than the cloth.",
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
    """The linear color textures state the color space of the cloth."""
    for file in ("base_color.exr", *(map_ for map_, name in MAP_FILES.items() if name == "albedo")):
        try:
            stated = asset.textures.header(file).color_space
        except InputError:
            continue  # texture/files or texture/moments reports it
        if stated not in OIIO_NAMES[asset.color_space]:
            yield TAG(
                f"states {stated!r}, but weave:colorSpace is {asset.color_space}",
                asset.short(asset.textures.path(file)),
            )
