"""Stages of the examples: what each of them is made of.

Lengths are metres here and centimetres on the stage; st is in metres of cloth (decision 0004).
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from panels import normals
from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray
    from panels import Sewn

    Doubles = NDArray[np.float64]

CENTIMETRE = 0.01
CLOTH, LOOKS = "/World/Cloth", "/World/Looks"
WHITE, RED, GREEN = (0.725, 0.71, 0.68), (0.63, 0.065, 0.05), (0.14, 0.45, 0.091)
GRAY = (0.18, 0.18, 0.18)
WOOD = (0.16, 0.075, 0.035)
UNDRESSED = (0.35, 0.34, 0.32)


def new_stage(path: Path) -> Usd.Stage:
    """Return a stage with /World and the empty prim that a published cloth is referenced on.

    Until then a gray material stands in: it is referenced last, so any other is stronger.
    """
    stage = empty_layer(path)
    world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
    Usd.ModelAPI(world).SetKind(Kind.Tokens.assembly)
    stage.SetDefaultPrim(world)
    UsdGeom.Scope.Define(stage, LOOKS)
    stand_in = UsdGeom.Scope.Define(stage, f"{LOOKS}/Undressed").GetPath()
    _matte(stage, stand_in.AppendChild("Material"), UNDRESSED, shader="StandIn")
    cloth = UsdGeom.Scope.Define(stage, CLOTH).GetPrim()
    cloth.GetReferences().AddInternalReference(stand_in, position=Usd.ListPositionBackOfAppendList)
    return stage


def empty_layer(path: Path) -> Usd.Stage:
    """Return an empty stage in centimetres, y up, in place of any file of that name."""
    path.unlink(missing_ok=True)
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, CENTIMETRE)
    return stage


def write_component(path: Path, name: str, covers: dict[str, tuple[Sewn, Doubles]]) -> None:
    """Write a crate file whose default prim /`name` holds one mesh for each cover at rest."""
    stage = empty_layer(path)
    root = UsdGeom.Xform.Define(stage, f"/{name}").GetPrim()
    Usd.ModelAPI(root).SetKind(Kind.Tokens.component)
    stage.SetDefaultPrim(root)
    for cover, (sewn, rest) in covers.items():
        mesh = add_mesh(stage, f"/{name}/{cover}", rest, sewn.quads)
        smooth = normals(sewn.quads, rest).astype(np.float32)
        mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(smooth))
        mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
        )
        values, indices = np.unique(
            sewn.st.reshape(-1, 2).astype(np.float32), axis=0, return_inverse=True
        )
        primvar.Set(Vt.Vec2fArray.FromNumpy(values))
        primvar.SetIndices(Vt.IntArray.FromNumpy(indices.ravel().astype(np.int32)))
    stage.Save()


def add_component(stage: Usd.Stage, name: str, crate: str, look: str | None = None) -> None:
    """Reference a component beside the stage as /World/`name`, bound to a look or to the cloth."""
    prim = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
    prim.GetReferences().AddReference(f"./{crate}")
    if look is None:
        bind(prim, Sdf.Path(f"{CLOTH}/Material"))
    else:
        bind_look(prim, look)


def add_group(stage: Usd.Stage, name: str) -> str:
    """Define an Xform of the kind component and return its path."""
    prim = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
    Usd.ModelAPI(prim).SetKind(Kind.Tokens.component)
    return str(prim.GetPath())


def add_mesh(
    stage: Usd.Stage, path: str, points: Doubles, faces: Any, look: str | None = None
) -> UsdGeom.Mesh:
    """Define a mesh of `points` (V, 3) and faces of equal size (F, k), bound to a look by name."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    single = (np.asarray(points, float) / CENTIMETRE).astype(np.float32)
    corners = np.asarray(faces, np.int32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(single))
    counts = np.full(len(corners), corners.shape[1], np.int32)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(counts))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners.ravel()))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    low, high = single.min(axis=0), single.max(axis=0)
    mesh.CreateExtentAttr([Gf.Vec3f(*map(float, low)), Gf.Vec3f(*map(float, high))])
    if look is not None:
        bind_look(mesh.GetPrim(), look)
    return mesh


def add_lathe(
    stage: Usd.Stage, path: str, profile: Any, look: str, at: tuple[float, float] = (0.0, 0.0)
) -> None:
    """Define the surface of a profile (N, 2) of radius and height, turned about y at x and z."""
    spokes = 48
    turn = 2 * np.pi * np.arange(spokes) / spokes
    radius, height = (np.asarray(profile, float)[:, k, None] for k in (0, 1))
    ring = np.broadcast_arrays(at[0] + radius * np.sin(turn), height, at[1] + radius * np.cos(turn))
    points = np.stack(ring, axis=-1).reshape(-1, 3)
    grid = np.arange(len(points)).reshape(-1, spokes)
    beside = np.roll(grid, -1, axis=1)
    quads = np.stack((grid[:-1], beside[:-1], beside[1:], grid[1:]), axis=-1).reshape(-1, 4)
    add_mesh(stage, path, points, quads, look)


