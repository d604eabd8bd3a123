"""The cloth from afar: one texel is the exact BSDF, a tile the mean of its texels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.weaves import plain, satin, twill, woven
from weaveusd.shading.directions import pairs
from weaveusd.shading.distance import FULL, LEAN, Nodes, evaluate, parameters
from weaveusd.shading.fibre import dot, facing
from weaveusd.shading.longitudinal import mean_profile, profile
from weaveusd.shading.microcylinder import evaluate as exact
from weaveusd.synth import moments as m
from weaveusd.synth.moments import Footprint, Section, moment_maps
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import read_preset

WI, WO = pairs(96)


def cloth(warp_up, preset, resolution=64):
    weave = woven(warp_up, preset)
    textures = synthesize(weave, resolution=resolution)
    maps = moment_maps(weave, textures, width=textures.width, height=textures.height)
    return weave, textures.whole(), maps


def of_texels(weave, texels, rows, columns, wi=WI, wo=WO):
    """The mean of the exact BSDF over texels, light only where yarn and cloth agree."""
    total = np.zeros((len(wi), 3))
    for row, column in zip(rows, columns, strict=True):
        yarn = int(texels["yarn_id"][row, column, 0])
        if yarn < 0:
            continue
        n, t, color = (
            texels[name][row, column].astype(float) for name in ("normal", "tangent", "base_color")
        )
        n = n / np.linalg.norm(n)
        t = t - n * (n @ t)
        params = parameters(weave.yarns[yarn].optics)._replace(A=color)
        value = exact(wi, wo, n, t / np.linalg.norm(t), params)
        front = dot(facing(np.broadcast_to(n, wi.shape), wi), wo) > 0
        agrees = front == (wi[:, 2] * wo[:, 2] > 0)
        total += value * agrees[:, None] * texels["opacity"][row, column, 0]
    return total / len(rows)


def off(found, truth):
    return np.abs(found - truth).sum() / truth.sum()


def of_tile(weave, texels, maps, nodes=FULL):
    """Errors of the tile's moments, and Σ f̂ / Σ f."""
    height, width = texels["opacity"].shape[:2]
    # Every fifth texel of each row, shifted from row to row.
    row, column = np.divmod(np.arange(height * width), width)
    chosen = (column + 2 * row) % 5 == 0
    truth = of_texels(weave, texels, row[chosen], column[chosen])
    found = evaluate(WI, WO, [one.reduced(1, 1).footprint(0, 0) for one in maps], nodes)
    return off(found, truth), found.sum() / truth.sum()


def footprint(moments, kinds=None, weft=False):
    kinds = kinds or (read_preset("silk").yarns[0].optics,)
    share = np.full(len(kinds), 1 / len(kinds))
    return Footprint(weft, Section(0.5, 0.1), np.asarray(moments), np.full(3, 0.5), share, kinds)


def bent(low=0.1, high=0.5, across=0.3, twist=0.0):
    """Moments of yarn that rises evenly from `low` to `high`, even across within ±`across`."""
    mean, square = 0.5 * (low + high), (low * low + low * high + high * high) / 3
    out = np.zeros(m.MOMENTS)
    out[m.RISING], out[m.RISING_S], out[m.RISING_SS] = 1, mean, square
    out[m.ASIDE], out[m.ACROSS_XX] = 0.5 * across, across**2 / 3
    out[m.TWIST], out[m.TWIST_PP] = twist, twist**2
    return out


@pytest.mark.parametrize("preset", ["silk", "linen", "shot_silk", "canvas"])
def test_a_texel_without_variance_is_shaded_as_the_exact_bsdf(preset):
    weave, texels, maps = cloth(twill(), preset)
    rng = np.random.default_rng(0)
    height, width = texels["opacity"].shape[:2]
    for row, column in rng.integers((height, width), size=(24, 2)):
        truth = of_texels(weave, texels, [row], [column])
        found = evaluate(WI, WO, [one.footprint(row, column) for one in maps])
        # The middle of a float is straight to within 0.06°.
        np.testing.assert_allclose(found, truth, rtol=0.04, atol=2e-4)
        assert off(found, truth) < 0.01 if truth.any() else not found.any()


