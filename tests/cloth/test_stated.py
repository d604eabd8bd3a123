"""What a recipe states of its yarns is so in the cloth, or is reported."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.weaves import draft_of, plain, satin, twill
from weaveusd import pipeline
from weaveusd.cloth.layout import crimp_inclination
from weaveusd.cloth.measures import areal_density_g_m2, crimps
from weaveusd.cloth.weave import lie, weave
from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif
from weaveusd.yarn.recipe import read_preset

WEAVES = {"plain": plain(), "twill": twill(), "satin": satin()}
LINEN = read_preset("linen")


def stated(warp_up=None, **properties):
    """The linen preset's cloth with properties stated for its one yarn."""
    recipe = replace(LINEN, yarns=(replace(LINEN.yarns[0], **properties),))
    return weave(draft_of(plain() if warp_up is None else warp_up), recipe)


def by_geometry(cloth):
    """The crimps that the cloth's floats have, whatever is stated."""
    return crimps(replace(cloth, yarns=tuple(replace(y, crimp=None) for y in cloth.yarns)))


@pytest.mark.parametrize("spine", ["circle", "end-bend"])
@pytest.mark.parametrize("warp_up", WEAVES.values(), ids=WEAVES)
def test_a_stated_crimp_is_that_of_the_bent_yarn(warp_up, spine):
    cloth = stated(warp_up, crimp=0.02, spine=spine)
    assert by_geometry(cloth) == pytest.approx((0.02, 0.02), rel=1e-9)
    assert crimps(cloth) == (0.02, 0.02)


def test_a_stated_crimp_is_what_the_cloth_is_weighed_with():
    straight, crimped = stated(crimp=0.0), stated(crimp=0.25)
    assert areal_density_g_m2(crimped) == pytest.approx(1.25 * areal_density_g_m2(straight))
    assert (straight.warp_floats.u_max < 1e-6).all()


@given(st.floats(1e-4, 0.3))
def test_inclination_and_crimp_are_each_others_inverse(crimp):
    u = crimp_inclination(np.array([crimp, np.nan]), np.array([0.5, 0.5]), 1.0)
    assert u[0] / math.sin(u[0]) - 1 == pytest.approx(crimp, rel=1e-9)
    assert np.isnan(u[1])


def test_a_jammed_square_cloth_of_the_textbook_bends_by_sixty_degrees():
    u = crimp_inclination(np.array([0.2092]), np.array([0.5]), 1.0)
    assert math.degrees(u[0]) == pytest.approx(60, abs=0.01)


def test_a_stated_inclination_is_every_floats_and_comes_before_a_crimp():
    cloth = stated(twill(2, 1), u_max=math.radians(20), crimp=0.3)
    for floats in (cloth.warp_floats, cloth.weft_floats):
        np.testing.assert_allclose(floats.u_max, math.radians(20))
    assert crimps(cloth) == (0.3, 0.3)
    assert cloth.warnings == ()


def test_a_thread_that_never_interlaces_stays_straight_whatever_is_stated():
    cloth = stated(np.array([[1, 0], [1, 1]], bool), u_max=0.3, crimp=0.05)
    closed = cloth.warp_floats.count == 2
    assert (cloth.warp_floats.u_max[closed] == 0).all()
    assert np.isfinite(cloth.warp_floats.u_max).all()


def test_one_yarn_may_be_stated_and_the_other_follow():
    yarn = LINEN.yarns[0]
    warp = replace(yarn, systems=("warp",), crimp=0.01)
    weft = replace(yarn, systems=("weft",))
    cloth = weave(draft_of(plain()), replace(LINEN, yarns=(warp, weft)))
    plainly = weave(draft_of(plain()), LINEN)
    np.testing.assert_array_equal(cloth.weft_floats.u_max, plainly.weft_floats.u_max)
    assert (cloth.warp_floats.u_max < plainly.warp_floats.u_max).all()


def test_an_inclination_that_cannot_be_reached_is_limited_and_reported():
    cloth = stated(u_max=math.radians(85))
    assert (cloth.warp_floats.u_max < math.radians(84)).all()
    assert len(cloth.warnings) == 2
    assert "recipe linen: yarn linen: stated u_max 85°" in cloth.warnings[0]
    assert "warp" in cloth.warnings[0]


def test_width_and_height_are_those_that_are_stated():
    cloth = stated(width_mm=0.3, height_mm=0.25, flatness=None)
    assert {(y.width_mm, y.height_mm) for y in cloth.yarns} == {(0.3, 0.25)}
    assert cloth.warnings == ()


@given(st.floats(0.05, 0.4))
def test_one_stated_side_of_a_section_keeps_its_area(side):
    spec = replace(LINEN.yarns[0], flatness=None)
    free = lie(spec, 10.0)
    for one in (replace(spec, width_mm=side), replace(spec, height_mm=side)):
        width, height = lie(one, 10.0)
        assert width * height == pytest.approx(free[0] * free[1])


def test_a_yarn_of_stated_thickness_keeps_it_when_it_is_squeezed():
    spec = replace(LINEN.yarns[0], flatness=None, height_mm=0.1)
    assert lie(spec, 0.2) == (0.2, 0.1)


def test_a_yarn_stated_wider_than_its_pitch_is_narrowed_and_reported():
    cloth = stated(width_mm=1.0)
    assert cloth.yarns[0].width_mm == pytest.approx(10 / 18.9)
    assert "stated 1 mm wide, but warp threads lie 0.529 mm apart" in cloth.warnings[0]


def test_a_stated_angle_is_the_fibres():
    assert stated(twist_angle=-0.1).yarns[0].twist_angle == -0.1


def test_a_weight_that_the_yarns_do_not_give_is_reported():
    draft = draft_of(plain())
    computed = areal_density_g_m2(weave(draft, LINEN))
    assert weave(draft, replace(LINEN, weight_g_m2=1.1 * computed)).warnings == ()
    (warning,) = weave(draft, replace(LINEN, weight_g_m2=2 * computed)).warnings
    assert "crimp give 261" in warning


def test_what_is_not_kept_reaches_the_findings_of_a_publication(tmp_path):
    preset = pipeline.Path(pipeline.__file__).parent / "yarn" / "presets" / "linen.toml"
    vivid = 'spine = "circle"\ncolor = { lab = [60, 90, -80], illuminant = "D65" }'
    text = preset.read_text(encoding="utf-8").replace('spine = "circle"', vivid)
    recipe = tmp_path / "recipe.toml"
    recipe.write_text(text, encoding="utf-8")
    draft = tmp_path / "plain.wif"
    draft.write_bytes(write_wif(make_draft("plain")))
    done = pipeline.publish(draft, root=tmp_path / "root", recipe=recipe, resolution=32)
    (finding,) = [f for f in done.findings if f["check"] == "recipe/kept"]
    assert (finding["status"], finding["code"]) == ("WARN", "recipe-not-kept")
    assert "outside Rec.709" in finding["message"]
    assert f"{recipe}:24: yarn[0].color" in finding["message"]
