"""The moment maps of a published cloth, as the shader and the attributes name them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import weaveusd
from tests.export.cloths import cloth
from weaveusd.contract import COLORWAYS, SYSTEMS, moment_file
from weaveusd.export.asset import write_asset
from weaveusd.export.images import read_image
from weaveusd.stage import open_stage

TWILL = Path(__file__).resolve().parents[2] / "examples" / "drafts" / "twill_2_2.wif"


def striped_cloth(**changes):
    """The cloth made by hand, its second end of a yarn that scatters in another way."""
    material = cloth(**changes)
    weave = material.weave
    optics = replace(weave.yarns[0].optics, gamma_s=0.5)
    other = replace(weave.yarns[0], name="other", optics=optics)
    weave = replace(weave, yarns=(*weave.yarns, other), warp_yarn=np.array([0, 2], np.int32))
    fits = material.fits
    fits = replace(
        fits,
        yarns=(*fits.yarns, fits.yarns[0]),
        isotropic_yarns=(*fits.isotropic_yarns, fits.isotropic_yarns[0]),
    )
    return replace(
        material,
        weave=weave,
        fits=fits,
        normalization=(*material.normalization, 1.5),
        measured=(*material.measured, material.measured[0]),
    )


@pytest.mark.parametrize("striped_first", [True, False])
def test_a_colorway_names_the_maps_of_its_own_kinds(tmp_path, striped_first):
    cloths = {"one": cloth(), "two": striped_cloth()}
    if striped_first:
        cloths = {"two": cloths["two"], "one": cloths["one"]}
    write_asset(next(iter(cloths.values())), tmp_path, colorways=cloths)
    stage = open_stage(tmp_path / "plain.usda")
    for name, kinds in (("one", [1]), ("two", [1, 3])):
        stage.GetDefaultPrim().GetVariantSet(COLORWAYS).SetVariantSelection(name)
        shader = stage.GetPrimAtPath("/plain/Material/MitsubaSurface")
        assert list(shader.GetAttribute("inputs:warp_kinds").Get()) == kinds
        file = shader.GetAttribute("inputs:warp_kinds_file").Get()
        assert (file is not None) == (len(kinds) > 1)
        assert file is None or Path(file.resolvedPath).is_file()
        listed = stage.GetPrimAtPath("/plain/Material").GetAttribute("weave:momentMaps").Get()
        assert len(listed) == (9 if file else 8)
        assert all(Path(asset.resolvedPath).is_file() for asset in listed)


def test_a_published_albedo_is_the_base_color_times_the_gain_that_the_shader_states(tmp_path):
    done = weaveusd.publish(
        TWILL, preset="charmeuse", root=tmp_path, resolution=64, color_space="acescg"
    )
    assert done.findings == []
    stage = open_stage(done.asset.entry)
    shader = stage.GetPrimAtPath(f"{done.asset.material}/MitsubaSurface")
    folder = done.asset.folder / "textures"
    gain = np.array([0.0, *shader.GetAttribute("inputs:albedo_gain").Get()])
    ids = read_image(folder / "yarn_id.png")[..., 0]
    albedo = np.minimum(read_image(folder / "base_color.exr") * gain[ids][..., None], 1)
    a = read_image(folder / "opacity.png") / 255
    system = read_image(folder / "system.png")
    for k, name in enumerate(SYSTEMS, 1):
        color = shader.GetAttribute(f"inputs:{name}_albedo_file")
        assert color.GetColorSpace() == "acescg"
        found = read_image(folder / moment_file(name, "albedo")).mean((0, 1), dtype=float)
        of_system = a * (system == k)
        np.testing.assert_allclose(found[:3], (of_system * albedo).mean((0, 1)), rtol=2e-3)
        np.testing.assert_allclose(found[3], of_system.mean(), rtol=2e-3)
