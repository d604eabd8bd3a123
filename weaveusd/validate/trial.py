"""Trial renders: a flat swatch of the asset, from its files, by the translator.

The swatch lies in the XY plane of a stage in meters, its texture coordinates in meters as well,
seen without perspective so that a picture holds whole repeats.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from weaveusd import contract
from weaveusd.render.model import FULL, Lod, RenderResult
from weaveusd.render.run import render
from weaveusd.validate.open_asset import OpenAsset

HALF_SIDE = 0.1
"""Half the side of the swatch in meters."""

DEPTH = 0.01
"""Distance in meters from the swatch to the black bed below it."""

MOST_MM = 25.0
"""The side of a picture, about: as many whole repeats as fit, and at least one."""


@dataclass(frozen=True, slots=True)
class Setting:
    """Light and eye: angles in degrees, from the swatch's normal and around it.

    `lamp` is the angle of a distant light, None for none; `sky` the radiance of a white dome.
    `bed` lays the swatch on black. A picture shows `span` times as many repeats along either side
    with a pixel for each `span`² of those of one.
    """

    tilt: float = 0.0
    turn: float = 0.0
    sky: float = 1.0
    lamp: float | None = None
    bed: bool = True
    span: int = 1


class Trial:
    """Renders one asset's swatch in settings, in a folder of its own."""

    def __init__(self, asset: OpenAsset, folder: Path) -> None:
        self._asset, self._folder = asset, folder
        self._count = 0

    def render(
        self,
        setting: Setting,
        *,
        spp: int,
        seed: int = 0,
        context: str = contract.MITSUBA_CONTEXT,
        lod: Lod = FULL,
    ) -> RenderResult:
        """Return the picture of whole repeats in a setting; the longer side has the profile's size.

        `lod` is the detail of the cloth, as in `weaveusd.render.run.render`.

        Raises
        ------
        StageError
            When the translator refuses the asset.
        """
        self._count += 1
        path = self._folder / f"trial_{self._count}.usda"
        width_mm, height_mm = write_stage(self._asset, setting, path)
        size = self._asset.profile.size / setting.span
        scale = size / max(width_mm, height_mm)
        return render(
            path,
            width=max(8, round(width_mm * scale)),
            height=max(8, round(height_mm * scale)),
            spp=spp,
            seed=seed,
            context=context,
            lod=lod,
        )


@contextmanager
def trials(asset: OpenAsset) -> Iterator[Trial]:
    """Yield what renders `asset`; its stages are gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="weaveusd-") as folder:
        yield Trial(asset, Path(folder))


def write_stage(asset: OpenAsset, setting: Setting, path: Path) -> tuple[float, float]:
    """Write the stage of `setting` to `path`; return the width and height in mm that are seen."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    cloth = stage.DefinePrim("/World/Cloth")
    cloth.GetReferences().AddReference(str(asset.entry))
    if asset.colorway:
        cloth.GetVariantSet(contract.COLORWAYS).SetVariantSelection(asset.colorway)
    root = asset.root.GetPath() if asset.root else Sdf.Path.absoluteRootPath
    material = asset.material.GetPath().ReplacePrefix(root, cloth.GetPath())
    _sheet(stage, "/World/Swatch", HALF_SIDE, 0.0, material)
    if setting.bed:
        _sheet(stage, "/World/Bed", 100.0, -DEPTH, _black(stage))
    if setting.sky:
        UsdLux.DomeLight.Define(stage, "/World/Sky").CreateIntensityAttr(setting.sky)
    if setting.lamp is not None:
        lamp = UsdLux.DistantLight.Define(stage, "/World/Lamp")
        lamp.CreateIntensityAttr(math.pi)
        lamp.CreateAngleAttr(0.53)
        lamp.CreateNormalizeAttr(True)
        # A distant light shines along -Z; 45° around, so that neither system is preferred.
        UsdGeom.XformCommonAPI(lamp).SetRotate(Gf.Vec3f(0, setting.lamp, 45))
    width_mm, height_mm = _seen(asset)
    seen = width_mm * setting.span, height_mm * setting.span
    _eye(stage, setting, seen)
    stage.GetRootLayer().Save()
    return seen


def _sheet(stage: Usd.Stage, path: str, half: float, z: float, material: Sdf.Path) -> None:
    mesh = UsdGeom.Mesh.Define(stage, path)
    corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
    mesh.CreatePointsAttr(Vt.Vec3fArray([Gf.Vec3f(x, y, z) for x, y in corners]))
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        contract.DEFAULT_ST, Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    st.Set(Vt.Vec2fArray([Gf.Vec2f(x + half, y + half) for x, y in corners]))
    prim = mesh.GetPrim()
    UsdShade.MaterialBindingAPI.Apply(prim)
    prim.CreateRelationship("material:binding").SetTargets([material])


def _black(stage: Usd.Stage) -> Sdf.Path:
    material = UsdShade.Material.Define(stage, "/World/Black")
    shader = UsdShade.Shader.Define(stage, "/World/Black/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    names = Sdf.ValueTypeNames
    for name in ("diffuseColor", "specularColor"):
        shader.CreateInput(name, names.Color3f).Set(Gf.Vec3f(0))
    shader.CreateInput("useSpecularWorkflow", names.Int).Set(1)
    shader.CreateInput("roughness", names.Float).Set(1.0)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return Sdf.Path("/World/Black")


def _seen(asset: OpenAsset) -> tuple[float, float]:
    """Return the width and height in mm of as many whole repeats as are looked at."""
    sizes = []
    for name in ("repeatWidth", "repeatHeight"):
        repeat = asset.cloth(name)
        if not isinstance(repeat, float) or not 1e-3 <= repeat <= HALF_SIDE * 1000:
            repeat = MOST_MM  # attribute/cloth and shader/physical-size report it
        sizes.append(repeat * max(1, math.floor(MOST_MM / repeat)))
    return sizes[0], sizes[1]


def _eye(stage: Usd.Stage, setting: Setting, seen: tuple[float, float]) -> None:
    """Define a camera without perspective that sees `seen` mm, foreshortened as it is tilted."""
    camera = UsdGeom.Camera.Define(stage, "/World/Eye")
    camera.CreateProjectionAttr(UsdGeom.Tokens.orthographic)
    tilt, turn = math.radians(setting.tilt), math.radians(setting.turn)
    # The aperture is in tenths of a unit; the eye is tilted around X, then turned by the swatch.
    camera.CreateHorizontalApertureAttr(seen[0] / 1000 * 10)
    camera.CreateVerticalApertureAttr(seen[1] / 1000 * 10 * math.cos(tilt))
    camera.CreateClippingRangeAttr(Gf.Vec2f(1e-3, 100.0))
    away = Gf.Vec3d(
        math.sin(tilt) * math.sin(turn), -math.sin(tilt) * math.cos(turn), math.cos(tilt)
    )
    up = Gf.Vec3d(-math.sin(turn), math.cos(turn), 0)
    view = Gf.Matrix4d().SetLookAt(away, Gf.Vec3d(0), up)
    UsdGeom.Xformable(camera).AddTransformOp().Set(view.GetInverse())
