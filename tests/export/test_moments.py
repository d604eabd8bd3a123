"""The moment maps that are published are those of the textures beside them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from tests.export.cloths import REPEAT_MM, cloth
from tests.weaves import satin, twill, woven
from weaveusd.contract import MOMENT_MAPS, SYSTEMS, moment_file
from weaveusd.export import textures as writing
from weaveusd.export.asset import write_asset
from weaveusd.export.images import read_image
from weaveusd.export.lobes import YarnLobes
from weaveusd.export.moments import moment_files, pictures, system_maps, write_moment_maps
from weaveusd.export.textures import write_textures
from weaveusd.synth.kinds import kinds_of
from weaveusd.synth.model import TextureSet
from weaveusd.synth.moment_sums import MomentSums
from weaveusd.synth.moments import moment_maps
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import read_preset

HALF = 2.0**-11
"""Relative rounding of a half float."""


def striped(preset: str = "linen"):
    """A twill in which every other end is of another kind of yarn."""
    weave = woven(twill(), preset)
    other = replace(weave.yarns[0], optics=read_preset("polyester").yarns[0].optics)
    warp = np.where(np.arange(weave.ends) % 2, len(weave.yarns), 0).astype(np.int32)
    return replace(weave, yarns=(*weave.yarns, other), warp_yarn=warp)


def written(weave, textures, folder: Path, jobs: int | None = None) -> Path:
    """Write textures and maps of 8 × 7 texels into `folder`."""
    size = textures.width, textures.height
    sums = MomentSums(weave, size, width=8, height=7)
    lobes = YarnLobes(*np.full((5, len(weave.yarns)), 0.5, np.float32))
    write_textures(textures, folder, lobes, also=[sums.add], jobs=jobs)
    write_moment_maps(sums.maps(), folder, textures.repeat_mm)
    return folder


def read_textures(folder: Path, like: TextureSet, weave) -> TextureSet:
    """The textures as their files hold them."""
    image = {n: read_image(folder / f"{n}.exr")[::-1] for n in ("base_color", "normal", "tangent")}
    image["opacity"] = (read_image(folder / "opacity.png")[::-1] / 255).astype(np.float32)
    image["yarn_id"] = read_image(folder / "yarn_id.png")[::-1].astype(np.float32) - 1
    of_yarn = np.array([SYSTEMS.index(yarn.system) for yarn in weave.yarns] + [-1], np.float32)
    image["system"] = of_yarn[image["yarn_id"].astype(int)]
    return replace(like, band=lambda first, last: {n: a[first:last] for n, a in image.items()})


@pytest.mark.parametrize("preset", ["linen", "charmeuse"])
def test_published_maps_are_those_of_the_published_textures_but_for_rounding(tmp_path, preset):
    weave = striped(preset)
    textures = synthesize(weave, resolution=64)
    written(weave, textures, tmp_path)
    stored = read_textures(tmp_path, textures, weave)
    for system, maps in zip(SYSTEMS, moment_maps(weave, stored, width=8, height=7), strict=True):
        for name, values in pictures(maps).items():
            found = read_image(tmp_path / moment_file(system, name))[::-1]
            # Frames and opacity are rounded too, in files: by as much, and by half of 1/255.
            np.testing.assert_allclose(found, values, atol=2 * HALF, err_msg=name)


def test_files_hold_the_maps_to_half_precision_the_right_way_up(tmp_path):
    weave = striped()
    textures = synthesize(weave, resolution=48)
    written(weave, textures, tmp_path)
    for system, maps in zip(SYSTEMS, moment_maps(weave, textures, width=8, height=7), strict=True):
        for name, values in pictures(maps).items():
            found = read_image(tmp_path / moment_file(system, name))
            np.testing.assert_array_equal(found, values[::-1].astype(np.float16), err_msg=name)


def test_the_components_are_those_of_the_contract():
    weave = striped()
    textures = synthesize(weave, resolution=48)
    warp, weft = (pictures(m) for m in moment_maps(weave, textures, width=8, height=7))
    assert tuple(warp) == tuple(MOMENT_MAPS)
    assert tuple(weft) == tuple(name for name in MOMENT_MAPS if name != "kinds")
    for maps in (warp, weft):
        flat, rising, falling, across = np.moveaxis(maps["slopes"], -1, 0)
        a = maps["albedo"][..., 3]
        np.testing.assert_allclose(flat + rising + falling, a, atol=1e-6)
        assert (np.abs(across) <= maps["across"][..., 0] + 1e-6).all()
        assert (maps["along"][..., 0] >= 0).all()
        assert (maps["along"][..., 2] <= 0).all()
        assert (maps["across"][..., 1] * a >= maps["across"][..., 0] ** 2 - 1e-6).all()
    np.testing.assert_allclose(warp["kinds"].sum(-1), warp["albedo"][..., 3], atol=1e-6)
    assert not warp["kinds"][..., 2:].any()
    total = warp["albedo"][..., 3] + weft["albedo"][..., 3]
    assert total.max() <= 1 + 1e-6


def test_only_a_system_of_unlike_yarns_has_a_map_of_kinds():
    weave = striped()
    warp, weft = system_maps(weave)
    assert warp.kinds == (1, 3)
    assert weft.kinds == (2,)
    assert "warp_kinds.exr" in moment_files(weave)
    assert "weft_kinds.exr" not in moment_files(weave)
    assert tuple(k + 1 for k in kinds_of(weave, weft=False).yarns) == warp.kinds


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_bands_and_jobs_give_the_same_bytes(tmp_path, monkeypatch, jobs):
    weave = woven(satin(), "linen")
    for name, band in (("one", 10**9), ("many", 64 * jobs)):
        monkeypatch.setattr(writing, "BAND_TEXELS", band)
        (tmp_path / name).mkdir()
        written(weave, synthesize(weave, resolution=64, jobs=jobs), tmp_path / name, jobs)
    for file in moment_files(weave):
        one, many = ((tmp_path / name / file).read_bytes() for name in ("one", "many"))
        assert one == many, file


@pytest.mark.parametrize("space", ["lin_rec709", "acescg"])
def test_albedo_states_its_color_space_and_all_else_is_data(tmp_path, space):
    material = cloth()
    material = replace(material, weave=replace(material.weave, color_space=space))
    write_asset(material, tmp_path)
    for system in SYSTEMS:
        for name in ("slopes", "along", "across", "albedo"):
            path = tmp_path / "textures" / moment_file(system, name)
            spec = OpenImageIO.ImageInput.open(str(path)).spec()
            assert (spec.width, spec.height, spec.nchannels) == (8, 8, 4)
            assert spec.format == OpenImageIO.HALF
            assert spec.get_string_attribute("wrapmodes") == "periodic,periodic"
            per_inch = spec.get_float_attribute("XResolution")
            assert per_inch == pytest.approx(8 / REPEAT_MM[0] * 25.4, rel=1e-3)
            wide = spec.getattribute("chromaticities") is not None
            assert wide == (name == "albedo" and space == "acescg")
            stated = spec.get_string_attribute("oiio:ColorSpace")
            assert stated.startswith("data") == (name != "albedo")
