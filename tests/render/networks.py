"""Shading networks for the tests of the translator, and a card that shows one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from tests.render.stages import add_camera, add_dome, add_mesh, bind, new_stage, picture

# One color for every quadrant, row 0 at the top.
QUADRANTS = np.array((((0.9, 0.1, 0.1), (0.1, 0.9, 0.1)), ((0.1, 0.1, 0.9), (0.7, 0.7, 0.1))))

_VALUES = {
    "float2": lambda v: Gf.Vec2f(*map(float, v)),
    "float3": lambda v: Gf.Vec3f(*map(float, v)),
    "float4": lambda v: Gf.Vec4f(*map(float, v)),
    "color3f": lambda v: Gf.Vec3f(*map(float, v)),
    "color4f": lambda v: Gf.Vec4f(*map(float, v)),
    "asset": Sdf.AssetPath,
}


def card_stage(folder: Path) -> Usd.Stage:
    """Return a stage with a white dome and a camera that sees the square from -1 to 1."""
    stage = new_stage(folder / "scene.usda")
    add_dome(stage)
    camera = add_camera(stage)
    camera.CreateProjectionAttr(UsdGeom.Tokens.orthographic)
    return stage


def node(
    stage: Usd.Stage, name: str, identifier: str, output: str = "out", **inputs: Any
) -> UsdShade.Output:
    """Define a node below the material /World/Look and return its output.

    An input is (type, value); a value that is an output becomes a connection.
    """
    shader = UsdShade.Shader.Define(stage, f"/World/Look/{name}")
    shader.CreateIdAttr(identifier)
    for key, (kind, value) in inputs.items():
        given = shader.CreateInput(key.rstrip("_"), Sdf.ValueTypeNames.Find(kind))
        if isinstance(value, UsdShade.Output | UsdShade.Input):
            given.ConnectToSource(value)
        else:
            given.Set(_VALUES.get(kind, lambda v: v)(value))
    return shader.CreateOutput(output, Sdf.ValueTypeNames.Token)


def surface(
    stage: Usd.Stage, identifier: str, context: str = "mtlx", **inputs: Any
) -> UsdShade.Shader:
    """Give /World/Look a surface of this id, bind it to a card and return the shader."""
    material = UsdShade.Material.Define(stage, "/World/Look")
    output = node(stage, "Surface", identifier, "out", **inputs)
    material.CreateSurfaceOutput(context).ConnectToSource(output)
    if not stage.GetPrimAtPath("/World/Card"):
        bind(add_mesh(stage), material)
    return UsdShade.Shader(stage.GetPrimAtPath("/World/Look/Surface"))


def matte(stage: Usd.Stage, color: Any, **inputs: Any) -> UsdShade.Shader:
    """Give the card an OpenPBR surface that is diffuse only; `color` is a value or an output."""
    return surface(
        stage, "ND_open_pbr_surface_surfaceshader",
        base_color=("color3f", color), specular_weight=("float", 0.0), **inputs,
    )  # fmt: skip


def quadrants(stage: Usd.Stage, **more: Any) -> tuple[Any, list[str]]:
    """Return the colors in the middle of each quadrant of the picture, and the losses."""
    image, losses = picture(stage, 16, 64, **more)
    return image.reshape(2, 8, 2, 8, 3)[:, 2:6, :, 2:6].mean(axis=(1, 3)), losses


def large_texels(pixels: Any, size: int = 16) -> Any:
    """Return the pixels, each repeated `size` times along both sides."""
    return np.repeat(np.repeat(np.asarray(pixels), size, 0), size, 1)


def stretch_of(stage: Usd.Stage, material: UsdShade.Material, **more: Any) -> float:
    """Return how much wider the highlight of a material is along x than along y.

    It is that of a distant light behind the camera on a dish, whose normals spread as those of a
    ball; measured are second moments of the light.
    """
    stage.RemovePrim("/World/Dome")
    stage.RemovePrim("/World/Card")
    UsdLux.DistantLight.Define(stage, "/World/Sun").CreateAngleAttr(0.0)
    bind(_dish(stage), material)
    image, losses = picture(stage, 48, 32, **more)
    assert losses == []
    light = image.mean(axis=2)
    light = np.maximum(light - 0.02 * light.max(), 0)
    place = (np.arange(48) + 0.5) / 24 - 1
    along_x = (light.sum(axis=0) * place**2).sum()
    along_y = (light.sum(axis=1) * place**2).sum()
    return float(np.sqrt(along_x / along_y))


def _dish(stage: Usd.Stage, count: int = 33) -> UsdGeom.Mesh:
    """Define a square that bulges to the camera, st growing along x and y."""
    x, y = np.meshgrid(*(np.linspace(-1, 1, count),) * 2)
    points = np.stack((x, y, -0.35 * (x * x + y * y)), axis=-1).reshape(-1, 3)
    normals = np.stack((0.7 * x, 0.7 * y, np.ones_like(x)), axis=-1).reshape(-1, 3)
    corner = np.arange(count * count).reshape(count, count)
    quads = np.stack((corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]), -1)
    mesh = add_mesh(stage, points=points, counts=[4] * (count - 1) ** 2,
                    indices=quads.ravel().tolist(), st=None)  # fmt: skip
    mesh.CreateNormalsAttr([Gf.Vec3f(*map(float, n)) for n in normals])
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    st.Set([Gf.Vec2f(float(0.5 + p[0] / 2), float(0.5 + p[1] / 2)) for p in points])
    return mesh
