"""A published cloth on a square, by every renderer at hand that reads one of its networks.

The square reaches from -1 to 1 in x and y, with texture coordinates from (0, 0) at the lower left
to `st` in metres; it fills the picture from (0, 0, 2), under one light from +z. Pictures are
(SIZE, SIZE, 3), linear, the first row at the bottom.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from tests.export import glsl
from tests.web.tools import browser, run_node

SIZE = 128
DIRECTED = (
    "mitsuba exact", "mitsuba openpbr", "glsl exact", "glsl openpbr", "glsl standard_surface",
    "three openpbr", "three standard_surface",
)  # fmt: skip
"""Renderers and networks that carry the direction of the fibre."""

RENDERERS = (*DIRECTED, "mitsuba preview")

STAGE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Y"
)
def Scope "Cloth" (prepend references = @{entry}@)
{{
}}
def Mesh "Square" (prepend apiSchemas = ["MaterialBindingAPI"])
{{
    rel material:binding = </Cloth/Material>
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    uniform token subdivisionScheme = "none"
    texCoord2f[] primvars:st = [(0, 0), ({u}, 0), ({u}, {v}), (0, {v})] (interpolation = "vertex")
}}
def DistantLight "Light"
{{
    float inputs:angle = 0
    float inputs:intensity = 1
}}
def Camera "Camera"
{{
    float horizontalAperture = 20
    float verticalAperture = 20
    float focalLength = 20
    double3 xformOp:translate = (0, 0, 2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
"""


def picture(renderer: str, entry: Path, st: tuple[float, float], folder: Path) -> np.ndarray:
    """Return the picture of the cloth with the entry layer `entry`; skips where one cannot be had.

    The asset holds ``exact.mtlx``; `folder` takes what is written on the way.
    """
    program, network = renderer.split()
    if program == "mitsuba":
        return _mitsuba(network, entry, st, folder)
    name = entry.stem + ("_standard_surface" if network == "standard_surface" else "")
    if program == "three":
        return _three(entry.with_name("material.mtlx"), name, st, folder)
    document = entry.with_name("exact.mtlx" if network == "exact" else "material.mtlx")
    job = glsl.Job(str(document), name, str(folder / "glsl.npy"), size=SIZE, st=st)
    return glsl.render([job], folder)[0]


def _mitsuba(network: str, entry: Path, st: tuple[float, float], folder: Path) -> np.ndarray:
    from weaveusd.render.run import render

    stage = folder / "square.usda"
    stage.write_text(STAGE.format(entry=entry, u=st[0], v=st[1]))
    context = {"exact": "mitsuba"}.get(network, network)
    image = render(stage, width=SIZE, spp=16, context=context).image
    return np.asarray(image)[::-1, :, :3]


def _three(document: Path, name: str, st: tuple[float, float], folder: Path) -> np.ndarray:
    settings = folder / "three.json"
    settings.write_text(json.dumps({"st": st, "size": SIZE}))
    answer = run_node("page.mjs", browser(), "materialx.mjs", document, settings)
    pixels = np.array(answer["result"]["pictures"][name], np.float32)
    return pixels.reshape(SIZE, SIZE, 4)[..., :3]
