"""Whether the cloth keeps its color as it goes away."""

from __future__ import annotations

from collections.abc import Iterator

from weaveusd.errors import StageError
from weaveusd.validate.color_difference import delta_e_2000
from weaveusd.validate.exhibits import Exhibit, of_linear
from weaveusd.validate.model import Finding, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.registry import Code, check

COLOR = Code("distance-color", Status.FAIL, "From afar the cloth has another color than near.")

SPAN = 3
"""How much further the far picture is seen from; its pixels hold this squared more cloth each."""

LAMP_DEG = 45.0


@check(
    id="render/distance",
    why="A garment crosses the frame: what was signed near has to hold at the far end.",
    needs=("material", "shader", "textures", "renderer"),
    codes=(COLOR,),
)
def near_against_far(asset: OpenAsset) -> Iterator[Finding]:
    """Seen from further away, in fewer pixels, the cloth has the same mean color."""
    from weaveusd.validate.trial import Setting, trials

    profile = asset.profile
    try:
        with trials(asset) as trial:
            near = trial.render(Setting(8.0, sky=0.3, lamp=LAMP_DEG), spp=profile.spp)
            # As many samples in all, on fewer pixels.
            far = trial.render(
                Setting(8.0, sky=0.3, lamp=LAMP_DEG, span=SPAN), spp=profile.spp * SPAN**2
            )
    except StageError:
        return  # render/swatch reports it
    colors = [result.image.mean(axis=(0, 1)) for result in (near, far)]
    apart = float(delta_e_2000(*colors))
    told = f"from {SPAN} times as far the mean colors are ΔE2000 {apart:.2f} apart"
    asset.shown["far"] = Exhibit("Renders", "From afar", told, of_linear(far.image))
    if apart > profile.delta_e:
        yield COLOR(f"{told}, expected at most {profile.delta_e:g}", str(asset.material.GetPath()))
