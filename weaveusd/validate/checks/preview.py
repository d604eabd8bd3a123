"""How far the networks for other renderers are from the exact cloth."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.contract import MITSUBA_CONTEXT
from weaveusd.errors import StageError
from weaveusd.validate.color_difference import delta_e_2000, mean_delta_e
from weaveusd.validate.exhibits import Exhibit, of_linear, of_share
from weaveusd.validate.flip import flip
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

FAR = Code(
    "preview-far", Status.WARN, "A network for other renderers looks another cloth than the exact."
)

LAMP_DEG = 45.0
CONTEXTS = {"preview": "UsdPreviewSurface", "mtlx": "MaterialX"}
LARGEST_DELTA_E = 20.0
"""ΔE2000 that the map shows as white."""


@check(
    id="render/networks",
    why="What leaves the house is often the preview: its loss has to be seen before.",
    needs=("material", "shader", "textures", "renderer"),
    codes=(FAR,),
)
def networks_against_exact(asset: OpenAsset) -> Iterator[Finding]:
    """Under a lamp and some sky, the networks for other renderers look like the exact cloth."""
    from weaveusd.validate.trial import Setting, trials

    setting = Setting(8.0, sky=0.3, lamp=LAMP_DEG)
    profile = asset.profile
    try:
        with trials(asset) as trial:
            exact = trial.render(setting, spp=profile.spp, context=MITSUBA_CONTEXT).image
            others = {c: trial.render(setting, spp=profile.spp, context=c) for c in CONTEXTS}
    except StageError:
        return  # render/swatch reports it
    asset.shown["exact"] = Exhibit(
        "Networks", "Exact", f"a lamp at {LAMP_DEG:g}° and a dim sky", of_linear(exact)
    )
    for context, name in CONTEXTS.items():
        picture = others[context].image
        seen, colors = flip(exact, picture), delta_e_2000(exact.clip(0, 1), picture.clip(0, 1))
        # Pixels of one repeat differ in place: means and maps say both.
        mean = mean_delta_e(exact, picture)
        told = f"mean FLIP {seen.mean():.3f}; ΔE2000 of the mean colors {mean:.2f}"
        losses = "; ".join(str(loss) for loss in others[context].losses)
        asset.shown[context] = Exhibit(
            "Networks", name, told + (f"; {losses}" if losses else ""), of_linear(picture)
        )
        asset.shown[f"{context}-flip"] = Exhibit(
            "Networks", f"{name}: FLIP", "black 0, white 1", of_share(seen, 1.0)
        )
        asset.shown[f"{context}-delta-e"] = Exhibit(
            "Networks",
            f"{name}: ΔE2000",
            f"black 0, white {LARGEST_DELTA_E:g} and more; {colors.mean():.1f} on average",
            of_share(colors, LARGEST_DELTA_E),
        )
        if seen.mean() > profile.flip:
            yield FAR(f"{name}: {told}, expected at most FLIP {profile.flip:g}")
