"""Whether the cloth keeps its color as it goes away."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from weaveusd.errors import StageError
from weaveusd.render.model import MAX_LEVELS
from weaveusd.validate.color_difference import mean_delta_e
from weaveusd.validate.exhibits import Exhibit, of_linear
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

COLOR = Code("distance-color", Status.FAIL, "From afar the cloth has another color than near.")
LEVEL = Code(
    "distance-level",
    Status.FAIL,
    "What yarns do together, by the moment maps, has another color than the yarns.",
)

SPAN = 3
"""How much further the far picture is seen from; its pixels hold this squared more cloth each."""

LAMP_DEG = 45.0

LEVELS = {"a crossing": 2, "the whole cloth": MAX_LEVELS - 1}
"""Levels of detail that are looked at, by what one cell of them holds."""

FEWEST = 32
"""Least samples of a pixel by levels, which are less noisy: else a quarter of the profile's."""

LEVEL_SHARE = 0.5
"""Share of the profile's ΔE2000 that a level may be off: 1 is about 4 % in brightness."""


@check(
    id="render/distance",
    why="A garment crosses the frame: what was signed near has to hold at the far end.",
    needs=("material", "shader", "textures", "renderer"),
    codes=(COLOR, LEVEL),
)
def near_against_far(asset: OpenAsset) -> Iterator[Finding]:
    """From further away, in fewer pixels or by its moment maps, the cloth has the same color."""
    from weaveusd.validate.trial import Setting, trials

    profile, where = asset.profile, str(asset.material.GetPath())
    setting = Setting(8.0, sky=0.3, lamp=LAMP_DEG)
    levels = {} if asset.lacks("moments") else LEVELS
    try:
        with trials(asset) as trial:
            near = trial.render(setting, spp=profile.spp).image
            # As many samples in all, on fewer pixels.
            far = trial.render(replace(setting, span=SPAN), spp=profile.spp * SPAN**2).image
            by_level = {
                cell: trial.render(setting, spp=max(FEWEST, profile.spp // 4), lod=lod).image
                for cell, lod in levels.items()
            }
    except StageError:
        return  # render/swatch reports it
    apart = mean_delta_e(near, far)
    told = f"from {SPAN} times as far the mean colors are ΔE2000 {apart:.2f} apart"
    asset.shown["far"] = Exhibit("Renders", "From afar", told, of_linear(far))
    if apart > profile.delta_e:
        yield COLOR(f"{told}, expected at most {profile.delta_e:g}", where)
    for cell, picture in by_level.items():
        apart, most = mean_delta_e(near, picture), LEVEL_SHARE * profile.delta_e
        told = f"in cells of {cell} the mean color is ΔE2000 {apart:.2f} from that of the yarns"
        asset.shown[f"level-{levels[cell]}"] = Exhibit(
            "Renders", f"By the moment maps of {cell}", told, of_linear(picture)
        )
        if apart > most:
            yield LEVEL(f"{told}, expected at most {most:g}", where)