@pytest.mark.parametrize("seen", [1, -1])
@pytest.mark.parametrize("lit", [1, -1])
def test_every_side_of_the_cloth_is_the_exact_one(seen, lit):
    weave, texels, maps = cloth(plain(), "chiffon")
    wi, wo = WI * (1, 1, seen), WO * (1, 1, lit)
    for row, column in ((5, 9), (22, 30), (40, 3)):
        truth = of_texels(weave, texels, [row], [column], wi, wo)
        found = evaluate(wi, wo, [one.footprint(row, column) for one in maps])
        np.testing.assert_allclose(found, truth, rtol=0.02, atol=1e-4)


@pytest.mark.parametrize(
    ("warp_up", "preset"),
    [(plain(), "silk"), (plain(), "polyester"), (twill(), "linen"), (satin(), "shot_silk")],
)
def test_a_tile_is_within_4_percent_of_its_texels(warp_up, preset):
    error, radiance = of_tile(*cloth(warp_up, preset))
    assert error < 0.04
    assert radiance == pytest.approx(1, abs=0.02)


def test_lean_nodes_keep_the_mean_radiance():
    error, radiance = of_tile(*cloth(plain(), "silk"), LEAN)
    assert error < 0.06
    assert radiance == pytest.approx(1, abs=0.03)


def test_long_and_short_floats_in_one_system_keep_the_mean_radiance():
    face, back = np.tile(satin(), (2, 2)), np.tile(~satin(), (2, 2))
    made = cloth(np.block([[face, back], [back, face]]), "linen", 160)
    error, radiance = of_tile(*made)
    assert error < 0.04
    assert radiance == pytest.approx(1, abs=0.02)


def test_fewer_nodes_cost_accuracy_and_more_nodes_gain_it():
    made = cloth(plain(), "polyester")
    finest, full, lean = (of_tile(*made, nodes)[0] for nodes in (Nodes(5, 5), FULL, LEAN))
    assert finest < full < lean < 0.06


