"""Make the example stages: `python examples/stages/make_stages.py [folder]`.

Both are scenes of a few centimetres, so that threads are seen, with st in metres of cloth. Each
holds an empty Scope `/World/Cloth`, where a published cloth is referenced, and a mesh that binds
`/World/Cloth/Material`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, Vt

sys.path.insert(0, str(Path(__file__).parent))
from drape import drape

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

CENTIMETRE = 0.01
CLOTH = "/World/Cloth"
MATERIAL = "/World/Cloth/Material"
WHITE, RED, GREEN = (0.725, 0.71, 0.68), (0.63, 0.065, 0.05), (0.14, 0.45, 0.091)
SKY_SIZE = (64, 128)


def main(folder: Path) -> None:
    """Write both stages and the sky's picture."""
    folder.mkdir(parents=True, exist_ok=True)
    write_sky(folder / "sky.exr")
    cornell_drape(folder / "cornell_drape.usda")
    sky_sphere(folder / "sky_sphere.usda")


def cornell_drape(path: Path) -> None:
    """Write a Cornell box 8 cm wide in which a 6.6 cm square of cloth lies over a ball."""
    stage = _new_stage(path)
    half, top = 4.0, 8.0
    low, high = (-half, half), (0.0, top)
    walls = {
        "Floor": (WHITE, [(-half, 0, half), (half, 0, half), (half, 0, -half), (-half, 0, -half)]),
        "Ceiling": (WHITE, [(-half, top, -half), (half, top, -half), (half, top, half),
                            (-half, top, half)]),
        "Back": (WHITE, [(low[0], high[0], -half), (low[1], high[0], -half),
                         (low[1], high[1], -half), (low[0], high[1], -half)]),
        "Left": (RED, [(-half, 0, half), (-half, 0, -half), (-half, top, -half),
                       (-half, top, half)]),
        "Right": (GREEN, [(half, 0, -half), (half, 0, half), (half, top, half),
                          (half, top, -half)]),
    }  # fmt: skip
    for name, (color, corners) in walls.items():
        _add_mesh(stage, f"/World/Box/{name}", np.array(corners), [4], [0, 1, 2, 3], color=color)

    center, radius = (0.0, 2.9, 0.4), 1.6
    ball = UsdGeom.Sphere.Define(stage, "/World/Ball")
    ball.CreateRadiusAttr(radius)
    ball.CreateExtentAttr([Gf.Vec3f(-radius), Gf.Vec3f(radius)])
    ball.CreateDisplayColorAttr([Gf.Vec3f(*WHITE)])
    ball.AddTranslateOp().Set(center)
    foot = center[1] - 0.8 * radius
    stand = UsdGeom.Cube.Define(stage, "/World/Stand")
    stand.CreateSizeAttr(1.0)
    stand.CreateExtentAttr([Gf.Vec3f(-0.5), Gf.Vec3f(0.5)])
    stand.CreateDisplayColorAttr([Gf.Vec3f(*WHITE)])
    stand.AddTranslateOp().Set((center[0], foot / 2, center[2]))
    stand.AddScaleOp().Set((0.9, foot, 0.9))

    side, count = 6.6, 97
    points = drape(side, count, center, radius, steps=840)
    line = np.arange(count) / (count - 1) * side * CENTIMETRE
    s, t = np.meshgrid(line, line)
    _add_grid(stage, "/World/Drape", points, np.stack((s, t), axis=-1))

    light = UsdLux.RectLight.Define(stage, "/World/Light")
    light.CreateWidthAttr(3.0)
    light.CreateHeightAttr(3.0)
    light.CreateIntensityAttr(15.0)
    light.CreateColorAttr(Gf.Vec3f(1.0, 0.9, 0.75))
    light.AddTranslateOp().Set((0.0, top - 0.02, 1.4))
    light.AddRotateXOp().Set(-90.0)
    _add_camera(stage, position=(0.0, 3.9, 13.6), pitch=-6.0, width=7.2, distance=13.2)
    stage.Save()


def sky_sphere(path: Path) -> None:
    """Write a ball of 3 cm on a plane, under a sky with a sun."""
    stage = _new_stage(path)
    radius = 1.5
    points, st = ball_facing_z(radius, 41, 64)
    points[..., 1] += radius
    _add_grid(stage, "/World/Ball", points, st * CENTIMETRE)
    reach = 200.0
    corners = np.array([(-reach, 0, reach), (reach, 0, reach), (reach, 0, -reach),
                        (-reach, 0, -reach)])  # fmt: skip
    _add_mesh(stage, "/World/Ground", corners, [4], [0, 1, 2, 3], color=(0.3, 0.29, 0.27))

    dome = UsdLux.DomeLight.Define(stage, "/World/Sky")
    dome.CreateTextureFileAttr(Sdf.AssetPath("./sky.exr"))
    dome.CreateTextureFormatAttr(UsdLux.Tokens.latlong)
    sun = UsdLux.DistantLight.Define(stage, "/World/Sun")
    sun.CreateIntensityAttr(2.2)
    sun.CreateColorAttr(Gf.Vec3f(1.0, 0.94, 0.85))
    sun.CreateAngleAttr(0.0)
    sun.AddRotateYOp().Set(38.0)
    sun.AddRotateXOp().Set(-42.0)
    _add_camera(stage, position=(0.0, 1.75, 12.0), pitch=-1.2, width=4.2, distance=12.0)
    stage.Save()


