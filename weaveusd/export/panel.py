"""A flat panel of cloth: what a file shows that would otherwise hold a material alone."""

from __future__ import annotations

from pxr import Sdf, Usd, UsdGeom, UsdShade

from weaveusd.contract import DEFAULT_ST, MATERIAL_NAME

PANEL_MM = 100.0
"""About how long a side of the panel is."""

PANEL_NAME = "Panel"


def panel_size_mm(repeat_mm: tuple[float, float]) -> tuple[float, float]:
    """Return the whole repeats, one at least, that come closest to `PANEL_MM` on each side."""
    width, height = (max(1, round(PANEL_MM / length)) * length for length in repeat_mm)
    return width, height


def panel_corners(size_mm: tuple[float, float]) -> list[tuple[float, float]]:
    """Return x and y of the corners in metres, counter-clockwise, the middle being 0."""
    x, y = (length / 2000 for length in size_mm)
    return [(-x, -y), (x, -y), (x, y), (-x, y)]


def define_panel(layer: Sdf.Layer, size_mm: tuple[float, float]) -> None:
    """Define a mesh at the root of `layer`, in metres, that wears the default prim's material.

    It lies in the plane of x and y; its st is in metres from the lower left corner.
    """
    stage = Usd.Stage.Open(layer)
    mesh = UsdGeom.Mesh.Define(stage, Sdf.Path(f"/{PANEL_NAME}"))
    corners = panel_corners(size_mm)
    points = [(x, y, 0.0) for x, y in corners]
    mesh.CreatePointsAttr(points)
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateExtentAttr([points[0], points[2]])
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    mesh.CreateNormalsAttr([(0, 0, 1)] * 4)
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    left, bottom = corners[0]
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        DEFAULT_ST, Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    st.Set([(x - left, y - bottom) for x, y in corners])
    material = stage.GetDefaultPrim().GetPath().AppendChild(MATERIAL_NAME)
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(
        UsdShade.Material(stage.GetPrimAtPath(material))
    )
