"""The cloth from afar against its own texels."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from tests.render.cloths import direction
from weaveusd import pipeline
from weaveusd.cloth.model import Weave
from weaveusd.cloth.weave import weave
from weaveusd.contract import MAX_KINDS, MOMENT_TEXELS_A_THREAD
from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif
from weaveusd.errors import InputError
from weaveusd.render import distance_levels
from weaveusd.render.distance_levels import Levels, SystemMaps
from weaveusd.render.model import MAX_LEVELS
from weaveusd.render.optics import yarn_table
from weaveusd.render.packing import pack
from weaveusd.render.run import render
from weaveusd.render.scenes import dress, scene_path
from weaveusd.shading.directions import pairs
from weaveusd.shading.distance import evaluate
from weaveusd.shading.normalization import normalization
from weaveusd.synth.boxes import reduced
from weaveusd.synth.moments import MomentMaps, moment_maps
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.model import Optics
from weaveusd.yarn.recipe import read_preset

if TYPE_CHECKING:
    from weaveusd.render.distance_cloth import DistantCloth, View

TEXELS = 256
MOMENTS = ("slopes", "along", "across")
CASES = [("plain", "polyester"), ("twill:2/2", "shot_silk"), ("plain", "linen")]
GAPS = ("plain", "chiffon")
GOLD = ("twill:2/2", "brocade")


class Woven:
    """A cloth as Mitsuba has it: channels, optics, moment maps and levels.

    In the levels of one that is dense, what is yarn takes the place of what is not.
    """

    def __init__(self, cloth: Weave, *, dense: bool = False) -> None:
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
        width, height = (
            min(TEXELS, MOMENT_TEXELS_A_THREAD * threads) for threads in (cloth.ends, cloth.picks)
        )
        self.maps = moment_maps(cloth, self.textures, width=width, height=height)
        self.levels = distance_levels.make_levels(*(system_maps(m, cloth) for m in self.maps))
        if dense:
            numbers = self.levels.numbers.copy().reshape(-1, 2, distance_levels.NUMBERS)
            shares = numbers[..., : distance_levels.FALL + 1]
            shares /= np.maximum(shares.sum(axis=(1, 2), keepdims=True), 1e-6)
            self.levels = replace(self.levels, numbers=numbers.reshape(len(numbers), -1))

    def bsdf(self, level: int | None, levels: Levels | None = None) -> Any:
        """The BSDF of the texels, or that of a level."""
        import mitsuba as mi

        from weaveusd.render.distance_cloth import View

        view = None if level is None else View(level=level)
        return mi.load_dict(self.dictionary(view, levels), parallel=False)

    def dictionary(
        self, view: View | None, levels: Levels | None = None, repeats: float = 1.0
    ) -> dict[str, Any]:
        """The description of the BSDF, of the texels alone where there is no view."""
        from weaveusd.render.bsdf import packed_bsdf_dict

        packed, _ = pack(self.arrays, self.optics.shape[1])
        afar = {} if view is None else {"levels": levels or self.levels, "view": view}
        return packed_bsdf_dict(packed, self.optics, (repeats, repeats), **afar)

    def seen(self, view: View) -> DistantCloth:
        """The cloth inside the BSDF."""
        from weaveusd.render.distance_cloth import DistantCloth

        props = self.dictionary(view)
        return DistantCloth(props, props["packed"], props["optics"], (1.0, 1.0), False)


def _n_v(o: Optics) -> float:
    return normalization(o.eta, o.k_d, o.k_s, o.gamma_s, o.gamma_v)


def system_maps(of: MomentMaps, cloth: Weave) -> SystemMaps:
    """Return moment maps as they are read from an asset."""
    yarns = [yarn.optics for yarn in cloth.yarns]
    own = [yarn.system == ("weft" if of.weft else "warp") for yarn in cloth.yarns]
    maps = {name: of.moments[..., 4 * k : 4 * k + 4] for k, name in enumerate(MOMENTS)}
    opacity = of.moments[..., :3].sum(-1, keepdims=True)
    maps["albedo"] = np.concatenate([of.albedo, opacity], -1)
    spare = MAX_KINDS - of.share.shape[-1]
    maps["kinds"] = np.pad(of.share, [(0, 0), (0, 0), (0, spare)])
    kinds = tuple(next(k for k, o in enumerate(yarns) if o == kind and own[k]) for kind in of.kinds)
    return SystemMaps(maps, of.section.flatness, of.section.curvature, kinds)


def made(notation: str, preset: str) -> Weave:
    """A preset woven after a notation; a brocade is linen of which every other end is of gold."""
    if preset != GOLD[1]:
        return weave(make_draft(notation), read_preset(preset))
    cloth = weave(make_draft(notation), read_preset("linen"))
    gold = replace(cloth.yarns[0], optics=Optics(1.8, 0.0, 1.0, 0.03, 0.06, 0.0))
    ends = cloth.warp_yarn.copy()
    ends[1::2] = len(cloth.yarns)
    return replace(cloth, yarns=(*cloth.yarns, gold), warp_yarn=ends)


@lru_cache(maxsize=8)
def woven(notation: str, preset: str) -> Woven:
    return Woven(made(notation, preset))


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


def test_unlike_yarns_of_one_system_are_shown_by_their_shares(mi: Any) -> None:
    wi, wo = pairs(100)
    cloth = woven(*GOLD)
    assert len(cloth.levels.yarns[0]) == 2
    truth, _ = means(mi, cloth.bsdf(None), wi, wo, 8192)
    maps = moment_maps(cloth.weave, cloth.textures, width=1, height=1)
    expected = evaluate(wi, wo, [m.footprint(0, 0) for m in maps]).T
    found, _ = means(mi, cloth.bsdf(99), wi, wo, 8192)
    assert np.abs(found - expected).sum() / expected.sum() < 0.04
    assert np.abs(found - truth).sum() / truth.sum() < 0.03
    assert abs(found.sum() / truth.sum() - 1) < 0.03
    one = replace(cloth.levels, kinds=None, yarns=((0,), cloth.levels.yarns[1]))
    without, _ = means(mi, cloth.bsdf(99, one), wi, wo, 8192)
    assert np.abs(without - truth).sum() / truth.sum() > 0.06


def test_a_level_of_unlike_yarns_has_the_mean_of_its_texels(mi: Any) -> None:
    wi, wo = pairs(60)
    cloth = woven(*GOLD)
    truth, _ = means(mi, cloth.bsdf(None), wi, wo, 8192)
    for level in (0, 2):
        found, _ = means(mi, cloth.bsdf(level), wi, wo, 8192)
        assert np.abs(found - truth).sum() / truth.sum() < 0.06


@pytest.mark.parametrize("stretch", [(1.0, 1.0), (3.0, 0.5)])
def test_differentials_of_rays_and_the_distance_give_one_level(mi: Any, stretch: Any) -> None:
    from weaveusd.render.distance_cloth import seen_by

    width, height = stretch
    at = mi.ScalarTransform4f().look_at([0.4, 1.5, 4.0], [0, 0, 0], [0, 0, 1])
    film = {"type": "hdrfilm", "width": 64, "height": 64}
    sensor = mi.load_dict({"type": "perspective", "fov": 8.0, "to_world": at, "film": film})
    shape = mi.ScalarTransform4f().rotate([0, 0, 1], 30).scale([width, height, 1])
    scene = mi.load_dict({"type": "scene", "sheet": {"type": "rectangle", "to_world": shape}})
    cloth = woven(*CASES[1]).seen(seen_by(sensor))
    place = mi.Point2f(np.random.default_rng(1).uniform(0.2, 0.8, (2, 64)).astype(np.float32))
    ray, _ = sensor.sample_ray_differential(0.0, 0.5, place, mi.Point2f(0.5))
    si = scene.ray_intersect(ray)
    assert np.array(si.is_valid()).all()
    by_distance = np.array(cloth.pixel(si))
    si.compute_uv_partials(ray)
    by_differentials = np.array(cloth.pixel(si))
    assert (by_distance != by_differentials).any()
    assert np.abs(np.log2(by_differentials / by_distance)).max() < 0.1


def test_the_short_side_of_a_stretched_footprint_decides(mi: Any) -> None:
    from weaveusd.render import probe
    from weaveusd.render.distance_cloth import EVERYTHING_NEAR

    cloth = woven(*CASES[1]).seen(EVERYTHING_NEAR)
    si = probe.interaction((0, 0, 1))
    assert np.array(cloth.pixel(si)) == pytest.approx(0)
    si.dp_du, si.dp_dv = mi.Vector3f(2, 0, 0), mi.Vector3f(0, 4, 0)
    turn, sides = np.radians(30), (0.1, 0.01)
    steps = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) * sides
    si.duv_dx, si.duv_dy = (mi.Vector2f(float(x) / 2, float(y) / 4) for x, y in steps.T)
    assert np.array(cloth.pixel(si)) == pytest.approx(0.01, rel=1e-3)


SIZE = 16


def sheet(mi: Any, cells: float, fov: float = 4.0) -> Any:
    """A sheet under a sun, looked at from so far that a pixel is as large as so many cells."""
    from weaveusd.render.distance_cloth import View, seen_by, with_view

    cloth = woven(*CASES[1])
    cell = 1 / np.sqrt(cloth.levels.rows[0] * cloth.levels.columns[0])
    distance = cells * cell * SIZE / (2 * np.tan(np.radians(fov / 2)))
    at = mi.ScalarTransform4f().look_at(
        [0, -0.5 * distance, 0.866 * distance], [0, 0, 0], [0, 0, 1]
    )
    sensor = {
        "type": "perspective", "fov": fov, "to_world": at, "near_clip": 1e-3,
        "film": {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}},
    }  # fmt: skip
    bsdf = cloth.dictionary(View(), repeats=100.0)
    return mi.load_dict({
        "type": "scene", "sensor": sensor, "integrator": {"type": "path", "max_depth": 2},
        "sun": {"type": "directional", "direction": [0.3, -0.4, -0.8], "irradiance": 1.0},
        "sheet": {"type": "rectangle", "bsdf": with_view(bsdf, seen_by(mi.load_dict(sensor))),
                  "to_world": mi.ScalarTransform4f().scale(50)},
    })  # fmt: skip


def test_a_sheet_is_as_bright_at_every_distance_across_the_change(mi: Any) -> None:
    from weaveusd.render.trace import trace

    found = [
        float(trace(sheet(mi, cells), (SIZE, SIZE), 1024, 1).mean())
        for cells in np.geomspace(1.5, 12, 12)
    ]
    assert np.abs(np.diff(found)).max() < 0.03 * np.mean(found)
    assert found[-1] == pytest.approx(found[0], rel=0.03)


@pytest.mark.parametrize(
    ("cells", "fov", "texels", "far"),
    [(2, 4, True, False), (40, 4, False, True), (5.6, 4, True, True), (4.5, 110, True, True)],
)
def test_a_look_leaves_out_what_a_picture_does_not_show(
    mi: Any, monkeypatch: pytest.MonkeyPatch, cells: float, fov: float, texels: bool, far: bool
) -> None:
    from weaveusd.render import trace

    scene = sheet(mi, cells, fov)
    found = trace.trace(scene, (SIZE, SIZE), 16, 1)
    (shape,) = scene.shapes()
    cloth = shape.bsdf().cloth
    assert (cloth.shows_texels, cloth.shows_cells) == (texels, far)
    cloth.shows_texels = cloth.shows_cells = True
    monkeypatch.setattr(trace, "look", lambda scene: None)
    expected = trace.trace(scene, (SIZE, SIZE), 16, 1)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-5)


def test_a_cloth_with_levels_seen_near_is_the_cloth_without(mi: Any) -> None:
    from weaveusd.render.distance_cloth import EVERYTHING_NEAR

    wi, wo = pairs(40)
    cloth = woven(*CASES[1])
    near = mi.load_dict(cloth.dictionary(EVERYTHING_NEAR), parallel=False)
    expected, _ = means(mi, cloth.bsdf(None), wi, wo, 64)
    found, _ = means(mi, near, wi, wo, 64)
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-6)


def test_the_blend_from_near_to_far_is_continuous(mi: Any) -> None:
    from weaveusd.render import probe
    from weaveusd.render.distance_cloth import View

    cloth = woven(*CASES[0])
    cell = 1 / np.sqrt(cloth.levels.rows[0] * cloth.levels.columns[0])
    count = 1 << 18
    uv = np.random.default_rng(5).random((2, count)).astype(np.float32)
    si = probe.interaction(direction(40, 20), count, uv)
    wo = mi.Vector3f(*direction(35, 190))
    found = []
    for footprint in np.geomspace(0.5, 16, 21) * cell:
        seen = cloth.dictionary(View(constant=float(footprint)))
        value = mi.load_dict(seen, parallel=False).eval(mi.BSDFContext(), si, wo)
        found.append(float(np.array(value).mean()))
    steps = np.abs(np.diff(found)) / np.mean(found)
    assert steps.max() < 0.06
    assert found[-1] == pytest.approx(found[0], rel=0.15)


@pytest.mark.parametrize("case", [CASES[0], CASES[1], GAPS, GOLD])
def test_samples_from_afar_follow_their_density(mi: Any, case: Any) -> None:
    from weaveusd.render import probe

    bsdf = Woven(made(*case), dense=True).bsdf(99)
    angles = ((0, 0), (30, 40), (70, 100), (150, 70))
    for angle in angles:
        found = probe.chi_square(bsdf, direction(*angle))
        assert not found.fault
        assert found.p_value >= probe.least_p_value(len(angles) * 4)
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


@pytest.mark.parametrize("shape", [(8, 8), (9, 6), (7, 1), (1, 11), (3, 2), (21, 13)])
def test_every_level_is_the_mean_of_the_finest_for_sizes_of_any_kind(shape: Any) -> None:
    values = np.random.default_rng(4).random((*shape, 3), np.float32)
    coarse = values
    while coarse.shape[:2] != (1, 1):
        rows, columns = coarse.shape[:2]
        coarse = distance_levels.coarser(coarse)
        assert coarse.shape[:2] == (max(1, rows // 2), max(1, columns // 2))
        np.testing.assert_allclose(coarse.mean((0, 1)), values.mean((0, 1)), rtol=1e-5)
    expected = reduced(values, max(1, shape[1] // 2), max(1, shape[0] // 2))
    np.testing.assert_allclose(distance_levels.coarser(values), expected, rtol=1e-5)


def test_shares_of_a_level_are_the_opacity_of_its_texels() -> None:
    cloth = woven(*GAPS)
    numbers = cloth.levels.numbers[-1].reshape(2, -1)
    opacity = np.where(cloth.arrays["yarn_id"] < 0, 0, cloth.arrays["opacity"]).mean()
    assert numbers[:, : distance_levels.FALL + 1].sum() == pytest.approx(opacity, rel=1e-5)


def test_yarns_in_one_frame_make_a_box_without_width() -> None:
    one = {
        "slopes": (0, 0.5, 0, -0.1),
        "along": (0.15, 0.045, 0, 0),
        "across": (0.1, 0.02, 0.05, 0.005),
        "albedo": (0.2, 0.1, 0, 0.5),
    }
    maps = {name: np.full((4, 4, 4), values, np.float32) for name, values in one.items()}
    warp = SystemMaps(maps, 0.5, 0.3, (0,))
    weft = SystemMaps({name: np.zeros_like(a) for name, a in maps.items()}, 1.0, 0.0, (0,))
    whole = distance_levels.make_levels(warp, weft).numbers[-1]
    assert whole[distance_levels.RISE] == pytest.approx(0.5)
    for low, place in (("RISE_LOW", 0.3), ("ASIDE_LOW", 0.2), ("TWIST_LOW", 0.1)):
        at = getattr(distance_levels, low)
        assert whole[at : at + 2] == pytest.approx(place, abs=1e-3)
    assert whole[distance_levels.RIGHT] == 0
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


@pytest.mark.parametrize("lod", ["half", -1, 99])
def test_a_level_of_detail_that_is_none_is_refused(mi: Any, tmp_path: Any, lod: Any) -> None:
    with pytest.raises(InputError, match="expected auto, full or 0 to 23"):
        render(tmp_path / "none.usda", lod=lod)