def add_look(stage: Usd.Stage, name: str, color: Sequence[float]) -> None:
    """Define a matte material below /World/Looks."""
    _matte(stage, Sdf.Path(f"{LOOKS}/{name}"), color)


def bind_look(prim: Usd.Prim, look: str) -> None:
    """Bind a material below /World/Looks by its name."""
    bind(prim, Sdf.Path(f"{LOOKS}/{look}"))


def bind(prim: Usd.Prim, material: Sdf.Path) -> None:
    """Bind a material by its path."""
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material.Get(prim.GetStage(), material))


def add_camera(
    stage: Usd.Stage, name: str, eye: Sequence[float], target: Sequence[float], width: float,
    aspect: float = 1.0,
) -> None:  # fmt: skip
    """Define a camera that sees `width` metres at its target, 24 mm of film high.

    Translation, pan and tilt are transforms of their own, as a camera on its stand has them.
    """
    camera = UsdGeom.Camera.Define(stage, f"/World/{name}")
    way = np.subtract(target, eye)
    distance = float(np.linalg.norm(way))
    pan = np.degrees(np.arctan2(-way[0], -way[2]))
    tilt = np.degrees(np.arcsin(way[1] / distance))
    camera.AddTranslateOp().Set(tuple(round(float(v) / CENTIMETRE, 4) for v in eye))
    camera.AddRotateYOp().Set(round(float(pan), 3))
    camera.AddRotateXOp().Set(round(float(tilt), 3))
    across = 24.0 * aspect
    camera.CreateHorizontalApertureAttr(round(across, 3))
    camera.CreateVerticalApertureAttr(24.0)
    camera.CreateFocalLengthAttr(round(across * distance / width, 2))
    camera.CreateFocusDistanceAttr(round(distance / CENTIMETRE, 2))
    camera.CreateClippingRangeAttr(Gf.Vec2f(1.0, 10000.0))


def add_panel_light(
    stage: Usd.Stage, name: str, at: Sequence[float], target: Sequence[float],
    size: tuple[float, float], intensity: float, color: Sequence[float],
) -> None:  # fmt: skip
    """Define a rectangle of light at `at` that faces `target`."""
    light = UsdLux.RectLight.Define(stage, f"/World/{name}")
    way = np.subtract(target, at)
    pan = np.degrees(np.arctan2(-way[0], -way[2]))
    tilt = np.degrees(np.arcsin(way[1] / np.linalg.norm(way)))
    light.AddTranslateOp().Set(tuple(round(float(v) / CENTIMETRE, 4) for v in at))
    light.AddRotateYOp().Set(round(float(pan), 3))
    light.AddRotateXOp().Set(round(float(tilt), 3))
    width, height = (round(v / CENTIMETRE, 3) for v in size)
    light.CreateWidthAttr(width)
    light.CreateHeightAttr(height)
    light.CreateIntensityAttr(intensity)
    light.CreateColorAttr(Gf.Vec3f(*map(float, color)))
    half = Gf.Vec3f(width / 2, height / 2, 0)
    light.CreateExtentAttr([-half, half])


def add_dome(stage: Usd.Stage, picture: str, exposure: float) -> None:
    """Define the sky of a lat-long picture beside the stage."""
    dome = UsdLux.DomeLight.Define(stage, "/World/Sky")
    dome.CreateTextureFileAttr(Sdf.AssetPath(f"./{picture}"))
    dome.CreateTextureFormatAttr(UsdLux.Tokens.latlong)
    dome.CreateExposureAttr(exposure)


def _matte(
    stage: Usd.Stage, path: Sdf.Path, color: Sequence[float], shader: str = "Surface"
) -> None:
    """Define a UsdPreviewSurface without gloss: an index of 1 reflects nothing."""
    material = UsdShade.Material.Define(stage, path)
    surface = UsdShade.Shader.Define(stage, path.AppendChild(shader))
    surface.CreateIdAttr("UsdPreviewSurface")
    surface.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*color))
    surface.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(1.0)
    surface.CreateInput("ior", Sdf.ValueTypeNames.Float).Set(1.0)
    material.CreateSurfaceOutput().ConnectToSource(surface.ConnectableAPI(), "surface")