def ball_facing_z(radius: float, rings: int, spokes: int) -> tuple[Doubles, Doubles]:
    """Return vertices and st of a ball whose st has true lengths around the point on +z.

    Rings run from that point to the one behind; st is the distance along the surface in the
    direction of the spoke (azimuthal equidistant), so only the hidden side is stretched.
    """
    polar = (np.linspace(0.0, np.pi, rings))[:, None]
    around = (np.linspace(0.0, 2 * np.pi, spokes + 1))[None, :]
    x = np.sin(polar) * np.cos(around)
    y = np.sin(polar) * np.sin(around)
    z = np.cos(polar) * np.ones_like(around)
    points = radius * np.stack((x, y, z), axis=-1)
    st = radius * polar[..., None] * np.stack(np.broadcast_arrays(np.cos(around), np.sin(around)),
                                              axis=-1)  # fmt: skip
    return points, st


def write_sky(path: Path) -> None:
    """Write a clear sky as a lat-long picture: +y up, the horizon in the middle row."""
    rows, columns = SKY_SIZE
    elevation = (0.5 - (np.arange(rows) + 0.5) / rows)[:, None, None] * np.pi
    height = np.clip(np.sin(elevation), 0, 1)
    zenith, horizon = np.array((0.16, 0.30, 0.62)), np.array((0.62, 0.70, 0.80))
    ground = np.array((0.16, 0.15, 0.13))
    sky = zenith + (horizon - zenith) * (1 - height) ** 4
    pixels = np.broadcast_to(np.where(elevation > 0, sky, ground), (rows, columns, 3))
    spec = oiio.ImageSpec(columns, rows, 3, oiio.HALF)
    spec.attribute("DateTime", "1980:01:01 00:00:00")
    spec.attribute("compression", "zip")
    writer = oiio.ImageOutput.create(str(path))
    if not (
        writer
        and writer.open(str(path), spec)
        and writer.write_image(np.ascontiguousarray(pixels, np.float32))
        and writer.close()
    ):
        raise SystemExit(f"{path}: {oiio.geterror()}")


def _new_stage(path: Path) -> Usd.Stage:
    stage = _empty(path)
    world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
    stage.SetDefaultPrim(world)
    UsdGeom.Scope.Define(stage, CLOTH)
    return stage


def _empty(path: Path) -> Usd.Stage:
    path.unlink(missing_ok=True)
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, CENTIMETRE)
    return stage


def _add_camera(
    stage: Usd.Stage, position: Any, pitch: float, width: float, distance: float
) -> None:
    """Define a square camera that sees `width` centimetres at `distance`."""
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTranslateOp().Set(position)
    camera.AddRotateXOp().Set(pitch)
    camera.CreateHorizontalApertureAttr(24.0)
    camera.CreateVerticalApertureAttr(24.0)
    camera.CreateFocalLengthAttr(round(24.0 * distance / width, 3))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.1, 1000.0))


def _add_grid(stage: Usd.Stage, path: str, points: Doubles, st: Doubles) -> None:
    """Define a mesh of (rows, columns) vertices that binds the cloth.

    Its numbers lie in a crate file beside the stage, which stays small and legible.
    """
    rows, columns = points.shape[:2]
    corner = np.arange((rows - 1) * columns).reshape(rows - 1, columns)[:, :-1].ravel()
    indices = np.stack((corner, corner + 1, corner + columns + 1, corner + columns), axis=1)
    flat = points.reshape(-1, 3)
    a, b, c, d = (flat[indices[:, k]] for k in range(4))
    facing = np.cross(c - a, d - b)
    if np.sum(facing * (a - flat.mean(axis=0))) < 0:
        indices = indices[:, ::-1]
        facing = -facing
    normals = np.zeros_like(flat)
    for k in range(4):
        np.add.at(normals, indices[:, k], facing)
    normals = _closed(normals.reshape(points.shape), points)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    crate = Path(stage.GetRootLayer().realPath).with_suffix(".geometry.usdc")
    numbers = _empty(crate)
    mesh = _add_mesh(numbers, "/Mesh", flat, np.full(len(indices), 4), indices.ravel())
    numbers.SetDefaultPrim(mesh.GetPrim())
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(normals.reshape(-1, 3).astype(np.float32)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    primvar.Set(Vt.Vec2fArray.FromNumpy(st.reshape(-1, 2).astype(np.float32)))
    numbers.Save()
    prim = stage.DefinePrim(path, "Mesh")
    prim.GetReferences().AddReference(f"./{crate.name}")
    # The material comes with the cloth that is referenced here, so only the path is known.
    prim.AddAppliedSchema("MaterialBindingAPI")
    prim.CreateRelationship("material:binding", custom=False).SetTargets([Sdf.Path(MATERIAL)])


def _closed(normals: Doubles, points: Doubles) -> Doubles:
    """Return the normals with equal ones where rows or columns of vertices fall together."""
    normals = normals.copy()
    if np.allclose(points[:, 0], points[:, -1], atol=1e-9):
        seam = normals[:, 0] + normals[:, -1]
        normals[:, 0] = normals[:, -1] = seam
    for row in (0, -1):
        if np.allclose(points[row], points[row, :1], atol=1e-9):
            normals[row] = normals[row].sum(axis=0)
    return normals


def _add_mesh(
    stage: Usd.Stage, path: str, points: Doubles, counts: Any, indices: Any, color: Any = None
) -> UsdGeom.Mesh:
    mesh = UsdGeom.Mesh.Define(stage, path)
    single = points.astype(np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(single))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.asarray(counts, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.asarray(indices, np.int32)))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    low, high = single.min(axis=0), single.max(axis=0)
    mesh.CreateExtentAttr([Gf.Vec3f(*map(float, low)), Gf.Vec3f(*map(float, high))])
    if color is not None:
        mesh.CreateDisplayColorAttr([Gf.Vec3f(*color)])
    return mesh


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