def test_a_footprint_across_two_yarns_keeps_both_slopes():
    """Halves of two neighbors are no yarn between them: both halves of X are told apart."""
    weave, texels, maps = cloth(twill(), "polyester", 128)
    height, width = texels["opacity"].shape[:2]
    # A quarter of a crossing at the border of two ends that are both on top.
    column = np.arange(width // 4 - width // 32, width // 4 + width // 32)
    row = np.arange(height // 32)
    rows, columns = (grid.ravel() for grid in np.meshgrid(row, column))
    truth = of_texels(weave, texels, rows, columns)
    found = evaluate(
        WI, WO,
        [
            replace(
                one.footprint(0, 0),
                moments=one.moments[rows, columns].mean(0),
                albedo=one.albedo[rows, columns].mean(0),
                share=one.share[rows, columns].mean(0),
            )
            for one in maps
        ],
    )  # fmt: skip
    assert off(found, truth) < 0.08


def test_weft_is_the_warp_turned():
    moments = bent()
    warp = evaluate(WI, WO, [footprint(moments)])
    turned_wi, turned_wo = (np.stack([w[:, 1], -w[:, 0], w[:, 2]], -1) for w in (WI, WO))
    weft = evaluate(turned_wi, turned_wo, [footprint(moments, weft=True)])
    np.testing.assert_allclose(weft, warp, rtol=1e-12)


def test_rising_and_falling_are_mirror_images():
    rising = bent()
    falling = np.zeros(m.MOMENTS)
    falling[[m.FALLING, m.FALLING_SS]] = rising[[m.RISING, m.RISING_SS]]
    falling[m.FALLING_S] = -rising[m.RISING_S]
    falling[[m.ASIDE, m.ACROSS_XX]] = rising[[m.ASIDE, m.ACROSS_XX]]
    mirrored = (1, -1, 1)
    np.testing.assert_allclose(
        evaluate(WI * mirrored, WO * mirrored, [footprint(falling)]),
        evaluate(WI, WO, [footprint(rising)]),
        rtol=1e-9,
    )


def test_footprints_add_up_and_share_their_kinds_linearly():
    silk, linen = (read_preset(name).yarns[0].optics for name in ("silk", "linen"))
    each = [evaluate(WI, WO, [footprint(bent(), kinds=(o,))]) for o in (silk, linen)]
    both = evaluate(WI, WO, [footprint(bent(), kinds=(silk, linen))])
    np.testing.assert_allclose(both, 0.5 * (each[0] + each[1]), rtol=1e-9)
    half = replace(
        footprint(0.5 * bent(), kinds=(silk,)), albedo=np.full(3, 0.25), share=np.full(1, 0.5)
    )
    np.testing.assert_allclose(evaluate(WI, WO, [half, half]), each[0], rtol=1e-9)


def test_nothing_under_a_footprint_sends_nothing_back():
    empty = replace(footprint(np.zeros(m.MOMENTS)), albedo=np.zeros(3), share=np.zeros(1))
    assert not evaluate(WI, WO, [empty]).any()


@pytest.mark.parametrize("preset", ["silk", "polyester", "linen"])
def test_no_more_light_comes_back_than_there_is(preset):
    kinds = (read_preset(preset).yarns[0].optics,)
    # Midpoints in z and azimuth; of the half sphere above, and of that below.
    z, turn = np.meshgrid((np.arange(-40, 40) + 0.5) / 40, 2 * np.pi * (np.arange(80) + 0.5) / 80)
    level = np.sqrt(1 - z**2)
    wo = np.stack([level * np.cos(turn), level * np.sin(turn), z], -1).reshape(-1, 3)
    for low, high, across in ((0.0, 0.8, 1.0), (0.3, 0.35, 0.4), (0.6, 0.9, 0.05)):
        white = replace(footprint(bent(low, high, across), kinds), albedo=np.ones(3))
        for wi in ((0.1, 0.2, 0.97), (0.8, 0.1, 0.5), (-0.1, 0.95, 0.2)):
            view = np.broadcast_to(np.asarray(wi) / np.linalg.norm(wi), wo.shape)
            albedo = evaluate(view, wo, [white]).mean(0) * 4 * np.pi
            assert 0.05 < albedo.max() <= 1


@pytest.mark.parametrize("nodes", [FULL, LEAN])
def test_what_moments_tell_changes_evenly_with_them(nodes):
    """From yarn in one place, over parts apart and boxes that reach 0, to a whole tile."""
    _, _, maps = cloth(twill(), "linen")
    warp = maps[0]
    row, column = np.argwhere(warp.moments[..., m.RISING] == 1)[0]
    first, last = warp.footprint(row, column), warp.reduced(1, 1).footprint(0, 0)
    steps = np.linspace(0, 1, 101)[:, None]
    wi, wo = WI[:24], WO[:24]
    # Little changes fast near a single texel, whose deviation is the root of what is added.
    mixed = (1 - steps**3) * first.moments + steps**3 * last.moments
    values = np.stack([evaluate(wi, wo, [replace(first, moments=x)], nodes) for x in mixed])
    step = np.abs(np.diff(values, axis=0)).sum((1, 2)) / values.sum((1, 2)).max()
    assert step.max() < 0.05


def test_half_floats_are_enough():
    _, _, maps = cloth(plain(), "polyester")
    whole = [one.reduced(1, 1).footprint(0, 0) for one in maps]
    rounded = [replace(one, moments=one.moments.astype(np.float16)) for one in whole]
    assert off(evaluate(WI, WO, rounded), evaluate(WI, WO, whole)) < 2e-3


@pytest.mark.parametrize("is_gaussian", [False, True])
def test_the_mean_of_a_profile_is_its_integral_over_the_length(is_gaussian):
    low, high = np.array([-0.3, -2.0, 0.4]), np.array([0.5, 1.0, 0.4])
    x = np.linspace(low, high, 20_001)
    expected = profile(0.1, x, is_gaussian=is_gaussian).mean(0)
    found = mean_profile(0.1, low, high, is_gaussian=is_gaussian)
    np.testing.assert_allclose(found, expected, rtol=1e-3)
    back = mean_profile(0.1, high, low, is_gaussian=is_gaussian)
    np.testing.assert_allclose(found, back, rtol=1e-12)


@pytest.mark.parametrize("nodes", [FULL, LEAN])
def test_a_trace_of_straight_yarn_changes_nothing(nodes):
    """Which strand has which twist does not hang on what else there is."""
    moments = bent(twist=0.2)
    moments[m.TWIST_PP] = 0.1
    none = evaluate(WI, WO, [footprint(moments)], nodes)
    moments[m.FLAT] = 2e-7
    np.testing.assert_allclose(evaluate(WI, WO, [footprint(moments)], nodes), none, rtol=1e-4)
