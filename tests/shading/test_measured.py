"""The albedo is chosen so that the woven yarn measures as its color."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.shading import laws
from weaveusd.shading.measured import measured, texel_reflectance, texels_of, white_reflectances
from weaveusd.shading.microcylinder import Parameters, evaluate
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import read_preset


def cloth(preset, resolution=128, **yarn):
    recipe = read_preset(preset)
    made = weave(make_draft(recipe.weave or "plain"), recipe)
    if yarn:
        made = replace(made, yarns=tuple(replace(y, **yarn) for y in made.yarns))
    return made, synthesize(made, resolution=resolution)


def frame(tilt, turn, twist):
    """A yarn whose normal is tilted by `tilt` towards azimuth `turn`."""
    up = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    along = np.cross(up, [np.cos(twist), np.sin(twist), 0.0])
    return up, along / np.linalg.norm(along)


@pytest.mark.parametrize("preset", ["linen", "polyester"])
@pytest.mark.parametrize("tilt", [0.0, 0.5, 1.1])
def test_a_texel_sends_back_what_the_reference_integrates_to(preset, tilt):
    optics = read_preset(preset).yarns[0].optics
    up, along = frame(tilt, 0.7, 0.3)
    params = Parameters(optics.eta, optics.k_d, optics.k_s, optics.gamma_s, optics.gamma_v,
                        optics.tau, np.array([0.0, 1.0]))  # fmt: skip
    basis = np.stack([np.cross(along, up), along, up])
    views = []
    for turn in np.arange(4) * np.pi / 2:
        wi = np.array([np.sin(0.1396263) * np.cos(turn), np.sin(0.1396263) * np.sin(turn),
                       np.cos(0.1396263)])  # fmt: skip
        # A fine grid over both angles around the fibre, cut where the cloth or the yarn is.
        theta = np.arcsin(np.linspace(-1, 1, 802)[1:-1])
        phi = (np.arange(720) + 0.5) / 720 * 2 * np.pi
        wo = laws.direction(theta[:, None], phi) @ basis
        value = evaluate(wi, wo, up, along, params)
        volume = value[..., 1] - value[..., 0]
        lit = (wo[..., 2] > 0) & (wo @ up * np.sign(wi @ up) > 0)
        views.append(np.sum(volume * lit) * (2 / 801) * (2 * np.pi / 720))
    found = texel_reflectance(up[None], along[None], optics)
    assert found == pytest.approx(np.mean(views), rel=3e-3)


@pytest.mark.parametrize("preset", ["linen", "satin_lining", "shot_silk"])
def test_a_few_texels_measure_as_all_of_them(preset):
    made, textures = cloth(preset)
    texels = textures.whole()
    for yarn, white in enumerate(white_reflectances(made, texels_of(made, textures))):
        own = texels["yarn_id"][..., 0] == yarn
        n, t = (texels[name][own].astype(float) for name in ("normal", "tangent"))
        assert white == pytest.approx(texel_reflectance(n, t, made.yarns[yarn].optics), rel=0.01)


def test_the_resolution_of_the_textures_hardly_matters():
    coarse, fine = (
        np.array(white_reflectances(made, texels_of(made, textures)))
        for made, textures in (cloth("denim", resolution) for resolution in (96, 512))
    )
    np.testing.assert_allclose(coarse, fine, rtol=0.02)


def test_a_color_that_can_be_reached_is_reached():
    made, textures = cloth("linen", color=(0.3, 0.2, 0.1))
    texels = texels_of(made, textures)
    whites = white_reflectances(made, texels)
    for yarn, white in zip(measured(made, texels), whites, strict=True):
        assert yarn.reached == (0.3, 0.2, 0.1)
        assert yarn.gain * white == pytest.approx(1, rel=1e-4)


def test_a_color_out_of_reach_keeps_its_hue_and_no_albedo_exceeds_one():
    made, textures = cloth("polyester", color=(0.9, 0.6, 0.3))
    for yarn in measured(made, texels_of(made, textures)):
        assert yarn.gain * 0.9 == pytest.approx(1, rel=1e-4)
        red, green, blue = yarn.reached
        assert red < 0.7
        assert (green / red, blue / red) == pytest.approx((2 / 3, 1 / 3))


def test_the_lightest_part_of_a_mixture_keeps_its_place():
    """With more gain the white fibres would be clipped, and the mixture lose its contrast."""
    made, textures = cloth("linen", color=(0.5, 0.5, 0.5))
    uneven = replace(made.yarns[0].irregularity, melange=(((0.9, 0.9, 0.9), 0.5),
                                                          ((0.1, 0.1, 0.1), 0.5)))  # fmt: skip
    mixed = replace(made, yarns=tuple(replace(y, irregularity=uneven) for y in made.yarns))
    for yarn in measured(mixed, texels_of(mixed, textures)):
        assert yarn.gain == pytest.approx(1 / 0.9, rel=1e-4)


def test_a_yarn_that_no_texel_shows_keeps_its_color():
    made, textures = cloth("linen")
    hidden = replace(made, yarns=(*made.yarns, made.yarns[0]))
    last = measured(hidden, texels_of(hidden, textures))[-1]
    assert last.gain == 1.0
    assert last.reached == made.yarns[0].color


def test_the_same_cloth_has_the_same_gains():
    made, textures = cloth("houndstooth")
    assert measured(made, texels_of(made, textures)) == measured(
        made, texels_of(made, synthesize(made, resolution=128, jobs=1))
    )
