"""The plugin that usdview loads: one entry in a menu of ours.

`plugInfo.json` names its class. Only a usdview imports it, for `pxr.Usdviewq` is nowhere else.
"""

from __future__ import annotations

from typing import Any

from pxr import Tf
from pxr.Usdviewq.plugin import PluginContainer

from weaveusd.usdview.card import cloth_card, find_cloth
from weaveusd.usdview.drawing import draw_draft

MENU = "weaveusd"
NO_CLOTH = "weaveusd: no woven cloth is selected; select its material or what wears it"


class ClothContainer(PluginContainer):  # type: ignore[misc]
    """Adds "Cloth of the selection" to the menu of weaveusd."""

    def registerPlugins(self, plugRegistry: Any, usdviewApi: Any) -> None:
        """Register the command; usdview calls it first."""
        self._show = plugRegistry.registerCommandPlugin(
            "ClothContainer.showCloth",
            "Cloth of the selection …",
            show_cloth,
            "Show draft, yarns, size and origin of the selected cloth",
        )

    def configureView(self, plugRegistry: Any, plugUIBuilder: Any) -> None:
        """Add the command to the menu; usdview calls it second."""
        plugUIBuilder.findOrCreateMenu(MENU).addItem(self._show)


def show_cloth(usdviewApi: Any) -> None:
    """Show the cloth of the first selected prim that has one, or say that none has."""
    for prim in usdviewApi.selectedPrims:
        if material := find_cloth(prim):
            # Qt is loaded where there is something to show.
            from weaveusd.usdview.window import show_card

            card = cloth_card(material)
            show_card(card, draw_draft(card.draft), usdviewApi.qMainWindow)
            return
    usdviewApi.PrintStatus(NO_CLOTH)


Tf.Type.Define(ClothContainer)
