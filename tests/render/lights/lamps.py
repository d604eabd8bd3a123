"""A card of known albedo under a light, and closed forms of what it receives.

The card lies in z = 0, faces +z and is measured at the origin, where a camera sees a tenth of a
unit of it. Radiance that leaves a Lambert surface is albedo · E / π.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdLux

from tests.render.stages import add_camera, add_mesh, new_stage, picture

ALBEDO = 0.5

CARD = "/World/Card"


def card(tmp_path: Path, up: str = "Y") -> Usd.Stage:
    """Return a stage with a gray card and a camera close to it."""
    stage = new_stage(tmp_path / "scene.usda", up)
    add_mesh(stage, CARD, color=(ALBEDO,) * 3)
    add_camera(stage, distance=1.0, fov=6)
    return stage


def received(stage: Usd.Stage, spp: int = 2048, **more: Any) -> tuple[Any, list[str]]:
    """Return the card's irradiance in red, green and blue, and the losses."""
    image, losses = picture(stage, 3, spp, **more)
    return image.mean(axis=(0, 1)) * (np.pi / ALBEDO), losses


def irradiance(stage: Usd.Stage, spp: int = 2048, **more: Any) -> tuple[float, list[str]]:
    """Return the mean of `received`, and the losses."""
    found, losses = received(stage, spp, **more)
    return float(found.mean()), losses


def irradiances(stage: Usd.Stage, seeds: int = 8, spp: int = 2048) -> Any:
    """Return the card's irradiance by each of some seeds, (seeds,)."""
    from weaveusd.render.trace import trace
    from weaveusd.render.translate import translate

    scene = translate(stage, width=3, height=3).scene
    found = [float(trace(scene, (3, 3), spp, seed).mean()) for seed in range(seeds)]
    return np.array(found) * (np.pi / ALBEDO)


def put(light: Any, *, at: Any = (0, 0, 0), turn: Any = (0, 0, 0), scale: Any = (1, 1, 1)) -> Any:
    """Place a light, rotations about x, y and z in degrees; return its matrix, (4, 4) columns."""
    light.AddTranslateOp().Set(Gf.Vec3d(*map(float, at)))
    light.AddRotateXYZOp().Set(Gf.Vec3f(*map(float, turn)))
    light.AddScaleOp().Set(Gf.Vec3f(*map(float, scale)))
    return np.array(light.ComputeLocalToWorldTransform(Usd.TimeCode.Default())).T


def rect(stage: Any, width: float = 4.0, height: float = 2.0) -> Any:
    """Define a rect light."""
    light = UsdLux.RectLight.Define(stage, "/World/Light")
    light.CreateWidthAttr(width)
    light.CreateHeightAttr(height)
    return light


def corners(world: Any, width: float, height: float) -> Any:
    """Return the corners of a rect light placed by `world`, (4, 3)."""
    local = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) * (width / 2, height / 2, 0)
    return local @ world[:3, :3].T + world[:3, 3]


def shaped(light: Any, **inputs: Any) -> Any:
    """Apply ShapingAPI and set its inputs: cone_angle, cone_softness, focus, focus_tint."""
    shaping = UsdLux.ShapingAPI.Apply(light.GetPrim())
    make = {
        "cone_angle": shaping.CreateShapingConeAngleAttr,
        "cone_softness": shaping.CreateShapingConeSoftnessAttr,
        "focus": shaping.CreateShapingFocusAttr,
        "focus_tint": shaping.CreateShapingFocusTintAttr,
        "ies_file": shaping.CreateShapingIesFileAttr,
        "ies_scale": shaping.CreateShapingIesAngleScaleAttr,
        "ies_normalize": shaping.CreateShapingIesNormalizeAttr,
    }
    for name, value in inputs.items():
        make[name]().Set(value)
    return light


# --- Closed forms, for the radiance 1 ---------------------------------------------------------


def polygon(corners: Any) -> float:
    """Lambert's formula: E = Σ Γ_k n·(p_k × p_k+1) / |p_k × p_k+1| / 2, n = +z, at the origin.

    Γ_k is the angle between two corners; all of them lie above the card.
    """
    p = np.asarray(corners, float)
    q = np.roll(p, -1, axis=0)
    cross = np.cross(p, q)
    lengths = np.linalg.norm(cross, axis=1)
    gamma = np.arctan2(lengths, (p * q).sum(axis=1))
    return abs(float((gamma * cross[:, 2] / lengths).sum() / 2))


def disk_beside(radius: float, height: float, aside: float) -> float:
    """A disk parallel to the card, its center off by `aside` (Siegel and Howell, C-12)."""
    plus = height**2 + aside**2 + radius**2
    root = np.sqrt(plus**2 - 4 * aside**2 * radius**2)
    return float(np.pi / 2 * (1 - (plus - 2 * radius**2) / root))


def tube(world: Any, radius: float, length: float, steps: int = 400) -> float:
    """E = ∫ cos θ cos θ' / d² dA over the lateral surface along x, by midpoints."""
    phi = 2 * np.pi * (np.arange(steps) + 0.5) / steps
    x = length * ((np.arange(4 * steps) + 0.5) / (4 * steps) - 0.5)
    around = np.stack([0 * phi, np.cos(phi), np.sin(phi)], -1)
    local = radius * around[None] + x[:, None, None] * (1.0, 0.0, 0.0)
    points = local @ world[:3, :3].T + world[:3, 3]
    along = np.broadcast_to(world[:3, 0], points.shape)
    tangents = np.stack([0 * phi, -np.sin(phi), np.cos(phi)], -1) @ world[:3, :3].T
    normals = np.cross(tangents, along) * np.sign(np.linalg.det(world[:3, :3]))
    patch = np.linalg.norm(normals, axis=-1)
    normals = normals / patch[..., None]
    distance = np.linalg.norm(points, axis=-1)
    toward = -points / distance[..., None]
    leaving = np.maximum((normals * toward).sum(-1), 0)
    arriving = np.maximum(-toward[..., 2], 0)
    area = patch * radius * (2 * np.pi / steps) * (length / (4 * steps))
    return float((leaving * arriving / distance**2 * area).sum())
