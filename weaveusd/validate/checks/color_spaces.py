"""Whether textures are decoded as what they are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath

from pxr import Usd, UsdShade

from weaveusd.contract import CLOTH_SHADER_ID, COLOR_SPACES, LOBE_MAPS, ColorSpace, lobe_file
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.moment_maps import MAP_FILES
from weaveusd.validate.open_asset import TEXTURE_FILES, OpenAsset
from weaveusd.validate.registry import Code, check

NAME = Code("color-space-name", Status.FAIL, "A node names a color space unknown to MaterialX.")
WRONG = Code("color-space-wrong", Status.FAIL, "A texture is read in another color space.")

LOBE_FILES = frozenset(map(lobe_file, LOBE_MAPS))

MATERIALX_NAMES = ("srgb_texture", *COLOR_SPACES)
"""Names that MaterialX knows; renderers skip others with a line on stderr, or none."""


@check(
    id="shader/color-spaces",
    why="A wrong name is ignored in silence: colors turn pale, normals bend.",
    needs=("material",),
    codes=(NAME, WRONG),
)
def color_spaces(asset: OpenAsset) -> Iterator[Finding]:
    """Every texture is read in the color space in which it was written."""
    for prim in Usd.PrimRange(asset.material):
        if not prim.IsA(UsdShade.Shader):
            continue
        shader = UsdShade.Shader(prim)
        identifier = str(shader.GetIdAttr().Get() or "")
        if identifier.startswith("ND_") or identifier == CLOTH_SHADER_ID:
            yield from _linear_node(shader, asset.color_space)
        elif identifier == "UsdUVTexture":
            yield from _preview_node(shader)


def _linear_node(shader: UsdShade.Shader, linear: ColorSpace) -> Iterator[Finding]:
    """Judge a node of MaterialX or the exact shader; one without a space reads Rec.709."""
    for found in shader.GetInputs(onlyAuthored=True):
        attribute = found.GetAttr()
        space = attribute.GetColorSpace() if attribute.HasColorSpace() else ""
        where = str(attribute.GetPath())
        if space and space not in MATERIALX_NAMES:
            yield NAME(f"{space!r} is none of {', '.join(MATERIALX_NAMES)}", where)
            continue
        if str(attribute.GetTypeName()) != "asset":
            continue
        expected = _space(attribute, "srgb_texture", linear, "")
        if expected is None:
            continue
        if expected and (space or "lin_rec709") != expected:
            yield WRONG(f"has color space {space or 'unstated'}, expected {expected}", where)
        elif not expected and space not in ("", "lin_rec709"):
            yield WRONG("is decoded as a color, but holds data", where)


def _preview_node(shader: UsdShade.Shader) -> Iterator[Finding]:
    file = shader.GetInput("file")
    expected = _space(file.GetAttr(), "sRGB", "raw", "raw") if file else None
    chosen = shader.GetInput("sourceColorSpace")
    space = str(chosen.Get() or "") if chosen else ""
    if expected is not None and space != expected:
        yield WRONG(
            f"sourceColorSpace is {space or 'unstated'}, expected {expected}",
            str(shader.GetPath()),
        )


def _space(attribute: Usd.Attribute, encoded: str, linear: str, data: str) -> str | None:
    """Return the color space of the texture that `attribute` names, None for other files."""
    value = attribute.Get()
    name = PurePosixPath(value.path).name if value is not None else ""
    if name in LOBE_FILES:
        return data
    if name in MAP_FILES:
        return linear if MAP_FILES[name] == "albedo" else data
    if name not in TEXTURE_FILES:
        return None
    if TEXTURE_FILES[name].encoding != "color":
        return data
    return encoded if name.endswith(".png") else linear
