"""MaterialX networks in USD: every node against what its definition says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from pxr import Sdf, UsdShade

from tests.render.networks import (
    QUADRANTS,
    card_stage,
    large_texels,
    matte,
    node,
    quadrants,
    stretch_of,
    surface,
)
from tests.render.stages import picture, preview_material, write_image

OPENPBR = "ND_open_pbr_surface_surfaceshader"
STANDARD = "ND_standard_surface_surfaceshader"
GLTF = "ND_gltf_pbr_surfaceshader"


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    return card_stage(tmp_path)


def image_node(stage: Any, tmp_path: Path, kind: str = "color3", **inputs: Any) -> Any:
    """An image node with the quadrants."""
    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    return node(stage, "Image", f"ND_image_{kind}", file=("asset", "./map.exr"), **inputs)


def color_of(stage: Any, output: Any, tmp_path: Path) -> Any:
    """The color that an output gives to the diffuse light of a card."""
    matte(stage, output)
    found, losses = quadrants(stage)
    assert losses == []
    return found


def test_an_image_is_the_right_way_up(mi: Any, stage: Any, tmp_path: Path) -> None:
    found = color_of(stage, image_node(stage, tmp_path), tmp_path)
    np.testing.assert_allclose(found, QUADRANTS, atol=0.03)


def test_a_tiled_image_repeats_and_is_offset(mi: Any, stage: Any, tmp_path: Path) -> None:
    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    tiled = node(
        stage, "Image", "ND_tiledimage_color3", file=("asset", "./map.exr"),
        uvtiling=("float2", (1, 1)), uvoffset=("float2", (0.5, 0)),
        realworldimagesize=("float2", (2, 2)), realworldtilesize=("float2", (2, 2)),
    )  # fmt: skip
    # st - (0.5, 0): the columns change places.
    np.testing.assert_allclose(color_of(stage, tiled, tmp_path), QUADRANTS[:, ::-1], atol=0.03)


@pytest.mark.parametrize("order", [0, 1])
def test_place2d_divides_by_scale_turns_clockwise_and_subtracts(
    mi: Any, stage: Any, tmp_path: Path, order: int
) -> None:
    st = node(stage, "St", "ND_texcoord_vector2")
    placed = node(
        stage, "Place", "ND_place2d_vector2", texcoord=("float2", st),
        pivot=("float2", (0.5, 0.5)), scale=("float2", (1, 0.5)), rotate=("float", 90.0),
        offset=("float2", (0.25, 0)), operationorder=("int", order),
    )  # fmt: skip
    found = color_of(stage, image_node(stage, tmp_path, texcoord=("float2", placed)), tmp_path)
    compared = 0
    for row in range(2):
        for column in range(2):
            s, t = 0.25 + 0.5 * column - 0.5, 0.75 - 0.5 * row - 0.5
            if order == 0:
                s, t = s, t / 0.5
                s, t = t - 0.25, -s
            else:
                s, t = t, -(s - 0.25)
                t /= 0.5
            u, v = (s + 0.5) % 1, (t + 0.5) % 1
            if min(abs(2 * u - round(2 * u)), abs(2 * v - round(2 * v))) > 0.3:
                expected = QUADRANTS[int((1 - v) * 2), int(u * 2)]
                np.testing.assert_allclose(found[row, column], expected, atol=0.06)
                compared += 1
    assert compared or order == 1


def test_beyond_a_constant_border_is_the_default(mi: Any, stage: Any, tmp_path: Path) -> None:
    st = node(stage, "St", "ND_texcoord_vector2")
    twice = node(stage, "Twice", "ND_multiply_vector2", in1=("float2", st), in2=("float2", (2, 2)))
    image = image_node(
        stage, tmp_path, texcoord=("float2", twice), default=("color3f", (0.3, 0.4, 0.5)),
        uaddressmode=("string", "constant"), vaddressmode=("string", "constant"),
    )  # fmt: skip
    matte(stage, image)
    seen, losses = picture(stage, 32, 64)

    assert losses == []

    # The image fills the quarter at s, t < 1/2, which is at the lower left.
    def at(row: int, column: int) -> Any:
        return seen[row - 2 : row + 2, column - 2 : column + 2].mean(axis=(0, 1))

    np.testing.assert_allclose(at(20, 4), QUADRANTS[0, 0], atol=0.03)
    np.testing.assert_allclose(at(28, 12), QUADRANTS[1, 1], atol=0.03)
    np.testing.assert_allclose(at(4, 4), (0.3, 0.4, 0.5), atol=0.03)
    np.testing.assert_allclose(at(28, 28), (0.3, 0.4, 0.5), atol=0.03)


@pytest.mark.parametrize(
    ("space", "decoded"), [("srgb_texture", True), ("lin_rec709", False), (None, False)]
)
def test_colors_are_decoded_by_the_name_of_their_space(
    mi: Any, stage: Any, tmp_path: Path, space: str | None, decoded: bool
) -> None:
    write_image(tmp_path / "gray.png", np.full((4, 4, 3), 0.5), oiio.UINT8)
    output = node(stage, "Image", "ND_image_color3", file=("asset", "./gray.png"))
    if space:
        stage.GetAttributeAtPath("/World/Look/Image.inputs:file").SetColorSpace(space)
    value = 128 / 255
    expected = ((value + 0.055) / 1.055) ** 2.4 if decoded else value
    assert color_of(stage, output, tmp_path).mean() == pytest.approx(expected, rel=0.02)


def test_acescg_becomes_rec709(mi: Any, stage: Any) -> None:
    shader = matte(stage, (0.4, 0.5, 0.6))
    shader.GetInput("base_color").GetAttr().SetColorSpace("acescg")
    found, losses = quadrants(stage)
    # ACEScg to linear Rec.709 with Bradford, S-2014-004 and ITU-R BT.709.
    expected = (
        np.array(((1.70505, -0.62179, -0.08326), (-0.13026, 1.14080, -0.01055),
                  (-0.02400, -0.12897, 1.15297)))
        @ (0.4, 0.5, 0.6)
    )  # fmt: skip
    assert found.mean(axis=(0, 1)) == pytest.approx(expected, rel=0.02)
    assert losses == []


A, B = (0.2, 0.4, 0.6), (0.5, 0.3, 0.1)


@pytest.mark.parametrize(
    ("identifier", "inputs", "expected"),
    [
        ("ND_add_color3", {"in1": ("color3f", A), "in2": ("color3f", B)}, (0.7, 0.7, 0.7)),
        ("ND_subtract_color3", {"in1": ("color3f", A), "in2": ("color3f", (0.1,) * 3)},
         (0.1, 0.3, 0.5)),
        ("ND_multiply_color3", {"in1": ("color3f", A), "in2": ("color3f", B)}, (0.1, 0.12, 0.06)),
        ("ND_multiply_color3FA", {"in1": ("color3f", A), "in2": ("float", 0.5)}, (0.1, 0.2, 0.3)),
        ("ND_divide_color3FA", {"in1": ("color3f", A), "in2": ("float", 2.0)}, (0.1, 0.2, 0.3)),
        ("ND_mix_color3", {"fg": ("color3f", A), "bg": ("color3f", B), "mix": ("float", 0.25)},
         (0.425, 0.325, 0.225)),
        ("ND_invert_color3", {"in_": ("color3f", A)}, (0.8, 0.6, 0.4)),
        ("ND_power_color3FA", {"in1": ("color3f", A), "in2": ("float", 2.0)}, (0.04, 0.16, 0.36)),
        ("ND_clamp_color3FA", {"in_": ("color3f", A), "low": ("float", 0.3),
                               "high": ("float", 0.5)}, (0.3, 0.4, 0.5)),
        ("ND_remap_color3FA", {"in_": ("color3f", A), "inlow": ("float", 0.0),
                               "inhigh": ("float", 2.0)}, (0.1, 0.2, 0.3)),
        ("ND_min_color3", {"in1": ("color3f", A), "in2": ("color3f", B)}, (0.2, 0.3, 0.1)),
        ("ND_max_color3", {"in1": ("color3f", A), "in2": ("color3f", B)}, (0.5, 0.4, 0.6)),
        ("ND_luminance_color3", {"in_": ("color3f", (0.2, 0.2, 0.2))}, (0.2, 0.2, 0.2)),
        ("ND_atan2_float", {"iny": ("float", 1.0), "inx": ("float", -1.0)}, (2.3561945,)),
        ("ND_atan2_float", {"iny": ("float", 0.0), "inx": ("float", 0.0)}, (0.0,)),
        ("ND_magnitude_vector2", {"in_": ("float2", (0.3, -0.4))}, (0.5,)),
        ("ND_constant_color3", {"value": ("color3f", A)}, A),
        ("ND_convert_float_color3", {"in_": ("float", 0.3)}, (0.3, 0.3, 0.3)),
        ("ND_swizzle_color3_color3", {"in_": ("color3f", A), "channels": ("string", "br0")},
         (0.6, 0.2, 0.0)),
        ("ND_combine3_color3", {"in1": ("float", 0.1), "in2": ("float", 0.2),
                                "in3": ("float", 0.3)}, (0.1, 0.2, 0.3)),
        ("ND_switch_color3", {"in1": ("color3f", A), "in2": ("color3f", B), "which": ("int", 1)},
         B),
        ("ND_ifgreater_color3", {"value1": ("float", 2.0), "value2": ("float", 1.0),
                                 "in1": ("color3f", A), "in2": ("color3f", B)}, A),
    ],
)  # fmt: skip
def test_nodes_compute_what_they_are_defined_to(
    mi: Any, stage: Any, identifier: str, inputs: dict[str, Any], expected: Any
) -> None:
    assert value_of(stage, node(stage, "Node", identifier, **inputs)) == pytest.approx(
        expected, abs=1e-6
    )


def value_of(stage: Any, output: Any) -> Any:
    """The constant that an output gives, read without a picture."""
    from pxr import Usd

    from weaveusd.render.materials import Looks
    from weaveusd.render.model import Losses
    from weaveusd.render.network import Network

    losses = Losses()
    looks = Looks("mtlx", Usd.TimeCode.EarliestTime(), losses)
    net = Network(looks.time, losses, looks._fields, looks._rasters, looks._readers)
    found = net.output(UsdShade.Shader(output.GetPrim()), str(output.GetBaseName()))
    assert losses.as_tuple() == ()
    assert found is not None
    return found.numbers


def test_extract_and_separate_take_one_component(mi: Any, stage: Any) -> None:
    one = node(stage, "X", "ND_extract_color3", in_=("color3f", A), index=("int", 2))
    assert value_of(stage, one) == pytest.approx((0.6,))
    other = node(stage, "S", "ND_separate3_color3", "outg", in_=("color3f", A))
    assert value_of(stage, other) == pytest.approx((0.4,))


def test_a_texture_can_be_computed_with(mi: Any, stage: Any, tmp_path: Path) -> None:
    image = image_node(stage, tmp_path)
    dark = node(stage, "Dark", "ND_multiply_color3FA", in1=("color3f", image), in2=("float", 0.5))
    mixed = node(
        stage, "Mixed", "ND_mix_color3", fg=("color3f", dark), bg=("color3f", (1, 1, 1)),
        mix=("float", 0.5),
    )  # fmt: skip
    found = color_of(stage, mixed, tmp_path)
    np.testing.assert_allclose(found, QUADRANTS * 0.25 + 0.5, atol=0.03)


def test_an_unknown_node_is_named_and_its_input_has_its_default(mi: Any, stage: Any) -> None:
    matte(stage, node(stage, "Noise", "ND_fractal3d_color3"))
    found, losses = quadrants(stage)
    assert losses == ["/World/Look/Noise: node ND_fractal3d_color3 (dropped)"]
    assert found.mean() == pytest.approx(0.8, rel=0.02)


def test_a_missing_image_shows_its_default(mi: Any, stage: Any) -> None:
    matte(stage, node(
        stage, "Image", "ND_image_color3", file=("asset", "./gone.png"),
        default=("color3f", (0.1, 0.2, 0.3)),
    ))  # fmt: skip
    found, losses = quadrants(stage)
    assert losses == [
        "/World/Look/Image: inputs:file: ./gone.png is not found: the image's default is shown "
        "(dropped)"
    ]
    assert found.mean(axis=(0, 1)) == pytest.approx((0.1, 0.2, 0.3), rel=0.03)


@pytest.mark.parametrize(
    ("identifier", "inputs"),
    [
        (OPENPBR, {"base_color": A, "specular_weight": 0.0}),
        (STANDARD, {"base_color": A, "specular": 0.0}),
        (GLTF, {"base_color": A, "specular": 0.0, "metallic": 0.0}),
        ("ND_UsdPreviewSurface_surfaceshader", {"diffuseColor": A, "ior": 1.0}),
    ],
)
def test_a_matte_card_shows_its_albedo_in_every_vocabulary(
    mi: Any, stage: Any, identifier: str, inputs: dict[str, Any]
) -> None:
    typed = {k: ("color3f" if isinstance(v, tuple) else "float", v) for k, v in inputs.items()}
    surface(stage, identifier, **typed)
    found, losses = quadrants(stage)
    assert losses == []
    assert found.mean(axis=(0, 1)) == pytest.approx(A, rel=0.02)


@pytest.mark.parametrize(
    ("identifier", "inputs"),
    [
        (OPENPBR, {"base_color": (1, 1, 1), "specular_roughness": 0.3}),
        (OPENPBR, {"base_color": (1, 1, 1), "coat_weight": 1.0, "coat_roughness": 0.2}),
        (OPENPBR, {"base_color": (1, 1, 1), "base_metalness": 1.0, "specular_roughness": 0.6}),
        (STANDARD, {"base_color": (1, 1, 1), "specular_roughness": 0.5, "metalness": 0.5}),
        (GLTF, {"base_color": (1, 1, 1), "metallic": 0.0, "roughness": 0.4, "clearcoat": 1.0}),
    ],
)
def test_a_white_surface_vanishes_in_a_white_furnace(
    mi: Any, stage: Any, identifier: str, inputs: dict[str, Any]
) -> None:
    typed = {k: ("color3f" if isinstance(v, tuple) else "float", v) for k, v in inputs.items()}
    surface(stage, identifier, **typed)
    found, _ = quadrants(stage)
    assert found.mean() == pytest.approx(1.0, abs=0.01)


def test_what_is_lost_is_named(mi: Any, stage: Any) -> None:
    surface(
        stage, STANDARD,
        sheen=("float", 1.0), subsurface=("float", 0.5), thin_film_thickness=("float", 300.0),
        diffuse_roughness=("float", 0.2),
    )  # fmt: skip
    _, losses = quadrants(stage)
    at = "/World/Look/Surface: "
    assert losses == [
        at + "sheen (dropped)",
        at + "thin_film_thickness (dropped)",
        at + "diffuse_roughness is 0: diffuse light is Lambert's (approximated)",
        at + "subsurface: light leaves where it enters (approximated)",
    ]


def test_openpbr_names_fuzz_thin_film_and_coat(mi: Any, stage: Any) -> None:
    surface(
        stage, OPENPBR,
        fuzz_weight=("float", 0.5), thin_film_weight=("float", 1.0), coat_weight=("float", 1.0),
    )  # fmt: skip
    _, losses = quadrants(stage)
    assert [loss.removeprefix("/World/Look/Surface: ") for loss in losses] == [
        "fuzz_weight (dropped)",
        "thin_film_weight (dropped)",
        "coat follows the base's normal and neither darkens nor roughens it (approximated)",
    ]


def test_glass_shows_what_lies_behind_it(mi: Any, stage: Any) -> None:
    shader = surface(
        stage, OPENPBR, transmission_weight=("float", 1.0), specular_roughness=("float", 0.0),
        geometry_thin_walled=("bool", True), base_color=("color3f", (0, 0, 0)),
    )  # fmt: skip
    found, losses = quadrants(stage)
    assert losses == []
    assert found.mean() == pytest.approx(1.0, abs=0.02)
    shader.CreateInput("transmission_color", Sdf.ValueTypeNames.Color3f).Set((0.5, 0.5, 0.5))
    dimmed, _ = quadrants(stage)
    # A pane of index 1.5 reflects 2R/(1+R) = 7.7 % and lets the rest through, tinted.
    assert dimmed.mean() == pytest.approx(0.077 + 0.923 * 0.5, abs=0.02)


def test_opacity_of_every_vocabulary_lets_the_dome_through(mi: Any, stage: Any) -> None:
    surface(
        stage, STANDARD, base_color=("color3f", (0, 0, 0)), specular=("float", 0.0),
        opacity=("color3f", (0.25, 0.25, 0.25)),
    )  # fmt: skip
    assert quadrants(stage)[0].mean() == pytest.approx(0.75, abs=0.03)


def test_the_context_chooses_the_network(mi: Any, stage: Any) -> None:
    matte(stage, (0.1, 0.5, 0.1))
    material = UsdShade.Material(stage.GetPrimAtPath("/World/Look"))
    _, shader = preview_material(stage, "/World/Other", diffuseColor=(0.5, 0.1, 0.1), ior=1.0)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    for context in ("mitsuba", "mtlx", "openpbr"):
        assert quadrants(stage, context=context)[0][0, 0] == pytest.approx(
            (0.1, 0.5, 0.1), rel=0.05
        )
    assert quadrants(stage, context="preview")[0][0, 0] == pytest.approx((0.5, 0.1, 0.1), rel=0.05)


def test_a_network_that_is_passed_over_is_named(mi: Any, stage: Any) -> None:
    shader = matte(stage, (0.1, 0.5, 0.1))
    shader.CreateIdAttr("ND_toon_surfaceshader")
    material = UsdShade.Material(stage.GetPrimAtPath("/World/Look"))
    _, other = preview_material(stage, "/World/Other", diffuseColor=(0.5, 0.1, 0.1), ior=1.0)
    material.CreateSurfaceOutput().ConnectToSource(other.ConnectableAPI(), "surface")
    found, losses = quadrants(stage)
    assert found[0, 0] == pytest.approx((0.5, 0.1, 0.1), rel=0.05)
    assert losses == [
        "/World/Look/Surface: surface shader ND_toon_surfaceshader: another network is shown "
        "(approximated)"
    ]


def stretched(stage: Any, identifier: str, **inputs: Any) -> float:
    """How much wider the highlight of a surface on a dish is along x than along y."""
    surface(stage, identifier, **inputs)
    return stretch_of(stage, UsdShade.Material(stage.GetPrimAtPath("/World/Look")))


METAL = {"base_color": ("color3f", (1, 1, 1)), "specular_roughness": ("float", 0.4)}


def test_a_highlight_is_stretched_along_the_tangent(mi: Any, tmp_path: Path) -> None:
    openpbr = METAL | {
        "base_metalness": ("float", 1.0), "specular_roughness_anisotropy": ("float", 0.8)
    }  # fmt: skip
    assert stretched(card_stage(tmp_path), OPENPBR, **openpbr) > 3


def test_a_fibre_along_y_has_its_highlight_along_x(mi: Any, tmp_path: Path) -> None:
    # As our assets have it: the tangent is the normal times the fibre, decoded from maps.
    stage = card_stage(tmp_path)
    fibre = np.tile((np.array((0.0, 1.0, 0.0)) + 1) / 2, (2, 2, 1))
    write_image(tmp_path / "fibre.exr", fibre)
    encoded = node(stage, "Map", "ND_image_vector3", file=("asset", "./fibre.exr"))
    along = node(stage, "Fibre", "ND_normalmap_float", in_=("float3", encoded))
    normal = node(stage, "Normal", "ND_normal_vector3")
    across = node(
        stage, "Across", "ND_crossproduct_vector3", in1=("float3", normal), in2=("float3", along)
    )
    ratio = stretched(
        stage, OPENPBR, base_metalness=("float", 1.0), geometry_tangent=("float3", across),
        specular_roughness_anisotropy=("float", 0.8), **METAL,
    )  # fmt: skip
    assert ratio > 3


def test_an_eighth_turn_stretches_the_highlight_along_neither(mi: Any, tmp_path: Path) -> None:
    ratio = stretched(
        card_stage(tmp_path), STANDARD, metalness=("float", 1.0),
        specular_anisotropy=("float", 0.8), specular_rotation=("float", 0.125), **METAL,
    )  # fmt: skip
    assert ratio == pytest.approx(1, abs=0.2)


@pytest.mark.parametrize(("turn", "wide"), [(0.0, True), (0.25, False)])
def test_a_quarter_turn_stretches_the_highlight_the_other_way(
    mi: Any, tmp_path: Path, turn: float, wide: bool
) -> None:
    ratio = stretched(
        card_stage(tmp_path), STANDARD, metalness=("float", 1.0),
        specular_anisotropy=("float", 0.8), specular_rotation=("float", turn), **METAL,
    )  # fmt: skip
    assert (ratio > 3) if wide else (ratio < 1 / 3)


def test_a_direction_is_no_color(mi: Any, stage: Any) -> None:
    matte(stage, node(stage, "N", "ND_normal_vector3"))
    _, losses = quadrants(stage)
    assert losses == [
        "/World/Look/N: direction in the world is carried as normal or tangent only (dropped)"
    ]


@pytest.mark.parametrize("fibre", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
def test_a_published_cloth_shines_across_its_fibres_without_a_loss(
    mi: Any, tmp_path: Path, fibre: tuple[float, float, float]
) -> None:
    from tests.export.test_highlight import flat_cloth

    (tmp_path / "asset").mkdir()
    flat_cloth(fibre, tmp_path / "asset")
    stage = card_stage(tmp_path)
    stage.DefinePrim("/World/Cloth").GetReferences().AddReference("./asset/plain.usda")
    material = UsdShade.Material(stage.GetPrimAtPath("/World/Cloth/Material"))
    ratio = stretch_of(stage, material, context="openpbr")
    assert (ratio < 1 / 3) if fibre[0] else (ratio > 3)
