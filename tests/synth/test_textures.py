"""Textures keep the laws of the geometry they show."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.weaves import draft_of, plain, satin, twill, woven
from weaveusd.cloth.weave import weave
from weaveusd.contract import GAP
from weaveusd.synth.textures import synthesize, texture_size
from weaveusd.synth.tones import lightness
from weaveusd.yarn.irregularity import REGULAR, Irregularity
from weaveusd.yarn.recipe import preset_names, read_preset

CORPUS = Path(__file__).parents[3] / "shared" / "corpus"
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
WEAVES = {"plain": plain(), "twill": twill(), "satin": satin(), "2/1": twill(2, 1)}
cloths = pytest.mark.parametrize(
    ("warp_up", "preset"),
    [(w, p) for w in WEAVES.values() for p in preset_names()],
    ids=[f"{w}-{p}" for w in WEAVES for p in preset_names()],
)


EVEN = {"twist_deviation": 0, "irregularity": REGULAR}


def regular(cloth, **changes):
    """The cloth with yarns that are the same everywhere, but for `changes`."""
    irregularity = Irregularity(**changes)
    yarns = tuple(replace(y, irregularity=irregularity) for y in cloth.yarns)
    return replace(cloth, yarns=yarns)


def gradients(cloth, textures, height):
    """The normals (H, W, 3) that central differences of the height give, periodic."""
    dx, dy = textures.repeat_mm[0] / textures.width, textures.repeat_mm[1] / textures.height
    g_x = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / (2 * dx)
    g_y = (np.roll(height, -1, 0) - np.roll(height, 1, 0)) / (2 * dy)
    n = np.stack([-g_x, -g_y, np.ones_like(g_x)], -1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


@cloths
def test_frames_are_orthonormal_in_every_texel(warp_up, preset):
    out = synthesize(woven(warp_up, preset), resolution=200).whole()
    n, t = out["normal"].astype(float), out["tangent"].astype(float)
    np.testing.assert_allclose(np.linalg.norm(n, axis=-1), 1, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(t, axis=-1), 1, atol=1e-6)
    np.testing.assert_allclose(np.sum(n * t, -1), 0, atol=1e-6)
    assert n[..., 2].min() > 0


@cloths
def test_normals_are_the_gradient_of_the_height(warp_up, preset):
    cloth = woven(warp_up, preset)
    textures = synthesize(cloth, resolution=600)
    out = textures.whole()
    by_height = gradients(cloth, textures, out["height"][..., 0].astype(float))
    angle = np.degrees(np.arccos(np.clip(np.sum(by_height * out["normal"], -1), -1, 1)))
    # Central differences are wrong where a yarn ends; inside, they converge.
    yarn = out["yarn_id"][..., 0]
    inside = np.ones(yarn.shape, bool)
    for axis in (0, 1):
        for step in (-1, 1):
            inside &= np.abs(np.roll(out["height"][..., 0], step, axis) - out["height"][..., 0]) < (
                0.02 * 2 * cloth.warp_height_mm[0]
            )
            inside &= np.roll(yarn, step, axis) == yarn
            # Plies meet in a crease.
            turn = np.sum(np.roll(out["normal"], step, axis) * out["normal"], -1)
            inside &= turn > np.cos(np.radians(8))
    assert inside.mean() > 0.5
    assert np.percentile(angle[inside], 99) < 1.5
    assert np.median(angle[inside]) < 0.05


@cloths
def test_the_drawdown_can_be_read_back_at_the_crossings(warp_up, preset):
    cloth = woven(warp_up, preset)
    textures = synthesize(cloth, resolution=320)
    yarn = textures.whole()["yarn_id"][..., 0].astype(int)
    x = (np.arange(cloth.ends) + 0.5) / cloth.ends * textures.width
    y = (np.arange(cloth.picks) + 0.5) / cloth.picks * textures.height
    seen = yarn[y.astype(int)[:, None], x.astype(int)]
    is_warp = np.array([y.system == "warp" for y in cloth.yarns])
    np.testing.assert_array_equal(is_warp[seen], warp_up)


def test_opposite_edges_meet_as_neighbours_do():
    """Rolling the drawdown by one pick and one end rolls the texture, edges included."""
    for warp_up in (twill(), satin()):
        n = len(warp_up)
        size = 40 * n
        recipe = replace(read_preset("cotton"))
        still = replace(recipe, yarns=tuple(replace(y, **EVEN) for y in recipe.yarns))
        one = synthesize(weave(draft_of(warp_up), still), resolution=size).whole()
        rolled = np.roll(warp_up, (1, 1), (0, 1))
        other = synthesize(weave(draft_of(rolled), still), resolution=size).whole()
        for name in one:
            np.testing.assert_allclose(
                np.roll(one[name], (40, 40), (0, 1)), other[name], atol=2e-6, err_msg=name
            )


def test_exchanging_warp_and_weft_turns_the_texture():
    """A cloth turned by −90° about z: warp becomes weft, x → y, y → −x."""
    recipe = read_preset("linen")
    square = replace(
        recipe,
        picks_per_cm=recipe.ends_per_cm,
        yarns=tuple(replace(y, **EVEN) for y in recipe.yarns),
    )
    warp_up = np.array([[1, 1, 0], [0, 1, 0], [0, 0, 1]], bool)
    turned = ~np.rot90(warp_up)  # row 0 is the lowest y, so this turns right as seen
    one = synthesize(weave(draft_of(warp_up), square), resolution=120).whole()
    other = synthesize(weave(draft_of(turned), square), resolution=120).whole()
    back = {k: np.rot90(v, -1) for k, v in other.items()}
    np.testing.assert_allclose(back["height"], one["height"], atol=2e-6)
    np.testing.assert_array_equal(back["opacity"], one["opacity"])
    solid = one["opacity"][..., 0] > 0
    for name in ("normal", "tangent"):
        x, y, z = np.moveaxis(back[name], -1, 0)
        unturned = np.stack([-y, x, z], -1)[solid]
        mine = one[name][solid]
        if name == "tangent":  # a fibre has no head: t and −t are one
            unturned *= np.sign(np.sum(unturned * mine, -1, keepdims=True))
        np.testing.assert_allclose(unturned, mine, atol=2e-5, err_msg=name)


def test_a_z_twill_runs_up_to_the_right():
    out = synthesize(woven(twill(), "cotton"), resolution=64).whole()
    warp = out["yarn_id"][..., 0] == 0
    step = 64 // 4
    agree = np.mean(np.roll(warp, (step, step), (0, 1)) == warp)
    against = np.mean(np.roll(warp, (step, -step), (0, 1)) == warp)
    assert agree > 0.95 > against


@cloths
def test_gaps_are_where_no_yarn_is(warp_up, preset):
    cloth = woven(warp_up, preset)
    out = synthesize(cloth, resolution=400).whole()
    np.testing.assert_array_equal(out["opacity"] == 0, out["yarn_id"] == GAP)
    warp = cloth.warp_width_mm.sum() / cloth.repeat_mm[0]
    weft = cloth.weft_width_mm.sum() / cloth.repeat_mm[1]
    assert out["opacity"].mean() == pytest.approx(warp + weft - warp * weft, abs=0.02)
    assert out["height"].max() <= 1e-6


def test_bands_of_any_height_are_the_same_texels():
    textures = synthesize(woven(satin(), "silk"), resolution=96, seed=3)
    whole = textures.whole()
    cuts = [0, 1, 7, 40, textures.height]
    for name, texels in whole.items():
        bands = [textures.band(a, b)[name] for a, b in pairwise(cuts)]
        np.testing.assert_array_equal(np.concatenate(bands), texels)


def test_the_seed_moves_the_twist_of_a_regular_single_yarn_and_nothing_else():
    cloth = regular(woven(twill(), "linen"))
    one, same, other = (synthesize(cloth, resolution=64, seed=s).whole() for s in (1, 1, 2))
    for name in one:
        np.testing.assert_array_equal(one[name], same[name])
        moves = name in ("tangent", "fibre_angle")
        assert np.array_equal(one[name], other[name]) != moves


SLUBBY = {"thickness": 0.15, "thickness_correlation_mm": 0.7, "bend": 0.2}
TINTED = {"color": 3.0, "color_correlation_mm": 0.8}


@pytest.mark.parametrize("changes", [SLUBBY, TINTED, {"hairiness": 0.4}], ids=str)
def test_what_is_irregular_still_tiles(changes):
    """Across the border of the repeat, texels differ as they do between neighbours inside."""
    cloth = regular(woven(np.tile(twill(), (2, 2)), "wool"), **changes)
    out = synthesize(cloth, resolution=480, seed=6).whole()
    for name in ("height", "normal", "tangent", "base_color", "opacity"):
        for axis in (0, 1):
            step = np.abs(np.diff(out[name], axis=axis)).mean((axis ^ 1, 2))
            border = np.abs(np.take(out[name], 0, axis) - np.take(out[name], -1, axis)).mean()
            assert border <= step.max() * 1.4 + 1e-9, (name, axis)


def test_a_slub_keeps_its_normals_true_to_its_height():
    cloth = regular(woven(twill(), "linen"), **SLUBBY)
    textures = synthesize(cloth, resolution=600, seed=2)
    out = textures.whole()
    by_height = gradients(cloth, textures, out["height"][..., 0].astype(float))
    angle = np.degrees(np.arccos(np.clip(np.sum(by_height * out["normal"], -1), -1, 1)))
    assert np.median(angle) < 3


def test_thickness_varies_as_much_as_it_was_told():
    cloth = regular(
        woven(np.tile(plain(), (15, 15)), "cotton"), thickness=0.15, thickness_correlation_mm=0.7
    )
    size = 30 * 15
    height = synthesize(cloth, resolution=size, seed=3).whole()["height"][7::15, 7::15, 0]
    half = 0.5 * cloth.warp_height_mm[0]
    assert height[cloth.warp_up].std() == pytest.approx(0.15 * half, rel=0.2)


@pytest.mark.parametrize("delta_e", [1.0, 3.0, 6.0])
def test_a_patch_keeps_the_color_of_its_yarn(delta_e):
    cloth = regular(
        woven(np.tile(plain(), (30, 30)), "linen"), color=delta_e, color_correlation_mm=0.5
    )
    out = synthesize(cloth, resolution=600, seed=1).whole()
    for k, yarn in enumerate(cloth.yarns):
        found = out["base_color"][out["yarn_id"][..., 0] == k].astype(float)
        y, wanted = found @ LUMINANCE, np.array(yarn.color) @ LUMINANCE
        assert abs(lightness(y.mean()) - lightness(wanted)) < 1
        assert lightness(y).std() == pytest.approx(delta_e, rel=0.25)


@pytest.mark.parametrize("seed", range(4))
def test_a_small_repeat_of_uneven_yarn_keeps_the_yarn_s_means(seed):
    cloth = woven(plain(), "linen")
    uneven = regular(cloth, thickness=0.15, color=2.5)
    even, out = (synthesize(c, resolution=200, seed=seed).whole() for c in (regular(cloth), uneven))
    for k, yarn in enumerate(uneven.yarns):
        found = out["base_color"][out["yarn_id"][..., 0] == k].mean(0, dtype=float)
        assert abs(lightness(found @ LUMINANCE) - lightness(yarn.color @ LUMINANCE)) < 1
    assert out["opacity"].mean() == pytest.approx(even["opacity"].mean(), abs=0.02)


def test_hairs_too_faint_for_eight_bits_are_a_gap():
    out = synthesize(regular(woven(plain(), "cotton"), hairiness=0.2), resolution=300).whole()
    stored = np.rint(out["opacity"] * 255)
    np.testing.assert_array_equal(stored == 0, out["yarn_id"] == GAP)


@pytest.mark.parametrize("brightest", [0.9, 0.97, 1.0])
def test_a_color_at_the_gamut_s_edge_keeps_its_mean(brightest):
    cloth = woven(np.tile(plain(), (20, 20)), "linen")
    red = tuple(replace(y, color=(brightest, 0.4, 0.1)) for y in cloth.yarns)
    uneven = regular(replace(cloth, yarns=red), color=4.0, color_correlation_mm=0.5)
    out = synthesize(uneven, resolution=400, seed=1).whole()["base_color"]
    np.testing.assert_allclose(out.mean((0, 1)), red[0].color, atol=0.005)
    assert out.max() <= 1


def test_a_melange_shares_out_its_colors():
    shares = (((0.6, 0.5, 0.4), 0.7), ((0.05, 0.05, 0.1), 0.3))
    cloth = regular(woven(np.tile(plain(), (10, 10)), "linen"), melange=shares)
    out = synthesize(cloth, resolution=500, seed=1).whole()
    warm = out["base_color"][out["opacity"][..., 0] > 0][:, 0] > 0.3
    assert warm.mean() == pytest.approx(0.7, abs=0.05)


def test_the_plies_of_a_mouline_alternate():
    strands = ((0.6, 0.1, 0.1), (0.1, 0.1, 0.6))
    cloth = regular(woven(np.tile(plain(), (10, 10)), "wool"), strands=strands)
    out = synthesize(cloth, resolution=500, seed=1).whole()
    red = out["base_color"][out["opacity"][..., 0] > 0][:, 0] > 0.3
    assert red.mean() == pytest.approx(0.5, abs=0.1)


def test_plies_lie_lower_where_they_meet():
    cloth = woven(plain(), "wool")
    single = replace(cloth, yarns=tuple(replace(y, plies=1) for y in cloth.yarns))
    plied, smooth = (synthesize(c, resolution=300).whole()["height"] for c in (cloth, single))
    assert (plied <= smooth + 1e-6).all()
    assert (plied < smooth - 0.01).mean() > 0.1


def test_hairs_close_gaps_and_nothing_else():
    cloth = woven(plain(), "cotton")
    bald, hairy = (
        synthesize(regular(cloth, hairiness=h), resolution=300).whole() for h in (0.0, 0.5)
    )
    gap = bald["opacity"][..., 0] == 0
    assert hairy["opacity"][gap].max() > 0.3
    assert hairy["opacity"].max() <= 1
    for name in bald.keys() - {"ambient_occlusion"}:
        np.testing.assert_array_equal(bald[name][~gap], hairy[name][~gap])


@pytest.mark.parametrize("jobs", [1, 2, 7])
def test_the_number_of_jobs_changes_no_bit(jobs):
    cloth = woven(satin(), "wool")
    out = synthesize(cloth, resolution=150, jobs=jobs).whole()
    for name, texels in synthesize(cloth, resolution=150).whole().items():
        np.testing.assert_array_equal(out[name], texels, err_msg=name)


def test_another_process_computes_the_same_bits():
    code = (
        "import hashlib; from tests.weaves import *;"
        "from weaveusd.synth.textures import synthesize;"
        "out = synthesize(woven(satin(), 'wool'), resolution=128).whole();"
        "print(hashlib.sha256(b''.join(out[k].tobytes() for k in sorted(out))).hexdigest())"
    )
    other = subprocess.run(
        [sys.executable, "-c", code],
        cwd=Path(__file__).parents[2], capture_output=True, text=True, check=True,
    ).stdout.strip()  # fmt: skip
    out = synthesize(woven(satin(), "wool"), resolution=128).whole()
    assert other == hashlib.sha256(b"".join(out[k].tobytes() for k in sorted(out))).hexdigest()


@pytest.mark.parametrize("jobs", [0, -2])
def test_fewer_than_one_job_is_refused(jobs):
    with pytest.raises(ValueError, match="jobs"):
        synthesize(woven(plain()), resolution=64, jobs=jobs)


def test_texels_are_nearly_square():
    cloth = woven(twill(), "charmeuse")
    width, height = texture_size(cloth, 1000)
    assert max(width, height) == 1000
    assert width / height == pytest.approx(cloth.repeat_mm[0] / cloth.repeat_mm[1], rel=0.01)


@pytest.mark.parametrize("resolution", [0, -4, 7, 40_000])
def test_a_resolution_out_of_bounds_is_refused(resolution):
    with pytest.raises(ValueError, match="resolution"):
        synthesize(woven(plain()), resolution=resolution)


@pytest.mark.parametrize("resolution", range(30, 46))
def test_there_is_no_gap_between_yarns_that_touch(resolution):
    cloth = regular(woven(plain(), "charmeuse"))
    np.testing.assert_allclose(cloth.warp_width_mm, np.diff(cloth.warp_edge_mm))
    out = synthesize(cloth, resolution=resolution).whole()
    assert out["opacity"].min() == 1
    assert out["normal"][..., 2].min() > 0
