"""Networks as stages hand them over: graphs within graphs, and broken ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdShade

from tests.render.networks import (
    QUADRANTS,
    card_stage,
    large_texels,
    matte,
    node,
    quadrants,
    surface,
)
from tests.render.stages import add_mesh, bind, picture, preview_material, write_image

TYPES = Sdf.ValueTypeNames
FALLBACK = 0.8  # base_color of OpenPBR


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return card_stage(tmp_path)


def test_values_reach_through_graphs_and_the_materials_interface(mi: Any, stage: Any) -> None:
    shader = matte(stage, (0, 0, 0))
    material = UsdShade.Material(stage.GetPrimAtPath("/World/Look"))
    paint = material.CreateInput("paint", TYPES.Color3f)
    paint.Set(Gf.Vec3f(0.2, 0.4, 0.6))
    graph = UsdShade.NodeGraph.Define(stage, "/World/Look/Graph")
    inner = graph.CreateInput("paint", TYPES.Color3f)
    inner.ConnectToSource(paint)
    half = node(
        stage, "Graph/Half", "ND_multiply_color3FA", in1=("color3f", inner), in2=("float", 0.5)
    )
    out = graph.CreateOutput("out", TYPES.Color3f)
    out.ConnectToSource(half)
    shader.GetInput("base_color").ConnectToSource(out)
    found, losses = quadrants(stage)
    assert losses == []
    assert found.mean(axis=(0, 1)) == pytest.approx((0.1, 0.2, 0.3), rel=0.02)


def test_a_surface_may_come_out_of_a_graph(mi: Any, stage: Any) -> None:
    matte(stage, (0.1, 0.5, 0.2))
    material = UsdShade.Material(stage.GetPrimAtPath("/World/Look"))
    graph = UsdShade.NodeGraph.Define(stage, "/World/Look/Graph")
    shader = UsdShade.Shader(stage.GetPrimAtPath("/World/Look/Surface"))
    out = graph.CreateOutput("surface", TYPES.Token)
    out.ConnectToSource(shader.GetOutput("out"))
    material.GetSurfaceOutput("mtlx").ConnectToSource(out)
    found, losses = quadrants(stage)
    assert losses == []
    assert found.mean(axis=(0, 1)) == pytest.approx((0.1, 0.5, 0.2), rel=0.02)


def in_circle(stage: Any) -> None:
    first = node(stage, "A", "ND_add_color3", in1=("color3f", (0, 0, 0)))
    second = node(stage, "B", "ND_add_color3", in1=("color3f", first))
    UsdShade.Shader(first.GetPrim()).GetInput("in1").ConnectToSource(second)
    matte(stage, second)


def graphs_in_circle(stage: Any) -> None:
    outputs = []
    for name in ("A", "B"):
        graph = UsdShade.NodeGraph.Define(stage, f"/World/Look/{name}")
        outputs.append(graph.CreateOutput("out", TYPES.Color3f))
    outputs[0].ConnectToSource(outputs[1])
    outputs[1].ConnectToSource(outputs[0])
    matte(stage, outputs[0])


def loose_end(stage: Any) -> None:
    matte(stage, (0, 0, 0)).GetInput("base_color").GetAttr().SetConnections(
        [Sdf.Path("/World/Look/Gone.outputs:out")]
    )


def empty_graph(stage: Any) -> None:
    graph = UsdShade.NodeGraph.Define(stage, "/World/Look/Graph")
    matte(stage, graph.CreateOutput("out", TYPES.Color3f))


def no_shader(stage: Any) -> None:
    prim = stage.DefinePrim("/World/Look/Thing", "Xform")
    prim.CreateAttribute("outputs:out", TYPES.Color3f)
    matte(stage, (0, 0, 0)).GetInput("base_color").GetAttr().SetConnections(
        [Sdf.Path("/World/Look/Thing.outputs:out")]
    )


def no_number(stage: Any) -> None:
    shader = matte(stage, (0, 0, 0))
    stage.RemovePrim("/World/Look/Surface.inputs:base_color")
    prim = shader.GetPrim()
    prim.RemoveProperty("inputs:base_color")
    prim.CreateAttribute("inputs:base_color", TYPES.String).Set("red")


def not_finite(stage: Any) -> None:
    matte(stage, (float("nan"), float("inf"), 0))


def absurd(stage: Any) -> None:
    matte(stage, (3e38, 3e38, 3e38))


def too_long(stage: Any) -> None:
    output = node(stage, "N0", "ND_constant_color3", value=("color3f", (0, 0, 0)))
    for k in range(1, 200):
        output = node(stage, f"N{k}", "ND_add_color3", in1=("color3f", output))
    matte(stage, output)


def too_wide(stage: Any) -> None:
    leaves = [
        node(stage, f"L{k}", "ND_constant_color3", value=("color3f", (0, 0, 0))) for k in range(600)
    ]
    while len(leaves) > 1:
        pairs = zip(leaves[::2], leaves[1::2] + leaves[:1], strict=False)
        level = len(leaves)
        leaves = [
            node(stage, f"A{level}_{k}", "ND_add_color3", in1=("color3f", a), in2=("color3f", b))
            for k, (a, b) in enumerate(pairs)
        ]
    matte(stage, leaves[0])


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        (in_circle, "feeds itself"),
        (graphs_in_circle, "is connected in a circle"),
        (loose_end, "is connected to /World/Look/Gone.outputs:out, which is not"),
        (empty_graph, "/World/Look/Graph.outputs:out is connected to nothing"),
        (no_shader, "/World/Look/Thing feeds it and is no shader"),
        (
            no_number,
            "/World/Look/Surface: inputs:base_color is a string, expected one to four numbers",
        ),
        (not_finite, "expected finite numbers"),
        (absurd, "expected finite numbers"),
        (too_wide, "network has more than 512 nodes"),
        (too_long, "more than 48 nodes feed each other"),
    ],
)
def test_a_broken_input_is_a_loss_and_its_default(
    mi: Any, stage: Any, broken: Any, said: str, capfd: Any
) -> None:
    broken(stage)
    found, losses = quadrants(stage)
    assert said in losses[0]
    assert len(losses) == 1 or broken is too_wide
    assert "\n" not in losses[0]
    assert np.isfinite(found).all()
    if broken not in (in_circle, too_long, too_wide):
        assert found.mean() == pytest.approx(FALLBACK, rel=0.02)
    assert capfd.readouterr().err == ""


def test_metal_is_not_transparent(mi: Any, stage: Any) -> None:
    surface(
        stage, "ND_open_pbr_surface_surfaceshader", transmission_weight=("float", 1.0),
        base_metalness=("float", 1.0), base_color=("color3f", (0.2, 0.2, 0.2)),
    )  # fmt: skip
    assert quadrants(stage)[0].mean() == pytest.approx(0.2, abs=0.02)


def test_shared_nodes_are_computed_once(mi: Any, stage: Any) -> None:
    # Forty doublings of a node that is used twice: 2^40 evaluations if each were its own.
    output = node(
        stage, "N0", "ND_geompropvalue_color3", geomprop=("string", "none"),
        default=("color3f", (1e-13, 1e-13, 1e-13)),
    )  # fmt: skip
    for k in range(1, 41):
        output = node(
            stage, f"N{k}", "ND_add_color3", in1=("color3f", output), in2=("color3f", output)
        )
    matte(stage, output)
    found, _ = quadrants(stage)
    assert found.mean() == pytest.approx(2**40 * 1e-13, rel=0.02)


def test_a_file_that_is_a_bomb_of_fields_is_refused(mi: Any, stage: Any, monkeypatch: Any) -> None:
    from weaveusd.render import fields

    monkeypatch.setattr(fields, "MAX_FIELDS", 8)
    matte(stage, (0.1, 0.2, 0.3))
    _, losses = quadrants(stage)
    assert losses == [
        "/World/Look/Surface: materials: more than 8 distinct values in networks (dropped)"
    ]


def test_the_specular_workflow_reflects_its_color(mi: Any, stage: Any) -> None:
    material, _ = preview_material(
        stage, useSpecularWorkflow=1, specularColor=(0.9, 0.5, 0.2), diffuseColor=(0.0, 0.0, 0.0),
        roughness=0.3,
    )  # fmt: skip
    bind(add_mesh(stage), material)
    found, losses = quadrants(stage)
    assert losses == []
    # Along the normal F0 is reflected; a furnace shows the albedo, which is a little more.
    assert found.mean(axis=(0, 1)) == pytest.approx((0.9, 0.5, 0.2), abs=0.03)


@pytest.mark.parametrize(("mode", "expected"), [("transparent", 1.0), ("presence", 1.0)])
def test_in_a_white_furnace_opacity_takes_no_light_away(
    mi: Any, stage: Any, mode: str, expected: float
) -> None:
    material, shader = preview_material(stage, diffuseColor=(1.0, 1.0, 1.0), opacity=0.4)
    shader.CreateInput("opacityMode", TYPES.Token).Set(mode)
    bind(add_mesh(stage), material)
    found, losses = quadrants(stage)
    assert losses == []
    assert found.mean() == pytest.approx(expected, abs=0.01)


def test_clear_opacity_keeps_the_highlight_that_presence_fades(mi: Any, stage: Any) -> None:
    # A lamp in front of a black pane whose opacity is 0: F0 = 1/25 of its light comes back.
    from pxr import UsdLux

    stage.RemovePrim("/World/Dome")
    lamp = UsdLux.RectLight.Define(stage, "/World/Lamp")
    lamp.AddTranslateOp().Set((0, 0, 30))
    lamp.CreateWidthAttr(1000.0)
    lamp.CreateHeightAttr(1000.0)
    material, shader = preview_material(
        stage, diffuseColor=(0.0, 0.0, 0.0), opacity=0.0, roughness=0.2
    )
    mode = shader.CreateInput("opacityMode", TYPES.Token)
    bind(add_mesh(stage), material)
    shown = {}
    for name in ("transparent", "presence"):
        mode.Set(name)
        shown[name] = quadrants(stage)[0].mean()
    assert shown["transparent"] == pytest.approx(0.04, rel=0.1)
    assert shown["presence"] == pytest.approx(0, abs=1e-6)


def test_a_normal_leans_the_same_way_where_st_is_mirrored(
    mi: Any, stage: Any, tmp_path: Path
) -> None:
    # The map leans to +s. Mirrored, s runs to -x, and the light from -x finds it brighter.
    from pxr import UsdLux

    stage.RemovePrim("/World/Dome")
    sun = UsdLux.DistantLight.Define(stage, "/World/Sun")
    turn = sun.AddRotateYOp()
    sun.CreateAngleAttr(0.0)
    sun.CreateIntensityAttr(1.0)
    lean = np.array((0.6, 0.0, 0.8))
    write_image(tmp_path / "normal.exr", np.tile((lean + 1) / 2, (4, 4, 1)))
    mapped = node(
        stage, "Normal", "ND_normalmap_float", in_=(
            "float3", node(stage, "Map", "ND_image_vector3", file=("asset", "./normal.exr"))
        ),
    )  # fmt: skip
    matte(stage, (0.5, 0.5, 0.5), geometry_normal=("float3", mapped))
    shown = []
    for mirrored in (False, True):
        stage.RemovePrim("/World/Card")
        s = (1, 0, 0, 1) if mirrored else (0, 1, 1, 0)
        mesh = add_mesh(stage, st=tuple(zip(s, (0, 0, 1, 1), strict=True)))
        bind(mesh, UsdShade.Material(stage.GetPrimAtPath("/World/Look")))
        turn.Set(-60.0 if mirrored else 60.0)
        image, losses = picture(stage, 8, 16)
        assert losses == []
        shown.append(image.mean())
    cosine = 0.6 * np.sin(np.radians(60)) + 0.8 * 0.5
    assert shown == pytest.approx([0.5 / np.pi * cosine] * 2, rel=0.01)


def test_emission_is_its_color_times_its_strength(mi: Any, stage: Any) -> None:
    stage.RemovePrim("/World/Dome")
    surface(
        stage, "ND_open_pbr_surface_surfaceshader", emission_color=("color3f", (0.5, 1, 0.25)),
        emission_luminance=("float", 3.0), base_weight=("float", 0.0),
        specular_weight=("float", 0.0),
    )  # fmt: skip
    found, losses = quadrants(stage)
    assert losses == []
    assert found.mean(axis=(0, 1)) == pytest.approx((1.5, 3, 0.75), rel=0.01)


def test_a_direction_out_of_the_world_is_said(mi: Any, stage: Any) -> None:
    tilted = node(stage, "Tilted", "ND_constant_vector3", value=("float3", (0.6, 0, 0.8)))
    painted = node(stage, "Painted", "ND_geompropvalue_vector3", geomprop=("string", "flow"))
    matte(
        stage, (0.5, 0.5, 0.5), geometry_normal=("float3", tilted),
        geometry_tangent=("float3", painted), geometry_coat_normal=("float3", (1, 1, 0)),
    )  # fmt: skip
    _, losses = quadrants(stage)
    assert losses[:2] == [
        "/World/Look/Surface: geometry_normal is taken to be in tangent space (approximated)",
        "/World/Look/Surface: geometry_tangent from a primvar (dropped)",
    ]


def test_two_cloths_of_one_name_stay_two(mi: Any, tmp_path: Path) -> None:
    from pxr import Usd

    from tests.render.cloths import optics, plain_arrays
    from tests.render.stages import cloth_material, write_cloth
    from weaveusd.render.materials import Looks
    from weaveusd.render.model import Losses

    stage = card_stage(tmp_path)
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        layer = Usd.Stage.CreateNew(str(tmp_path / name / "cloth.usda"))
        write_cloth(tmp_path / name / "textures", plain_arrays())
        made = cloth_material(layer, "/Cloth", optics("linen"), (1.0, 1.0))
        layer.SetDefaultPrim(made.GetPrim())
        layer.GetRootLayer().Save()
        for k in range(2):
            prim = stage.DefinePrim(f"/World/{name}{k}")
            prim.GetReferences().AddReference(f"./{name}/cloth.usda")
            bind(add_mesh(stage, f"/World/Card_{name}{k}"), UsdShade.Material(prim))
    looks = Looks("mitsuba", Usd.TimeCode.EarliestTime(), Losses())
    found = [looks.of(stage.GetPrimAtPath(f"/World/Card_{n}")) for n in ("a0", "a1", "b0")]
    assert found[0] is found[1]
    assert found[0] is not found[2]


def test_networks_are_shown_in_the_scalar_variant_too(mi: Any, stage: Any, tmp_path: Path) -> None:
    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    image = node(stage, "Image", "ND_image_color3", file=("asset", "./map.exr"))
    rough = node(
        stage, "Rough", "ND_geompropvalue_float", geomprop=("string", "none"),
        default=("float", 0.6),
    )  # fmt: skip
    surface(
        stage, "ND_open_pbr_surface_surfaceshader", base_color=("color3f", image),
        specular_roughness=("float", rough), specular_weight=("float", 0.0),
    )  # fmt: skip
    mi.set_variant("scalar_rgb")
    seen, _ = picture(stage, 8, 16)
    found = seen.reshape(2, 4, 2, 4, 3)[:, 1:3, :, 1:3].mean(axis=(1, 3))
    np.testing.assert_allclose(found, QUADRANTS, atol=0.1)


def test_a_ball_of_glass_vanishes_in_a_white_furnace(mi: Any, stage: Any) -> None:
    from pxr import UsdGeom

    surface(
        stage, "ND_open_pbr_surface_surfaceshader", transmission_weight=("float", 1.0),
        specular_roughness=("float", 0.1),
    )  # fmt: skip
    stage.RemovePrim("/World/Card")
    ball = UsdGeom.Sphere.Define(stage, "/World/Ball")
    bind(ball, UsdShade.Material(stage.GetPrimAtPath("/World/Look")))
    found, _ = quadrants(stage)
    # One bounce between facets is not followed by the microfacets of Mitsuba.
    assert found.mean() == pytest.approx(1, abs=0.02)
