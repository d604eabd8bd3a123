"""The cloth from afar against its own texels."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Sdf, Usd

from tests.render.cloths import direction
from weaveusd import pipeline
from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif
from weaveusd.errors import InputError
from weaveusd.render import distance_levels, distance_moments
from weaveusd.render.distance_moments import Threads
from weaveusd.render.distance_threads import distant_levels
from weaveusd.render.model import MAX_LEVELS
from weaveusd.render.optics import yarn_table
from weaveusd.render.packing import pack
from weaveusd.render.run import render
from weaveusd.render.scenes import dress, scene_path
from weaveusd.shading.directions import pairs
from weaveusd.shading.distance import evaluate
from weaveusd.shading.normalization import normalization
from weaveusd.synth.moments import moment_maps
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.model import Optics
from weaveusd.yarn.recipe import read_preset

TEXELS = 256
CASES = [("plain", "polyester"), ("twill:2/2", "shot_silk"), ("plain", "linen")]
GAPS = ("plain", "chiffon")


class Woven:
    """A preset woven after a notation: channels, optics, threads and crossings.

    In the levels of one that is dense, what is yarn takes the place of what is not.
    """

    def __init__(self, notation: str, preset: str, *, dense: bool = False) -> None:
        cloth = weave(make_draft(notation), read_preset(preset))
        self.weave = cloth
        self.textures = synthesize(cloth, resolution=TEXELS)
        self.arrays = dict(self.textures.whole())
        rows = [
            {
                **{name: getattr(y.optics, name) for name in Optics.__slots__},
                "normalization": _n_v(y.optics),
            }
            for y in cloth.yarns
        ]
        self.optics = yarn_table({name: [row[name] for row in rows] for name in rows[0]})
        ratios = (
            cloth.warp_height_mm / cloth.warp_width_mm,
            cloth.weft_height_mm / cloth.weft_width_mm,
        )
        is_weft = np.array([y.system == "weft" for y in cloth.yarns])
        owners = (cloth.warp_yarn, cloth.weft_yarn)
        flatness = [
            ratios[int(weft)][owners[int(weft)] == k].mean() for k, weft in enumerate(is_weft)
        ]
        self.threads = Threads(is_weft, np.array(flatness, np.float32))
        self.crossings = (cloth.picks, cloth.ends)
        self.levels = distance_levels.make_levels(
            self.arrays, self.optics, self.threads, self.crossings
        )
        if dense:
            numbers = self.levels.numbers.copy().reshape(-1, 2, distance_levels.NUMBERS)
            shares = numbers[..., : distance_levels.FALL + 1]
            shares /= np.maximum(shares.sum(axis=(1, 2), keepdims=True), 1e-6)
            self.levels = replace(self.levels, numbers=numbers.reshape(len(numbers), -1))

    def bsdf(self, level: int | None) -> Any:
        import mitsuba as mi

        from weaveusd.render.bsdf import packed_bsdf_dict
        from weaveusd.render.distance_cloth import View

        packed, _ = pack(self.arrays, self.optics.shape[1])
        afar = {} if level is None else {"levels": self.levels, "view": View(level=level)}
        made = packed_bsdf_dict(packed, self.optics, (1.0, 1.0), **afar)
        return mi.load_dict(made, parallel=False)


def _n_v(o: Optics) -> float:
    return normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v)


@lru_cache(maxsize=8)
def woven(notation: str, preset: str) -> Woven:
    return Woven(notation, preset)


def means(mi: Any, bsdf: Any, wi: Any, wo: Any, count: int, corner: Any = (0, 0), side: Any = 1):
    """Mean and variance of the value over random places of a square of the texture."""
    from weaveusd.render import probe

    n = len(wi) * count
    uv = np.array(corner)[:, None] + side * np.random.default_rng(3).random((2, n))
    towards = np.ascontiguousarray(np.repeat(wi, count, 0).T, np.float32)
    away = np.ascontiguousarray(np.repeat(wo, count, 0).T, np.float32)
    si = probe.interaction(towards, n, uv.astype(np.float32))
    found = np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(away)), np.float64)
    found = found.reshape(3, len(wi), count)
    return found.mean(-1), found.var(-1)


@pytest.mark.parametrize("case", [*CASES, GAPS])
def test_a_tile_far_away_is_the_mean_of_its_texels_and_less_noisy(mi: Any, case: Any) -> None:
    wi, wo = pairs(100)
    cloth = woven(*case)
    truth, noise = means(mi, cloth.bsdf(None), wi, wo, 8192)
    found, left = means(mi, cloth.bsdf(99), wi, wo, 8192)
    assert np.abs(found - truth).sum() / truth.sum() < 0.06
    assert abs(found.sum() / truth.sum() - 1) < 0.03
    assert noise.sum() / left.sum() > 3


@pytest.mark.parametrize("case", [*CASES, GAPS])
def test_a_tile_far_away_is_what_the_reference_for_footprints_says(mi: Any, case: Any) -> None:
    wi, wo = pairs(100)
    cloth = woven(*case)
    maps = moment_maps(cloth.weave, cloth.textures, width=1, height=1)
    expected = evaluate(wi, wo, [m.footprint(0, 0) for m in maps]).T
    found, _ = means(mi, cloth.bsdf(99), wi, wo, 4096)
    assert np.abs(found - expected).sum() / expected.sum() < 0.05
    assert abs(found.sum() / expected.sum() - 1) < 0.03


@pytest.mark.parametrize("level", [0, 1, 2])
def test_every_level_has_the_mean_of_the_texels(mi: Any, level: int) -> None:
    wi, wo = pairs(60)
    cloth = woven(*CASES[1])
    truth, _ = means(mi, cloth.bsdf(None), wi, wo, 8192)
    found, _ = means(mi, cloth.bsdf(level), wi, wo, 8192)
    assert abs(found.sum() / truth.sum() - 1) < 0.03


def test_a_cloth_with_levels_seen_near_is_the_cloth_without(mi: Any) -> None:
    from weaveusd.render.bsdf import packed_bsdf_dict

    wi, wo = pairs(40)
    cloth = woven(*CASES[1])
    packed, _ = pack(cloth.arrays, cloth.optics.shape[1])
    near = mi.load_dict(packed_bsdf_dict(packed, cloth.optics, (1.0, 1.0), levels=cloth.levels))
    expected, _ = means(mi, cloth.bsdf(None), wi, wo, 64)
    found, _ = means(mi, near, wi, wo, 64)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-6)


def test_the_blend_from_near_to_far_is_continuous(mi: Any) -> None:
    from weaveusd.render import probe
    from weaveusd.render.bsdf import packed_bsdf_dict
    from weaveusd.render.distance_cloth import View

    cloth = woven(*CASES[0])
    packed, _ = pack(cloth.arrays, cloth.optics.shape[1])
    cell = 1 / np.sqrt(cloth.levels.rows[0] * cloth.levels.columns[0])
    count = 1 << 18
    uv = np.random.default_rng(5).random((2, count)).astype(np.float32)
    si = probe.interaction(direction(40, 20), count, uv)
    wo = mi.Vector3f(*direction(35, 190))
    found = []
    for footprint in np.geomspace(0.5, 16, 21) * cell:
        made = packed_bsdf_dict(
            packed, cloth.optics, (1.0, 1.0),
            levels=cloth.levels, view=View(constant=float(footprint)),
        )  # fmt: skip
        value = mi.load_dict(made, parallel=False).eval(mi.BSDFContext(), si, wo)
        found.append(float(np.array(value).mean()))
    steps = np.abs(np.diff(found)) / np.mean(found)
    assert steps.max() < 0.06
    assert found[-1] == pytest.approx(found[0], rel=0.15)


@pytest.mark.parametrize("case", [CASES[0], CASES[1], GAPS])
def test_samples_from_afar_follow_their_density(mi: Any, case: Any) -> None:
    from weaveusd.render import probe

    bsdf = Woven(*case, dense=True).bsdf(99)
    angles = ((0, 0), (30, 40), (70, 100), (150, 70))
    for angle in angles:
        found = probe.chi_square(bsdf, direction(*angle))
        assert not found.fault
        assert found.p_value >= probe.least_p_value(len(angles) * 3)
        assert found.density <= 1.005


def test_value_density_and_sample_agree_from_afar(mi: Any) -> None:
    from weaveusd.render import probe

    bsdf = woven(*GAPS).bsdf(1)
    context, count = mi.BSDFContext(), 4096
    rng = mi.PCG32(size=count)
    uv = np.random.default_rng(2).random((2, count)).astype(np.float32)
    si = probe.interaction(direction(40, 20), count, uv)
    bs, weight = bsdf.sample(
        context, si, rng.next_float32(), mi.Point2f(rng.next_float32(), rng.next_float32())
    )
    value, pdf = bsdf.eval_pdf(context, si, bs.wo)
    passed = np.array(bs.sampled_type) == int(mi.BSDFFlags.Null)
    live = (np.array(bs.pdf) > 0) & ~passed
    assert 0 < passed.sum() < count
    np.testing.assert_allclose(np.array(pdf)[live], np.array(bs.pdf)[live], rtol=5e-3)
    expected = np.array(value)[:, live] / np.array(pdf)[live]
    np.testing.assert_allclose(np.array(weight)[:, live], expected, rtol=5e-3)
    share = np.array(bsdf.eval_null_transmission(si))[0]
    assert passed.mean() == pytest.approx(share.mean(), abs=0.03)


@pytest.mark.parametrize("case", [*CASES, GAPS])
def test_no_more_light_comes_back_from_afar_than_arrives(mi: Any, case: Any) -> None:
    from weaveusd.render import probe

    bsdf, count = woven(*case).bsdf(99), 1 << 16
    rng = mi.PCG32(size=count)
    uv = np.random.default_rng(2).random((2, count)).astype(np.float32)
    for angle in ((0, 0), (60, 45), (85, 90)):
        si = probe.interaction(direction(*angle), count, uv)
        _, weight = bsdf.sample(
            mi.BSDFContext(), si, rng.next_float32(),
            mi.Point2f(rng.next_float32(), rng.next_float32()),
        )  # fmt: skip
        assert np.array(weight).mean(axis=1).max() <= 1.01


def test_moments_of_the_whole_are_those_of_its_parts() -> None:
    cloth = woven(*CASES[2])
    fine = distance_moments.moments(cloth.arrays, cloth.threads, (8, 8))
    whole = distance_moments.moments(cloth.arrays, cloth.threads, (1, 1))
    while fine.texels.size > 1:
        fine = distance_moments.coarser(fine)
    np.testing.assert_allclose(fine.sums, whole.sums, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(fine.texels, whole.texels)


def test_shares_of_a_level_are_the_opacity_of_its_texels() -> None:
    cloth = woven(*GAPS)
    numbers = cloth.levels.numbers[-1].reshape(2, -1)
    opacity = np.where(cloth.arrays["yarn_id"] < 0, 0, cloth.arrays["opacity"]).mean()
    assert numbers[:, : distance_levels.FALL + 1].sum() == pytest.approx(opacity, rel=1e-5)


def test_yarns_in_one_frame_make_a_box_without_width() -> None:
    tilt = np.array([0.2, 0.3, 0.9], np.float32) / np.linalg.norm([0.2, 0.3, 0.9])
    along = np.cross(np.cross(tilt, [0, 1, 0]), tilt)
    along /= np.linalg.norm(along)
    arrays = {
        "normal": np.tile(tilt, (8, 8, 1)),
        "tangent": np.tile(along, (8, 8, 1)),
        "base_color": np.full((8, 8, 3), 0.4),
        "opacity": np.ones((8, 8, 1)),
        "yarn_id": np.zeros((8, 8, 1)),
    }
    threads = Threads(np.array([False]), np.array([0.5], np.float32))
    levels = distance_levels.make_levels(arrays, np.ones((7, 1), np.float32), threads, (1, 1))
    whole = levels.numbers[-1]
    assert whole[distance_levels.RISE] == pytest.approx(1)
    assert whole[distance_levels.RISE_LOW] == pytest.approx(whole[distance_levels.RISE_HIGH])
    assert whole[distance_levels.X_LOW] == pytest.approx(whole[distance_levels.X_HIGH], abs=1e-6)
    assert whole[distance_levels.COLOR] == pytest.approx(0.4)


@pytest.fixture(scope="module")
def stage(tmp_path_factory: Any) -> Any:
    """A published twill on the swatch of the examples."""
    folder = tmp_path_factory.mktemp("lod")
    draft = folder / "twill.wif"
    draft.write_bytes(write_wif(make_draft("twill:2/2")))
    done = pipeline.publish(draft, preset="shot_silk", root=folder, resolution=TEXELS)
    return dress(scene_path("swatch"), Path(done.asset.entry), folder / "swatch.usda")


def test_a_stage_from_afar_has_the_colors_of_its_texels(mi: Any, stage: Any) -> None:
    full, auto, level = (
        render(stage, width=24, spp=256, lod=lod).image.astype(float)
        for lod in ("full", "auto", 99 % MAX_LEVELS)
    )
    assert np.abs(auto - full).max() > 0
    for image in (auto, level):
        np.testing.assert_allclose(image.mean((0, 1)), full.mean((0, 1)), rtol=0.03)


def test_a_view_knows_its_eye_and_its_pixel(mi: Any) -> None:
    from weaveusd.render.distance_cloth import seen_by

    size = {"type": "hdrfilm", "width": 200, "height": 100}
    at = mi.ScalarTransform4f().look_at([1, 2, 3], [0, 0, 0], [0, 1, 0])
    lens = {"type": "perspective", "fov": 20.0, "fov_axis": "x", "to_world": at, "film": size}
    view = seen_by(mi.load_dict(lens))
    assert view.eye == pytest.approx((1, 2, 3), abs=1e-5)
    assert view.per_distance == pytest.approx(2 * np.tan(np.radians(10)) / 200, rel=1e-2)
    parallel = {"type": "orthographic", "to_world": at, "film": size}
    view = seen_by(mi.load_dict(parallel))
    assert view.per_distance == 0
    assert view.constant == pytest.approx(2 / 200, rel=1e-3)


@pytest.mark.parametrize("names", [["a b", ""], ["é:x", "y"], ["warp_1"]])
def test_a_cloth_that_does_not_state_its_yarns_has_no_levels(names: Any) -> None:
    stage = Usd.Stage.CreateInMemory()
    material = stage.DefinePrim("/Material", "Material")
    material.CreateAttribute("weave:yarns", Sdf.ValueTypeNames.StringArray).Set(names)
    for name in ("ends", "picks"):
        material.CreateAttribute(f"weave:{name}", Sdf.ValueTypeNames.Int).Set(2)
    cloth = woven(*CASES[0])
    assert distant_levels(material, cloth.arrays, cloth.optics) is None


@pytest.mark.parametrize("lod", ["half", -1, 99])
def test_a_level_of_detail_that_is_none_is_refused(mi: Any, tmp_path: Any, lod: Any) -> None:
    with pytest.raises(InputError, match="expected auto, full or 0 to 23"):
        render(tmp_path / "none.usda", lod=lod)
