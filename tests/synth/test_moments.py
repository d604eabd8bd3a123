"""Moment maps: linear, exact for a single texel, the same for both systems, the same bits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.synth.moments_by_numpy import channels, texel_moments
from tests.weaves import plain, satin, twill, woven
from weaveusd.synth import moments as m
from weaveusd.synth.boxes import reduced
from weaveusd.synth.moment_sums import MomentSums
from weaveusd.synth.moments import map_size, moment_maps, sections
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import read_preset


def maps_of(weave, width, height, resolution=48, **settings):
    textures = synthesize(weave, resolution=resolution, jobs=1)
    return moment_maps(weave, textures, width=width, height=height, **settings)


def finest(weave, resolution=48):
    textures = synthesize(weave, resolution=resolution)
    maps = moment_maps(weave, textures, width=textures.width, height=textures.height)
    return textures.whole(), maps


@given(st.integers(1, 9), st.integers(1, 9), st.integers(1, 9), st.integers(1, 9))
def test_a_reduced_image_has_the_mean_of_the_larger_one(height, width, lower, narrower):
    values = np.random.default_rng(height * 10 + width).random((height, width, 2))
    small = reduced(values, min(width, narrower), min(height, lower))
    np.testing.assert_allclose(small.mean((0, 1)), values.mean((0, 1)), atol=1e-13)
    assert small.min() >= values.min() - 1e-12
    assert small.max() <= values.max() + 1e-12


def test_even_pieces_are_plain_means_and_uneven_ones_share_texels():
    values = np.arange(6.0).reshape(1, 6, 1)
    assert reduced(values, 3, 1).ravel().tolist() == [0.5, 2.5, 4.5]
    assert reduced(values, 4, 1).ravel() == pytest.approx([1 / 3, 5 / 3, 10 / 3, 14 / 3])
    assert reduced(values, 6, 1).ravel().tolist() == values.ravel().tolist()


@pytest.mark.parametrize("preset", ["linen", "crepe_de_chine"])
def test_the_moments_of_a_union_are_the_mean_of_those_of_its_parts(preset):
    """So an ordinary mip map of the finest maps has the moments of every footprint."""
    for whole in maps_of(woven(twill(), preset), 8, 8, resolution=64):
        halves = whole.reduced(4, 8)
        for fine, coarse in zip(
            (whole.moments, whole.albedo, whole.share),
            (halves.moments, halves.albedo, halves.share),
            strict=True,
        ):
            mean = 0.5 * (fine[:, ::2] + fine[:, 1::2])
            np.testing.assert_allclose(coarse, mean, atol=1e-6)
    direct = maps_of(woven(twill(), preset), 1, 1, resolution=64)
    for maps, one in zip(maps_of(woven(twill(), preset), 7, 5, resolution=64), direct, strict=True):
        *_, last = maps.levels()
        np.testing.assert_allclose(last.moments, one.moments, atol=1e-6)
        np.testing.assert_allclose(last.albedo, one.albedo, atol=1e-6)


@pytest.mark.parametrize("size", [(1, 1), (7, 5), (16, 12), (48, 37), (44, 48)])
def test_the_compiled_loop_adds_what_the_definition_says(size):
    weave, gains = woven(twill(), "linen"), (1.2, 0.9)
    textures = synthesize(weave, resolution=48)
    width, height = min(size[0], textures.width), min(size[1], textures.height)
    found = moment_maps(weave, textures, width=width, height=height, gains=gains)
    expected = channels(textures.whole(), weave, width, height, gains)
    for maps, wanted in zip(found, expected, strict=True):
        got = np.concatenate([maps.moments, maps.albedo, maps.share], -1)
        np.testing.assert_allclose(got, wanted, atol=1e-7)


def test_maps_that_are_published_have_four_texels_a_thread_and_no_more_than_are_bounded():
    draft = woven(twill())
    assert map_size(draft, (1024, 1024)) == (16, 16)
    assert map_size(draft, (1024, 11)) == (16, 11)
    large = replace(draft, warp_up=np.ones((300, 2000), bool))
    assert map_size(large, (4096, 4096)) == (512, 150)
    assert map_size(replace(draft, warp_up=np.ones((1, 90_000), bool)), (8192, 8)) == (8192, 4)


def test_levels_halve_down_to_one_texel():
    warp, _ = maps_of(woven(plain()), 12, 5)
    sizes = [level.share.shape[:2] for level in warp.levels()]
    assert sizes == [(5, 12), (2, 6), (1, 3), (1, 1)]


def test_a_single_texel_has_no_variance_and_opacity_is_the_sum():
    texels, both = finest(woven(satin(), "charmeuse"))
    for maps in both:
        a = maps.moments[..., [m.FLAT, m.RISING, m.FALLING]].sum(-1)
        np.testing.assert_allclose(maps.share.sum(-1), a, atol=1e-7)
        for first, second, share in (
            (m.RISING_S, m.RISING_SS, maps.moments[..., m.RISING]),
            (m.FALLING_S, m.FALLING_SS, maps.moments[..., m.FALLING]),
            (m.ACROSS, m.ACROSS_XX, a),
            (m.TWIST, m.TWIST_PP, a),
        ):
            mean, square = maps.moments[..., first], maps.moments[..., second]
            np.testing.assert_allclose(share * square, mean**2, atol=1e-6)
        np.testing.assert_allclose(np.abs(maps.moments[..., m.ACROSS]), maps.moments[..., m.ASIDE])
    opacity = sum(maps.share.sum(-1) for maps in both)
    np.testing.assert_allclose(opacity, texels["opacity"][..., 0], atol=1e-7)


def test_a_whole_circular_float_is_a_box_across_and_along():
    """Means and variances of an even distribution: X over the width, S over the visible length."""
    _, (warp, _) = finest(woven(plain(), "polyester"), 256)
    moments = warp.moments.astype(float).mean((0, 1))
    a = moments[[m.FLAT, m.RISING, m.FALLING]].sum()
    assert moments[m.ACROSS] / a == pytest.approx(0, abs=0.02)
    assert 3 * moments[m.ACROSS_XX] / a == pytest.approx(1, abs=0.05)
    assert moments[m.RISING] == pytest.approx(moments[m.FALLING], rel=0.05)
    mean = moments[m.RISING_S] / moments[m.RISING]
    variance = moments[m.RISING_SS] / moments[m.RISING] - mean**2
    assert variance == pytest.approx(mean**2 / 3, rel=0.05)


def test_a_turned_cloth_exchanges_warp_and_weft():
    """Turned by 90° about Z the warp becomes a weft; its moments are the same, place by place."""
    texels, (warp, _) = finest(woven(twill(3, 1), "linen"), 32)
    turned = {name: np.rot90(array, -1) for name, array in texels.items()}
    for name in ("normal", "tangent"):
        x, y, z = np.moveaxis(turned[name], -1, 0)
        turned[name] = np.stack([y, -x, z], -1)
    turned["system"] = np.where(turned["system"] < 0, -1, 1 - turned["system"])
    found = texel_moments(turned, warp.section, weft=True)
    np.testing.assert_allclose(np.rot90(warp.moments, -1), found, atol=1e-6)


def test_a_fibre_told_backwards_is_the_same_fibre():
    texels, (_, weft) = finest(woven(twill(), "linen"))
    back = {**texels, "tangent": -texels["tangent"]}
    np.testing.assert_allclose(
        texel_moments(back, weft.section, weft=True), weft.moments, atol=1e-6
    )


def test_twist_is_the_sine_of_the_yarn_s_angle():
    weave = woven(plain(), "linen")
    still = tuple(replace(y, twist_angle=0.3, twist_deviation=0.0) for y in weave.yarns)
    for maps in finest(replace(weave, yarns=still))[1]:
        full = maps.share[..., 0] == 1
        np.testing.assert_allclose(maps.moments[full][:, m.TWIST], np.sin(0.3), atol=1e-5)


def test_yarns_of_one_kind_share_a_channel_and_their_albedo_has_their_gain():
    weave = woven(twill(), "shot_silk")
    other = read_preset("linen").yarns[0].optics
    weave = replace(weave, yarns=(*weave.yarns, replace(weave.yarns[0], optics=other)))
    in_turn = np.where(np.arange(4) % 2, 2, 0).astype(np.int32)
    in_turn.flags.writeable = False
    half = replace(weave, warp_yarn=in_turn)
    warp, weft = maps_of(half, 1, 1, gains=(1.0, 0.5, 1.0))
    assert warp.kinds == (weave.yarns[0].optics, other)
    assert weft.kinds == (weave.yarns[1].optics,)
    assert warp.share[0, 0, 0] == pytest.approx(warp.share[0, 0, 1], rel=0.1)
    plain_maps = maps_of(half, 1, 1)
    np.testing.assert_allclose(weft.albedo, 0.5 * plain_maps[1].albedo, rtol=1e-6)
    np.testing.assert_array_equal(warp.albedo, plain_maps[0].albedo)


def test_bands_and_jobs_do_not_change_a_bit(monkeypatch):
    weave = woven(satin(), "linen")
    whole = maps_of(weave, 9, 7, resolution=64)
    monkeypatch.setattr(m, "BAND_TEXELS", 192)
    textures = synthesize(weave, resolution=64, jobs=2)
    for one, other in zip(whole, moment_maps(weave, textures, width=9, height=7), strict=True):
        assert one.moments.tobytes() == other.moments.tobytes()
        assert one.albedo.tobytes() == other.albedo.tobytes()


def test_sums_take_each_row_once():
    weave = woven(plain())
    textures = synthesize(weave, resolution=16)
    sums = MomentSums(weave, (textures.width, textures.height), width=4, height=4)
    with pytest.raises(ValueError, match=f"0 rows, expected {textures.height}"):
        sums.maps()
    sums.add(textures.whole())
    with pytest.raises(ValueError, match="expected at most"):
        sums.add(textures.band(0, 1))


def test_a_system_that_never_shows_has_maps_of_nothing():
    weave = woven(twill(), "polyester")
    textures = synthesize(weave, resolution=16)
    bare = {**(texels := textures.whole()), "opacity": np.where(texels["system"] == 1, 0, 1)}
    sums = MomentSums(weave, (textures.width, textures.height), width=4, height=4)
    sums.add({name: np.asarray(array, np.float32) for name, array in bare.items()})
    warp, weft = sums.maps()
    assert warp.share.any()
    assert not weft.moments.any()
    assert not weft.share.any()


def test_maps_are_read_only_and_no_larger_than_the_textures():
    weave = woven(plain())
    (warp, _) = maps_of(weave, 4, 4)
    assert not warp.moments.flags.writeable
    for width, height in ((0, 4), (4, 99)):
        with pytest.raises(ValueError, match=f"{width} × {height} texels, expected 1 × 1 to"):
            maps_of(weave, width, height)


@pytest.mark.parametrize("preset", ["linen", "charmeuse", "denim", "chiffon"])
def test_sections_are_of_the_yarns(preset):
    weave = woven(twill(), preset)
    for section, system in zip(sections(weave), ("warp", "weft"), strict=True):
        yarn = next(y for y in weave.yarns if y.system == system)
        assert section.flatness == pytest.approx(yarn.height_mm / yarn.width_mm, rel=0.3)
        assert 0 < section.curvature < 2


def test_a_thread_that_never_bends_has_no_curvature():
    warp, _ = sections(woven(np.array([[True, False], [True, True]])[:1, :1], "linen"))
    assert warp.curvature == 0


def test_no_texel_of_the_maps_has_an_albedo_above_1():
    weave = woven(twill(), "linen")
    for maps in maps_of(weave, 16, 16, gains=(3.0, 3.0)):
        most = maps.moments[..., :3].sum(-1, keepdims=True)
        assert (maps.albedo <= most * (1 + 1e-6)).all()
