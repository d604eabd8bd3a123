"""Which material a shape wears, as UsdShade's rules of binding have it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom, UsdShade

from tests.render.networks import QUADRANTS, card_stage, large_texels, quadrants
from tests.render.stages import add_mesh, add_texture, preview_material, write_image

RED, GREEN = (0.8, 0.1, 0.1), (0.1, 0.8, 0.1)


@pytest.fixture
def stage(tmp_path: Path) -> Any:
    """A card below /World/Group, and two materials."""
    made = card_stage(tmp_path)
    UsdGeom.Xform.Define(made, "/World/Group")
    add_mesh(made, "/World/Group/Card")
    preview_material(made, "/World/Red", diffuseColor=RED, ior=1.0)
    preview_material(made, "/World/Green", diffuseColor=GREEN, ior=1.0)
    return made


def material(stage: Any, name: str) -> UsdShade.Material:
    return UsdShade.Material(stage.GetPrimAtPath(f"/World/{name}"))


def binding(stage: Any, path: str) -> UsdShade.MaterialBindingAPI:
    return UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(path))


def shown(stage: Any) -> Any:
    found, losses = quadrants(stage)
    assert losses == []
    return found.mean(axis=(0, 1))


def test_the_nearest_binding_wins(mi: Any, stage: Any) -> None:
    binding(stage, "/World/Group").Bind(material(stage, "Red"))
    assert shown(stage) == pytest.approx(RED, rel=0.03)
    binding(stage, "/World/Group/Card").Bind(material(stage, "Green"))
    assert shown(stage) == pytest.approx(GREEN, rel=0.03)


def test_a_binding_above_may_be_stronger(mi: Any, stage: Any) -> None:
    binding(stage, "/World/Group/Card").Bind(material(stage, "Green"))
    binding(stage, "/World/Group").Bind(
        material(stage, "Red"), UsdShade.Tokens.strongerThanDescendants
    )
    assert shown(stage) == pytest.approx(RED, rel=0.03)


@pytest.mark.parametrize(("purpose", "expected"), [("full", GREEN), ("preview", RED)])
def test_a_final_picture_takes_the_binding_for_it(
    mi: Any, stage: Any, purpose: str, expected: Any
) -> None:
    card = binding(stage, "/World/Group/Card")
    card.Bind(material(stage, "Red"))
    card.Bind(material(stage, "Green"), materialPurpose=purpose)
    assert shown(stage) == pytest.approx(expected, rel=0.03)


def test_a_collection_binds_its_members(mi: Any, stage: Any) -> None:
    group = stage.GetPrimAtPath("/World/Group")
    collection = Usd.CollectionAPI.Apply(group, "painted")
    collection.IncludePath("/World/Group/Card")
    binding(stage, "/World/Group").Bind(collection, material(stage, "Green"), "paint")
    assert shown(stage) == pytest.approx(GREEN, rel=0.03)
    collection.ExcludePath("/World/Group/Card")
    assert shown(stage) == pytest.approx((0.18, 0.18, 0.18), rel=0.03)


@pytest.mark.parametrize(
    ("target", "said"),
    [("/World/Gone", "which is not"), ("/World/Group", "which is no material")],
)
@pytest.mark.parametrize("purpose", ["", ":full"])
def test_a_binding_to_nothing_is_a_loss_and_gray(
    mi: Any, stage: Any, target: str, said: str, purpose: str, capfd: Any
) -> None:
    binding(stage, "/World/Group").GetPrim().CreateRelationship(
        f"material:binding{purpose}"
    ).SetTargets([Sdf.Path(target)])
    found, losses = quadrants(stage)
    assert losses == [f"/World/Group/Card: its material binding names {target}, {said} (dropped)"]
    assert found.mean() == pytest.approx(0.18, rel=0.03)
    assert capfd.readouterr().err == ""


def test_a_binding_counts_without_its_api(mi: Any, stage: Any, capfd: Any) -> None:
    # Stages from before 22.11 bind without applying MaterialBindingAPI.
    stage.GetPrimAtPath("/World/Group/Card").CreateRelationship("material:binding").SetTargets(
        [Sdf.Path("/World/Red")]
    )
    found, _ = quadrants(stage)
    assert found.mean(axis=(0, 1)) == pytest.approx(RED, rel=0.03)
    assert capfd.readouterr().err == ""


def test_a_material_inside_an_instance_keeps_its_textures(
    mi: Any, stage: Any, tmp_path: Path
) -> None:
    write_image(tmp_path / "map.exr", large_texels(QUADRANTS))
    source = Usd.Stage.CreateNew(str(tmp_path / "asset.usda"))
    root = source.DefinePrim("/Asset", "Xform")
    source.SetDefaultPrim(root)
    look, shader = preview_material(source, "/Asset/Look", ior=1.0)
    add_texture(source, shader, "diffuseColor", "./map.exr")
    card = add_mesh(source, "/Asset/Card")
    UsdShade.MaterialBindingAPI.Apply(card.GetPrim()).Bind(look)
    source.GetRootLayer().Save()
    stage.RemovePrim("/World/Group")
    for name, depth in (("One", 0.0), ("Two", -1.0)):
        copy = UsdGeom.Xform.Define(stage, f"/World/{name}")
        copy.AddTranslateOp().Set((0, 0, depth))
        copy.GetPrim().GetReferences().AddReference("./asset.usda")
        copy.GetPrim().SetInstanceable(True)
    found, losses = quadrants(stage)
    assert losses == []
    np.testing.assert_allclose(found, QUADRANTS, atol=0.05)
