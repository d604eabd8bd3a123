"""Whether every texture is there and decodes."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.contract import TEXTURE_DIR
from weaveusd.errors import InputError
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset, fits, stored_type
from weaveusd.validate.registry import Code, check

UNREADABLE = Code(
    "texture-unreadable", Status.FAIL, "A texture is missing, too large or does not decode."
)
FORMAT = Code(
    "texture-format", Status.FAIL, "A texture has another number of channels or type of numbers."
)


@check(
    id="texture/files",
    why="Renderers show a missing texture as black, pink or nothing at all.",
    codes=(UNREADABLE, FORMAT),
)
def texture_files(asset: OpenAsset) -> Iterator[Finding]:
    """Every texture is there, of the right format, and decodes."""
    for file, channel in asset.texture_files.items():
        where = f"{TEXTURE_DIR}/{file}"
        try:
            header = asset.textures.header(file)
            if not fits(file, header):
                yield FORMAT(
                    f"has {header.channels} channels of {header.dtype}, "
                    f"expected {channel.components} of {stored_type(file)}",
                    where,
                )
            elif (fault := asset.decode_fault(file)) is not None:
                raise fault
        except InputError as error:
            path = asset.textures.path(file)
            yield UNREADABLE(str(error).removeprefix(f"{path}: "), where)
