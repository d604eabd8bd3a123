"""Where the files of a look lie in an asset's folder."""

from __future__ import annotations

from dataclasses import dataclass

from weaveusd.contract import (
    DRAFT_FILE,
    EXACT_FILE,
    GLSLFX_FILE,
    LOOK_LAYER,
    MATERIALX_FILE,
    RECIPE_FILE,
    TEXTURE_DIR,
    of_colorway,
)


@dataclass(frozen=True, slots=True)
class LookFiles:
    """The files of a look, as paths below the asset's folder.

    `colorway` is its name, "" for the cloth itself. `own` are the textures that the colorway has
    in its own folder; the others are those of the cloth itself, which hold the same bytes.
    `own_draft` is whether its draft is another, in its colors.
    """

    colorway: str = ""
    own: frozenset[str] = frozenset()
    own_draft: bool = False

    @property
    def look(self) -> str:
        """The look layer."""
        return of_colorway(LOOK_LAYER, self.colorway)

    @property
    def materialx(self) -> str:
        """The MaterialX document."""
        return of_colorway(MATERIALX_FILE, self.colorway)

    @property
    def exact(self) -> str:
        """The MaterialX document with our own node, where it is asked for."""
        return of_colorway(EXACT_FILE, self.colorway)

    @property
    def glslfx(self) -> str:
        """The shader for Storm, where it is asked for."""
        return of_colorway(GLSLFX_FILE, self.colorway)

    @property
    def recipe(self) -> str:
        """The recipe as used."""
        return of_colorway(RECIPE_FILE, self.colorway)

    @property
    def draft(self) -> str:
        """The draft, which colorways share unless they repaint it."""
        return of_colorway(DRAFT_FILE, self.colorway if self.own_draft else "")

    @property
    def folder(self) -> str:
        """The folder of the textures that no other look has."""
        return f"{TEXTURE_DIR}/{self.colorway}" if self.colorway else TEXTURE_DIR

    def texture(self, file: str) -> str:
        """Return the path of the texture, or moment map, that the contract calls `file`."""
        return f"{self.folder if file in self.own else TEXTURE_DIR}/{file}"

    def anchored(self, file: str) -> str:
        """Return that path as USD wants it."""
        return f"./{self.texture(file)}"


CLOTH_ITSELF = LookFiles()
"""The files of a cloth that has no colorways, or of its first."""
