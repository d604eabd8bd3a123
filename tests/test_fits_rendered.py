"""The error that an asset states is what a renderer of its networks shows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import weaveusd
from weaveusd.shading.directions import pairs

DRAFTS = Path(__file__).resolve().parents[1] / "examples" / "drafts"
STAGE = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{{
    def Scope "Cloth" (prepend references = @{entry}@) {{}}
    def Mesh "Plane" (prepend apiSchemas = ["MaterialBindingAPI"])
    {{
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
        texCoord2f[] primvars:st = [(-1, -1), (1, -1), (1, 1), (-1, 1)] (interpolation = "vertex")
        rel material:binding = </World/Cloth/Material>
    }}
    def DistantLight "Sun"
    {{
        float inputs:angle = 0
        float inputs:intensity = 1
        bool inputs:normalize = true
        matrix4d xformOp:transform = {light}
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }}
    def Camera "Camera"
    {{
        token projection = "orthographic"
        float horizontalAperture = {aperture}
        float verticalAperture = {aperture}
        float2 clippingRange = (0.1, 10)
        matrix4d xformOp:transform = {camera}
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }}
}}
"""


def looking_along(back):
    """A matrix, as USD writes it, whose z axis is `back`, one metre along it."""
    side = np.cross((0.0, 0.0, 1.0), back)
    side /= np.linalg.norm(side)
    rows = np.eye(4)
    rows[:3, :3] = side, np.cross(back, side), back
    rows[3, :3] = back
    return "( " + ", ".join("(" + ", ".join(f"{v:.12g}" for v in row) + ")" for row in rows) + " )"


def radiance(folder, entry, repeat_m, wi, wo, context):
    stage = folder / "stage.usda"
    stage.write_text(
        STAGE.format(
            entry=entry, light=looking_along(wo), camera=looking_along(wi),
            aperture=f"{10 * 8 * repeat_m:.12g}",
        )
    )  # fmt: skip
    done = weaveusd.render(stage, None, width=96, height=96, spp=16, context=context)
    return done.image.mean((0, 1))


@pytest.mark.slow
@pytest.mark.parametrize(("draft", "preset"), [("satin_5", "charmeuse"), ("twill_2_2", "denim")])
def test_a_fitted_network_is_as_far_off_in_a_render_as_the_asset_says(
    draft, preset, tmp_path, renderer
):
    done = weaveusd.publish(DRAFTS / f"{draft}.wif", preset=preset, root=tmp_path, resolution=192)
    stated = {
        network["network"]: effect["error"]
        for network in done.losses
        for effect in network["effects"]
        if "error" in effect
    }
    wi, wo = pairs(28)
    high = (wi[:, 2] > 0.25) & (wo[:, 2] > 0.25)
    directions = list(zip(wi[high], wo[high], strict=True))[:14]
    found = {
        context: np.array(
            [
                radiance(tmp_path, done.asset.entry, 2e-3, view, light, context)
                for view, light in directions
            ]
        )
        for context in ("mitsuba", "openpbr", "preview")
    }
    exact = found["mitsuba"]
    errors = {
        context: np.abs(found[context] - exact).sum() / exact.sum()
        for context in ("openpbr", "preview")
    }
    # The asset's error counts directions closer to the cloth too, where shaders are worst.
    for context, error in errors.items():
        assert 0.4 * stated[context] < error < stated[context] + 0.05
