"""Stages that are broken in every way a file can be: a loss or one line, never a crash."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, Vt

from tests.render.stages import add_camera, add_dome, add_mesh, bind, new_stage, preview_material
from weaveusd.errors import StageError
from weaveusd.stage import captured_diagnostics

NAMES = Sdf.ValueTypeNames
FLOATS = st.sampled_from((0.0, 1.0, -1.0, 0.5, 3.0, 1e-30, 1e30, -1e38, float("inf"), float("nan")))
INTS = st.sampled_from((-(2**31), -1, 0, 0, 1, 1, 2, 3, 3, 3, 4, 7, 2**31 - 1))
VALUES: dict[Any, Any] = {
    NAMES.Point3fArray: st.lists(st.tuples(FLOATS, FLOATS, FLOATS), max_size=9).map(
        lambda rows: Vt.Vec3fArray([Gf.Vec3f(*row) for row in rows])
    ),
    NAMES.IntArray: st.lists(INTS, max_size=9).map(Vt.IntArray),
    NAMES.Int64Array: st.lists(INTS, max_size=5).map(Vt.Int64Array),
    NAMES.FloatArray: st.lists(FLOATS, max_size=9).map(Vt.FloatArray),
    NAMES.Float2Array: st.lists(st.tuples(FLOATS, FLOATS), max_size=9).map(
        lambda rows: Vt.Vec2fArray([Gf.Vec2f(*row) for row in rows])
    ),
    NAMES.QuathArray: st.lists(st.tuples(FLOATS, FLOATS), max_size=4).map(
        lambda rows: Vt.QuathArray([Gf.Quath(a, b, 0, 1) for a, b in rows])
    ),
    NAMES.Token: st.sampled_from(
        ("", "none", "loop", "bilinear", "linear", "bspline", "catmullRom", "pinned", "periodic",
         "leftHanded", "vertex", "X", "edgeOnly", "all", "invisible", "guide", "nonsense")
    ),
    NAMES.Double: FLOATS,
    NAMES.Float: FLOATS,
    NAMES.Bool: st.booleans(),
    NAMES.String: st.sampled_from(("", "text")),
    NAMES.Matrix4d: st.lists(FLOATS, min_size=16, max_size=16).map(lambda v: Gf.Matrix4d(*v)),
}  # fmt: skip
ATTRIBUTES = {
    "Mesh": ("points", "faceVertexCounts", "faceVertexIndices", "subdivisionScheme", "normals",
             "holeIndices", "creaseIndices", "creaseLengths", "creaseSharpnesses", "cornerIndices",
             "cornerSharpnesses", "interpolateBoundary", "orientation", "primvars:st",
             "primvars:displayColor", "primvars:displayOpacity", "doubleSided", "visibility"),
    "BasisCurves": ("points", "curveVertexCounts", "type", "basis", "wrap", "widths", "normals",
                    "primvars:displayColor"),
    "Points": ("points", "widths", "primvars:displayColor"),
    "PointInstancer": ("protoIndices", "positions", "scales", "orientations", "ids",
                       "invisibleIds", "velocities", "primvars:displayColor"),
    "Sphere": ("radius",), "Cube": ("size",), "Plane": ("width", "length", "axis"),
    "Cone": ("radius", "height", "axis"), "Capsule": ("radius", "height", "axis"),
    "Cylinder_1": ("radiusTop", "radiusBottom", "height", "axis"),
    "NurbsCurves": ("points",), "Volume": (), "GeomSubset": ("indices", "elementType"),
}  # fmt: skip
ANYWHERE = ("xformOp:transform", "purpose", "extent")
OWN_TYPES = {"xformOp:transform": NAMES.Matrix4d, "primvars:displayColor": NAMES.Point3fArray}


def type_of(kind: str, name: str) -> Any:
    """The type that the schema gives an attribute."""
    if name in OWN_TYPES:
        return OWN_TYPES[name]
    definition = Usd.SchemaRegistry().FindConcretePrimDefinition(kind)
    spec = definition.GetSchemaAttributeSpec(name) if definition else None
    return spec.typeName if spec and spec.typeName in VALUES else NAMES.FloatArray


@st.composite
def prims(draw: Any) -> tuple[str, list[tuple[str, Any, Any]]]:
    """A type of prim and attributes, mostly of their right types."""
    kind = draw(st.sampled_from(tuple(ATTRIBUTES)))
    chosen = draw(st.lists(st.sampled_from((*ATTRIBUTES[kind], *ANYWHERE)), unique=True))
    attributes = []
    for name in chosen:
        wrong = draw(st.integers(0, 9)) == 0
        type_name = draw(st.sampled_from(tuple(VALUES))) if wrong else type_of(kind, name)
        attributes.append((name, type_name, draw(VALUES[type_name])))
    return kind, attributes


def build(folder: Path, wanted: Any) -> Any:
    """A stage whose prims were written below USD's checks of types."""
    stage = new_stage(folder / "broken.usda")
    layer = stage.GetRootLayer()
    add_mesh(stage, "/World/Sound")
    for number, (kind, attributes) in enumerate(wanted):
        path = f"/World/Prim{number}"
        spec = Sdf.CreatePrimInLayer(layer, path)
        spec.specifier, spec.typeName = Sdf.SpecifierDef, kind
        for name, type_name, value in attributes:
            Sdf.AttributeSpec(spec, name, type_name).default = value
        if any(name == "xformOp:transform" for name, _, _ in attributes):
            order = Sdf.AttributeSpec(spec, "xformOpOrder", NAMES.TokenArray)
            order.default = Vt.TokenArray(["xformOp:transform"])
        if kind == "PointInstancer":
            targets = Sdf.RelationshipSpec(spec, "prototypes").targetPathList
            targets.explicitItems = [f"/World/Prim{k}" for k in range(number + 2)]
    add_dome(stage)
    add_camera(stage)
    return stage


