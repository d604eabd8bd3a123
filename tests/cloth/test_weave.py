"""A weave lies where its sett and its yarns put it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.weaves import draft_of, plain, satin, twill, woven
from weaveusd.cloth.layout import MAX_INCLINATION, System, edges, lay_floats
from weaveusd.cloth.measures import areal_density_g_m2, crimps, thickness_mm, warp_cover, weft_cover
from weaveusd.cloth.weave import lie, weave
from weaveusd.errors import RecipeError
from weaveusd.yarn.recipe import preset_names, read_preset


def test_the_repeat_is_threads_over_sett():
    cloth = woven(twill())
    assert cloth.repeat_mm == pytest.approx((4 * 10 / 18.9, 4 * 10 / 17.3))


def test_exchanging_warp_and_weft_transposes_the_cloth():
    recipe = replace(read_preset("linen"), picks_per_cm=18.9)
    warp_up = np.array([[1, 0, 0], [1, 1, 0]], bool)
    one = weave(draft_of(warp_up), recipe)
    other = weave(draft_of(~warp_up.T), recipe)
    for mine, theirs in (
        (one.warp_floats, other.weft_floats),
        (one.weft_floats, other.warp_floats),
    ):
        for field in ("thread", "start", "count", "length_mm", "center_mm", "bend_mm", "u_max"):
            np.testing.assert_allclose(getattr(mine, field), getattr(theirs, field))
        np.testing.assert_array_equal(mine.at.T, theirs.at)


def test_a_float_reaches_the_threads_that_cover_its_ends():
    cloth = woven(plain())
    pitch, width = 10 / 17.3, cloth.weft_width_mm[0]
    np.testing.assert_allclose(cloth.warp_floats.length_mm, pitch + (pitch - width))


@pytest.mark.parametrize("preset", preset_names())
@pytest.mark.parametrize("warp_up", [plain(), twill(), satin()], ids=["plain", "twill", "satin"])
def test_no_corner_of_a_float_is_steeper_than_the_limit(preset, warp_up):
    cloth = woven(warp_up, preset)
    for floats, height in (
        (cloth.warp_floats, cloth.warp_height_mm),
        (cloth.weft_floats, cloth.weft_height_mm),
    ):
        b, e = 0.5 * height[floats.thread], floats.bend_mm
        sin_corner = e / (e / np.sin(floats.u_max) - b)
        assert (sin_corner <= np.sin(MAX_INCLINATION) * (1 + 1e-12)).all()


def test_a_jammed_square_cloth_bends_by_sixty_degrees():
    """Peirce: round threads of diameter D/2, p/D = √3/2, crimp 20.9 %."""
    thread = 1e-6 * np.ones(2)  # no thickness of its own against the corner limit
    pitch = np.sqrt(3) / 2 * 1.0
    own = System(edges(np.full(2, pitch)), thread, 0.5 * np.ones(2), np.zeros(2, bool))
    crossing = replace(own, width_mm=np.full(2, pitch))
    floats = lay_floats(np.eye(2, dtype=bool), own, crossing, 0.5)
    h = 0.5 * (0.5 + 0.5)
    assert 2 * np.arctan(h / pitch) == pytest.approx(np.pi / 3)
    assert (floats.u_max <= np.pi / 3 + 1e-12).all()
    u = np.pi / 3
    assert u / np.sin(u) - 1 == pytest.approx(0.209, abs=5e-4)


def test_a_thread_that_never_interlaces_does_not_bend():
    warp_up = np.array([[1, 0], [1, 1]], bool)
    cloth = woven(warp_up)
    closed = cloth.warp_floats.count == 2
    assert closed.any()
    assert (cloth.warp_floats.u_max[closed] == 0).all()


def test_a_yarn_keeps_its_section_when_it_is_squeezed():
    spec = read_preset("wool").yarns[0]
    free_width, free_height = lie(spec, 10.0)
    width, height = lie(spec, 0.1)
    assert width == 0.1
    assert width * height == pytest.approx(free_width * free_height)


def test_single_threads_keep_their_proportions():
    draft = replace(draft_of(plain()), warp_pitch_mm=np.array([1.0, 3.0]))
    cloth = weave(draft, read_preset("linen"))
    pitch = np.diff(cloth.warp_edge_mm)
    assert pitch[1] / pitch[0] == pytest.approx(3)
    assert pitch.mean() == pytest.approx(10 / 18.9)


def test_a_color_without_yarn_is_an_error():
    recipe = read_preset("linen")
    only_second = replace(recipe.yarns[0], palette=(2,))
    with pytest.raises(RecipeError, match="no yarn for warp threads of color 1"):
        weave(draft_of(plain()), replace(recipe, yarns=(only_second,)))


def test_what_a_mill_asks_has_an_answer():
    cloth = woven(plain(), "cotton")
    assert warp_cover(cloth) == pytest.approx(0.199 * 2.68, abs=0.01)
    assert weft_cover(cloth) == pytest.approx(warp_cover(cloth))
    assert all(0 < c < 0.2 for c in crimps(cloth))
    assert areal_density_g_m2(cloth) == pytest.approx(105, rel=0.15)  # published, sheeting
    assert thickness_mm(cloth) == pytest.approx(2 * 0.1305, rel=0.05)


def test_what_a_weave_holds_is_read_only():
    cloth = woven(plain())
    with pytest.raises(ValueError, match="read-only"):
        cloth.warp_up[0, 0] = True
