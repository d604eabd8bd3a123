"""Small stages for the tests of the translator, written with USD itself."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from weaveusd import contract
from weaveusd.stage import require

require()

SQUARE = ((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))
SQUARE_ST = ((0, 0), (1, 0), (1, 1), (0, 1))


def new_stage(path: Path, up: str = "Y") -> Usd.Stage:
    """Return an empty stage in centimetres, saved under `path` by `Save`."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, up)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    return stage


def domed_stage(folder: Path, fov: float = 14.0) -> Usd.Stage:
    """Return a stage with a white dome and a camera that sees a little more than `SQUARE`."""
    stage = new_stage(folder / "scene.usda")
    add_dome(stage)
    add_camera(stage, fov=fov)
    return stage


def add_mesh(
    stage: Usd.Stage,
    path: str = "/World/Card",
    points: Any = SQUARE,
    counts: Any = (4,),
    indices: Any = (0, 1, 2, 3),
    st: Any = SQUARE_ST,
    color: Any = None,
) -> UsdGeom.Mesh:
    """Define a polygon mesh; by default the square from -1 to 1 that faces +z."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in points])
    mesh.CreateFaceVertexCountsAttr(list(counts))
    mesh.CreateFaceVertexIndicesAttr(list(indices))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    if st is not None:
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
        )
        primvar.Set([Gf.Vec2f(*map(float, uv)) for uv in st])
    if color is not None:
        mesh.CreateDisplayColorAttr([Gf.Vec3f(*map(float, color))])
    return mesh


def add_camera(
    stage: Usd.Stage, distance: float = 10.0, fov: float = 20.0, path: str = "/World/Camera"
) -> UsdGeom.Camera:
    """Define a square camera on the +z axis that looks along -z, `fov` degrees wide."""
    camera = UsdGeom.Camera.Define(stage, path)
    camera.AddTranslateOp().Set((0, 0, distance))
    camera.CreateHorizontalApertureAttr(20.0)
    camera.CreateVerticalApertureAttr(20.0)
    camera.CreateFocalLengthAttr(10.0 / float(np.tan(np.radians(fov / 2))))
    return camera


def add_dome(stage: Usd.Stage, radiance: float = 1.0) -> UsdLux.DomeLight:
    """Define a dome of one radiance."""
    dome = UsdLux.DomeLight.Define(stage, "/World/Dome")
    dome.CreateIntensityAttr(radiance)
    return dome


def bind(mesh: Any, material: UsdShade.Material) -> None:
    """Bind a material to a mesh or subset."""
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)


def preview_material(stage: Usd.Stage, path: str = "/World/Look", **inputs: Any) -> Any:
    """Define a material with a UsdPreviewSurface and return both."""
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    for name, value in inputs.items():
        kind = Sdf.ValueTypeNames.Float
        if isinstance(value, tuple):
            kind, value = Sdf.ValueTypeNames.Color3f, Gf.Vec3f(*value)
        elif isinstance(value, int):
            kind = Sdf.ValueTypeNames.Int
        shader.CreateInput(name, kind).Set(value)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return material, shader


def add_texture(
    stage: Usd.Stage, shader: UsdShade.Shader, feeding: str, file: str, output: str = "rgb",
    **inputs: Any,
) -> UsdShade.Shader:  # fmt: skip
    """Feed an input of `shader` from an image that follows `st`; return the texture node."""
    parent = shader.GetPath().GetParentPath()
    reader = UsdShade.Shader.Define(stage, parent.AppendChild("Reader"))
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
    reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
    node = UsdShade.Shader.Define(stage, parent.AppendChild(f"{feeding}Texture"))
    node.CreateIdAttr("UsdUVTexture")
    node.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(file)
    node.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(
        reader.ConnectableAPI(), "result"
    )
    for name, value in inputs.items():
        kind = Sdf.ValueTypeNames.Token
        if isinstance(value, tuple):
            kind, value = Sdf.ValueTypeNames.Float4, Gf.Vec4f(*value)
        node.CreateInput(name, kind).Set(value)
    node.CreateOutput(output, Sdf.ValueTypeNames.Float3)
    kind = Sdf.ValueTypeNames.Color3f if output == "rgb" else Sdf.ValueTypeNames.Float
    given = shader.GetInput(feeding) or shader.CreateInput(feeding, kind)
    given.ConnectToSource(node.ConnectableAPI(), output)
    return node


def write_image(path: Path, pixels: Any, kind: Any = None) -> Path:
    """Write an image of half floats, or of the OpenImageIO type given, row 0 at the top."""
    array = np.ascontiguousarray(np.atleast_3d(np.asarray(pixels)), np.float32)
    height, width, channels = array.shape
    writer = oiio.ImageOutput.create(str(path))
    assert writer.open(str(path), oiio.ImageSpec(width, height, channels, kind or oiio.HALF))
    assert writer.write_image(array)
    assert writer.close()
    return path


def write_cloth(folder: Path, arrays: Any) -> None:
    """Write the channels of a cloth (row 0 at v = 0) as the files that the shader names."""
    folder.mkdir(parents=True, exist_ok=True)
    top_down = {name: np.asarray(value)[::-1] for name, value in arrays.items()}
    for name in ("normal", "tangent", "base_color"):
        write_image(folder / f"{name}.exr", top_down[name])
    write_image(folder / "opacity.png", top_down["opacity"], oiio.UINT8)
    write_image(folder / "height.exr", np.zeros_like(top_down["opacity"]))
    stored = (top_down["yarn_id"] - contract.GAP) / 255
    write_image(folder / "yarn_id.png", stored, oiio.UINT8)


def cloth_material(
    stage: Usd.Stage, path: str, optics: Any, uv_scale: tuple[float, float],
    textures: str = "./textures", varname: str | None = None,
) -> UsdShade.Material:  # fmt: skip
    """Define a material with the exact shader on `outputs:mitsuba:surface`."""
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Cloth")
    shader.CreateIdAttr(contract.CLOTH_SHADER_ID)
    for name, file in contract.SHADER_FILES.items():
        shader.CreateInput(name, Sdf.ValueTypeNames.Asset).Set(f"{textures}/{file}")
    for name, values in optics.items():
        shader.CreateInput(name, Sdf.ValueTypeNames.FloatArray).Set(Vt.FloatArray(values))
    scale = shader.CreateInput(contract.SHADER_UV_SCALE, Sdf.ValueTypeNames.Float2)
    scale.Set(Gf.Vec2f(*uv_scale))
    if varname is not None:
        name_input = shader.CreateInput(contract.SHADER_VARNAME, Sdf.ValueTypeNames.String)
        name_input.Set(varname)
    output = material.CreateSurfaceOutput(contract.MITSUBA_CONTEXT)
    output.ConnectToSource(shader.ConnectableAPI(), "surface")
    return material


def picture(stage: Usd.Stage, size: int | tuple[int, int] = 33, spp: int = 64, **more: Any) -> Any:
    """Return pixels (H, W, 3) and losses of a small render of an open stage."""
    from weaveusd.render.trace import trace
    from weaveusd.render.translate import translate

    width, height = (size, size) if isinstance(size, int) else size
    made = translate(stage, width=width, height=height, **more)
    image = trace(made.scene, (width, height), spp, seed=3)
    return image * made.exposure, [str(loss) for loss in made.losses]


def middle(stage: Usd.Stage, **more: Any) -> Any:
    """Return the mean of the pixels in the middle of a small picture, and the losses."""
    image, losses = picture(stage, 17, 64, **more)
    return image[6:11, 6:11].mean(axis=(0, 1)), losses
