"""Networks of random nodes, types and values: every one is a picture and losses, none a crash."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdShade, Vt

from tests.render.networks import card_stage
from tests.render.stages import add_mesh, bind, picture, write_image

NODE_INPUTS = (
    "in in1 in2 in3 fg bg mix low high value file st texcoord varname geomprop fallback scale "
    "bias rotation translation wrapS wrapT sourceColorSpace uaddressmode default index which "
    "channels amount axis pivot offset rotate operationorder value1 value2 normal tangent"
)
SURFACE_INPUTS = (
    "base_color base diffuseColor metallic metalness base_metalness roughness opacity alpha "
    "specular_roughness geometry_opacity opacityThreshold opacityMode useSpecularWorkflow "
    "specularColor ior specular_ior specular_IOR coat clearcoat coat_weight normal tangent "
    "geometry_normal geometry_tangent emissiveColor emission emission_color emission_luminance "
    "transmission transmission_weight thin_walled geometry_thin_walled subsurface "
    "specular_anisotropy specular_rotation alpha_mode alpha_cutoff occlusion thickness"
)
OUTPUTS = ("out", "rgb", "r", "result", "outx", "a")


def value(chance: random.Random) -> tuple[str, Any]:
    """A type of USD and one of its values, seldom a sensible one."""
    number = chance.choice((0.0, 0.5, 1.0, -1.0, -1e7, 1e30, float("nan"), float("inf")))
    files = ("", "./map.exr", "./gone.png", "./", "./map.<UDIM>.exr", "http://host/map.png")
    return chance.choice(
        (
            ("Float", number), ("Half", 0.5), ("Double", 1e300), ("Bool", True),
            ("Int", chance.choice((0, 1, -5, 2**31 - 1))),
            ("Token", chance.choice(("", "repeat", "rgb", "mirror", "nonsense"))),
            ("String", chance.choice(("", "st", "xyzw", "../..", "\n"))),
            ("Color3f", Gf.Vec3f(chance.random(), 3 * chance.random(), -chance.random())),
            ("Float2", Gf.Vec2f(9 * chance.random(), 0)), ("Float4", Gf.Vec4f(0, 1, 2, 3)),
            ("Normal3f", Gf.Vec3f(0, 0, 1)), ("Matrix4d", Gf.Matrix4d(1)),
            ("FloatArray", Vt.FloatArray([1, 2, 3])), ("StringArray", Vt.StringArray(["a"])),
            ("Asset", Sdf.AssetPath(chance.choice(files))),
        )
    )  # fmt: skip


def random_network(stage: Any, chance: random.Random) -> None:
    """Give a card a surface shader fed by up to eight nodes, each by those before it."""
    from weaveusd.render import nodes_mtlx, nodes_usd
    from weaveusd.render.materials import SURFACES

    known = sorted({**nodes_usd.readers(), **nodes_mtlx.readers()})
    material = UsdShade.Material.Define(stage, "/World/Look")
    outputs: list[UsdShade.Output] = []

    def define(name: str, identifier: str, inputs: list[str]) -> UsdShade.Shader:
        shader = UsdShade.Shader.Define(stage, f"/World/Look/{name}")
        shader.CreateIdAttr(identifier)
        for key in inputs:
            kind, content = value(chance)
            given = shader.CreateInput(key, getattr(Sdf.ValueTypeNames, kind))
            if outputs and chance.random() < 0.5:
                given.ConnectToSource(chance.choice(outputs))
            else:
                given.Set(content)
        return shader

    for k in range(chance.randint(0, 8)):
        inputs = chance.sample(NODE_INPUTS.split(), chance.randint(0, 8))
        node = define(f"N{k}", chance.choice(known), inputs)
        outputs.append(node.CreateOutput(chance.choice(OUTPUTS), Sdf.ValueTypeNames.Token))
    inputs = chance.sample(SURFACE_INPUTS.split(), chance.randint(1, 14))
    surface = define("Surface", chance.choice(sorted(SURFACES)), inputs)
    material.CreateSurfaceOutput("mtlx").ConnectToSource(
        surface.CreateOutput("out", Sdf.ValueTypeNames.Token)
    )
    bind(add_mesh(stage), material)


def check(folder: Path, seeds: range, capfd: Any) -> None:
    for seed in seeds:
        inside = folder / str(seed)
        inside.mkdir()
        write_image(inside / "map.exr", np.full((4, 4, 3), 0.5))
        stage = card_stage(inside)
        random_network(stage, random.Random(seed))
        image, losses = picture(stage, 4, 2)
        assert np.isfinite(image).all(), f"seed {seed}"
        assert image.min() >= 0, f"seed {seed}"
        assert not any("\n" in loss for loss in losses), f"seed {seed}"
    assert capfd.readouterr().err == ""


def test_a_random_network_is_a_picture_and_losses(mi: Any, tmp_path: Path, capfd: Any) -> None:
    check(tmp_path, range(24), capfd)


@pytest.mark.slow
def test_many_random_networks_are_pictures_and_losses(mi: Any, tmp_path: Path, capfd: Any) -> None:
    check(tmp_path, range(1000, 1400), capfd)
