"""Standard shaders are fitted to the tile: never worse than flat, the same on every run."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.shading import fits
from weaveusd.shading.directions import LOWEST, pairs
from weaveusd.shading.lobe import BENT, albedos, fresnel_edge, halfway, lit, mirror
from weaveusd.shading.measured import measured, texels_of
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import read_preset

UP, ALONG = np.array([[0.0, 0.0, 1.0]]), np.array([[0.0, 1.0, 0.0]])


def seen(preset, resolution=96, notation=None, **yarn):
    recipe = read_preset(preset)
    made = weave(make_draft(notation or recipe.weave or "plain"), recipe)
    made = replace(made, yarns=tuple(replace(y, **yarn) for y in made.yarns))
    texels = texels_of(made, synthesize(made, resolution=resolution))
    return made, texels, measured(made, texels)


@pytest.mark.parametrize("preset", ["linen", "charmeuse", "polyester", "shot_silk", "denim"])
def test_more_freedom_fits_better_and_no_shader_is_off_by_most_of_the_light(preset):
    found = fits.fit_standard(*seen(preset))
    errors = found.errors
    assert 0 < errors.preview < 0.7
    # What is fitted is another half of the pairs than what is judged.
    assert 0 < errors.openpbr <= errors.standard_surface + 0.02
    assert errors.standard_surface <= errors.preview + 0.02
    for fit in (found.together, found.isotropic, *found.yarns):
        assert 0 < fit.alpha_along <= fit.alpha_across <= 1
        assert fits.F0_LIMITS[0] <= fit.f0 <= fits.F0_LIMITS[1]
        assert 0 <= fit.base <= 1
    assert len({(fit.f0, fit.base) for fit in found.yarns}) == 1


def test_a_highlight_is_narrow_along_a_silk_of_flat_floats():
    found = fits.fit_standard(*seen("charmeuse"))
    assert found.together.alpha_along < 0.3 * found.together.alpha_across
    assert found.isotropic.alpha_along == found.isotropic.alpha_across


@pytest.mark.parametrize("preset", ["charmeuse", "polyester", "shot_silk"])
def test_from_afar_one_lobe_stands_for_the_tile_about_as_well_as_each_yarn_s_own(preset):
    found = fits.fit_standard(*seen(preset))
    afar, errors = found.afar, found.errors
    assert errors.openpbr_afar < errors.openpbr + 0.1
    assert errors.preview_afar < errors.preview + 0.1
    assert afar.openpbr.alpha_along >= min(fit.alpha_along for fit in found.yarns)
    assert afar.preview.alpha_along == afar.preview.alpha_across
    # The constants of a network are the same at every distance.
    for one, yarns in ((afar.openpbr, found.yarns), (afar.preview, found.isotropic_yarns)):
        assert {(one.f0, one.base)} == {(fit.f0, fit.base) for fit in yarns}


@pytest.mark.parametrize(("draft", "fibres"), [("satin:5:2", "warp"), ("sateen:5:2", "weft")])
def test_from_afar_the_highlight_lies_across_the_floats_that_show(draft, fibres):
    assert fits.fit_standard(*seen("polyester", notation=draft)).afar.fibres == fibres


def test_each_yarn_has_a_roughness_for_shaders_that_know_no_direction():
    found = fits.fit_standard(*seen("charmeuse"))
    assert len(found.isotropic_yarns) == len(found.yarns)
    for fit in found.isotropic_yarns:
        assert fit.alpha_along == fit.alpha_across


def test_the_same_cloth_gets_the_same_fit_at_nearly_any_resolution():
    coarse, again, fine = (fits.fit_standard(*seen("linen", r)) for r in (96, 96, 384))
    assert coarse == again
    assert coarse.errors.openpbr == pytest.approx(fine.errors.openpbr, abs=0.04)


def test_a_yarn_that_nothing_shows_gets_the_lobe_of_all():
    made, texels, gains = seen("linen")
    hidden = replace(made, yarns=(*made.yarns, made.yarns[0]))
    found = fits.fit_standard(hidden, [*texels, None], [*gains, gains[0]])
    assert found.yarns[:2] == fits.fit_standard(made, texels, gains).yarns
    assert found.yarns[2].alpha_along == found.together.alpha_along


def test_a_black_cloth_without_gloss_has_a_fit_too():
    made, texels, _ = seen("linen", color=(0.0, 0.0, 0.0))
    yarns = tuple(replace(y, optics=replace(y.optics, k_s=0.0)) for y in made.yarns)
    black = replace(made, yarns=yarns)
    found = fits.fit_standard(black, texels, measured(black, texels))
    assert found.together.f0 == fits.F0_LIMITS[0]
    assert np.isfinite(found.errors.openpbr)


def test_many_yarns_of_equal_optics_cost_what_one_does():
    made, texels, gains = seen("linen")
    many = replace(made, yarns=made.yarns * 60)
    begun = time.process_time()
    fits.fit_standard(many, list(texels) * 60, list(gains) * 60)
    assert time.process_time() - begun < 2


@given(st.floats(0, 1), st.floats(*fits.F0_LIMITS))
def test_numbers_within_their_bounds_are_found_again(x, z):
    a, b = np.random.default_rng(0).random((2, 40, 3)) + 0.1
    found = fits._bounded(a, b, x * a + z * b, np.ones_like(a))
    assert found == pytest.approx((x, z), abs=1e-6)


@given(st.floats(-2, 3), st.floats(-1, 1))
def test_numbers_outside_end_at_the_best_point_of_the_box(x, z):
    a, b = np.random.default_rng(1).random((2, 40, 3)) + 0.1
    y = x * a + z * b

    def off(p):
        return np.sum((p[0] * a + p[1] * b - y) ** 2)

    found = fits._bounded(a, b, y, np.ones_like(a))
    grid = [(p, q) for p in np.linspace(0, 1, 21) for q in np.linspace(*fits.F0_LIMITS, 21)]
    assert off(found) <= min(map(off, grid)) + 1e-9


@pytest.mark.parametrize("alpha", [0.1, 0.4, 1.0])
def test_the_lobe_is_reciprocal_and_reflects_no_more_than_it_receives(alpha):
    wi, wo = pairs(64)
    there = mirror(lit(UP, ALONG, wi, wo), alpha, 1.0)[0] / wo[:, 2]
    back = mirror(lit(UP, ALONG, wo, wi), alpha, 1.0)[0] / wi[:, 2]
    np.testing.assert_allclose(there, back, rtol=1e-9)
    direct, edge = albedos(alpha)
    assert np.all(direct > 0)
    assert np.all(direct + edge <= 1.01)


def test_albedos_are_what_the_lobe_adds_up_to():
    wo = np.random.default_rng(2).normal(size=(200_000, 3))
    wo /= np.linalg.norm(wo, axis=-1, keepdims=True)
    wo[:, 2] = np.abs(wo[:, 2])
    cosine = 13.5 / 16
    wi = np.broadcast_to(np.array([np.sqrt(1 - cosine**2), 0, cosine]), wo.shape)
    direct, edge = albedos(0.5)
    found = 2 * np.pi * mirror(lit(UP, ALONG, wi, wo), 0.5, 0.5)[0].mean()
    assert direct[13] + edge[13] == pytest.approx(found, rel=0.02)


def test_the_lobe_in_the_mirror_s_direction_is_the_closed_form():
    wi = np.array([[0.6, 0.0, 0.8]])
    value = mirror(lit(UP, ALONG, wi, wi * (-1, 1, 1)), 0.2, 0.5)
    root = np.sqrt(0.64 + 0.25 * 0.36)
    assert value[0, 0] == pytest.approx(0.8 / (np.pi * 0.1) / (2 * 2 * 0.8 * root))
    assert fresnel_edge(np.array([1.0, 0.0])).tolist() == [0, 1]


def test_a_normal_that_is_turned_away_is_bent_to_the_viewer():
    away = np.array([[np.sin(2.0), 0.0, np.cos(2.0)]])
    wi, wo = np.array([[-0.6, 0.0, 0.8]]), np.array([[0.0, 0.6, 0.8]])
    under = lit(away, ALONG, wi, wo)
    assert BENT * 0.999 < under.n_i[0, 0] < 0.01
    for squares in (under.view, under.light, under.half):
        assert sum(part[0, 0] for part in squares) == pytest.approx(1)


def test_pairs_are_unit_above_the_cloth_and_of_all_kinds():
    wi, wo = pairs(256)
    for direction in (wi, wo):
        np.testing.assert_allclose(np.linalg.norm(direction, axis=-1), 1)
        assert direction[:, 2].min() > 0.9 * LOWEST
    near = np.sum(halfway(wi, wo) * (0, 0, 1), -1) > 0.9
    across = np.abs(wi[:, 0] * wo[:, 1] - wi[:, 1] * wo[:, 0]) < 1e-9
    assert near.sum() > 40
    assert across.sum() >= 64