def examples(count: int) -> Any:
    """Settings of a test of so many stages."""
    slow = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
    return settings(max_examples=count, deadline=None, derandomize=True, suppress_health_check=slow)


@examples(60)
@given(wanted=st.lists(prims(), max_size=4))
def test_no_stage_crashes_the_translator(mi: Any, tmp_path: Path, wanted: Any) -> None:
    check(tmp_path, wanted)


@pytest.mark.slow
@examples(1500)
@given(wanted=st.lists(prims(), min_size=1, max_size=7))
def test_many_broken_stages(mi: Any, tmp_path: Path, wanted: Any) -> None:
    check(tmp_path, wanted)


def check(folder: Path, wanted: Any) -> None:
    """A stage becomes a scene and losses of one line each, or is refused in one line."""
    from weaveusd.render.translate import translate

    with captured_diagnostics():
        stage = build(Path(tempfile.mkdtemp(dir=folder)), wanted)
    try:
        made = translate(stage, width=2, height=2)
    except StageError as error:
        told = [str(error)]
    else:
        told = [str(loss) for loss in made.losses]
        assert len(made.scene.shapes()) >= 1
    assert not any("\n" in line for line in told)


FACES = st.lists(st.lists(st.integers(0, 7), min_size=1, max_size=5), min_size=1, max_size=8)
SHARP = st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7), st.floats(-1, 12)), max_size=4)


@examples(40)
@given(
    faces=FACES,
    sharp=SHARP,
    flat=st.booleans(),
    scheme=st.sampled_from(("catmullClark", "bilinear", "loop")),
    border=st.sampled_from(("none", "edgeOnly", "edgeAndCorner")),
    seams=st.sampled_from(
        ("none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all")
    ),
)
def test_every_topology_can_be_subdivided(
    mi: Any,
    tmp_path: Path,
    faces: Any,
    sharp: Any,
    flat: bool,
    scheme: str,
    border: str,
    seams: str,
) -> None:
    from weaveusd.render.translate import translate

    stage = new_stage(Path(tempfile.mkdtemp(dir=tmp_path)) / "mesh.usda")
    indices = [k for face in faces for k in face]
    points = [(k % 2, k // 2 % 2, 0 if flat else k // 4) for k in range(8)]
    uv = [(n % 3, n % 2) for n in range(len(indices))]
    mesh = add_mesh(stage, "/World/Odd", points, [len(f) for f in faces], indices, st=uv)
    bind(mesh, preview_material(stage, diffuseColor=(0.5, 0.5, 0.5))[0])
    mesh.GetSubdivisionSchemeAttr().Set(scheme)
    mesh.CreateInterpolateBoundaryAttr(border)
    mesh.CreateFaceVaryingLinearInterpolationAttr(seams)
    mesh.CreateCreaseIndicesAttr([k for a, b, _ in sharp for k in (a, b)])
    mesh.CreateCreaseLengthsAttr([2] * len(sharp))
    mesh.CreateCreaseSharpnessesAttr([s for _, _, s in sharp])
    mesh.CreateCornerIndicesAttr([a for a, _, _ in sharp])
    mesh.CreateCornerSharpnessesAttr([s for _, _, s in sharp])
    add_mesh(stage, "/World/Sound")
    add_dome(stage)
    made = translate(stage, width=2, height=2)
    for shape in made.scene.shapes():
        found = mi.traverse(shape)
        for name in ("vertex_positions", "vertex_normals", "vertex_texcoords"):
            assert np.isfinite(np.array(found[name])).all() if name in found else True
