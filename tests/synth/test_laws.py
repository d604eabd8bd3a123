"""Laws that the textures of every draft keep: those of the corpus and our examples."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from weaveusd.cloth.model import Weave
from weaveusd.cloth.weave import weave
from weaveusd.contract import CHANNELS, VECTOR_PNG_LEVELS
from weaveusd.draft.model import Draft
from weaveusd.draft.transform import repeat, rotate
from weaveusd.draft.wif import read_wif
from weaveusd.export.encode import encode
from weaveusd.synth.textures import synthesize, texture_size
from weaveusd.yarn.irregularity import REGULAR
from weaveusd.yarn.recipe import read_preset

ROOT = Path(__file__).parents[2]
CORPUS = ROOT.parent / "shared" / "corpus"
FAST = {"twill_2_2.wif", "base_loom_server__many_color_liftplan_and_zeros.wif"}


def valid_drafts() -> list[Path]:
    """The drafts of the examples, and the valid ones of the corpus where it is at hand."""
    paths = sorted((ROOT / "examples" / "drafts").glob("*.wif"))
    if (table := CORPUS / "drawdowns.tsv").is_file():
        rows = [line.split("\t") for line in table.read_text("utf-8").splitlines()]
        paths += [CORPUS / row[0] for row in rows if row[1] == "valid"]
    return paths


every_draft = pytest.mark.parametrize(
    "path",
    [
        pytest.param(p, id=p.stem, marks=() if p.name in FAST else pytest.mark.slow)
        for p in valid_drafts()
    ],
)


def cloth_of(draft: Draft, *, even: bool = True) -> Weave:
    """The draft in linen of equal setts; `even` yarns are the same everywhere."""
    cloth = weave(draft, replace(read_preset("linen"), ends_per_cm=18, picks_per_cm=18))
    if not even:
        return cloth
    yarns = tuple(replace(y, twist_deviation=0.0, irregularity=REGULAR) for y in cloth.yarns)
    return replace(cloth, yarns=yarns)


def agreement(one: np.ndarray, other: np.ndarray, tolerance: float = 1e-5) -> float:
    """The share of texels (H, W, components) that are the same."""
    return float(np.mean((np.abs(one - other) <= tolerance).all(-1)))


def lines_of(edge_mm: np.ndarray, texels: int) -> tuple[np.ndarray, np.ndarray]:
    """The thread that each texel of an axis is in, and whether it is on the border of two."""
    place = (np.arange(texels) + 0.5) / texels * edge_mm[-1]
    thread = np.searchsorted(edge_mm, place, side="right") - 1
    away = np.minimum(place - edge_mm[thread], edge_mm[thread + 1] - place)
    return thread, away < 1e-9 * edge_mm[-1]


@pytest.mark.skipif(not CORPUS.is_dir(), reason="../shared/corpus is not here")
def test_the_corpus_is_among_the_drafts():
    assert len(valid_drafts()) > 30


@every_draft
def test_the_repeat_meets_itself_as_two_repeats_meet(path):
    """The texture of four repeats is four textures: a border is like any place inside."""
    draft = read_wif(path)
    once, four = cloth_of(draft), cloth_of(repeat(draft, 2, 2))
    size = next(
        n
        for n in range(160, 320)
        if texture_size(four, 2 * n) == tuple(2 * k for k in texture_size(once, n))
    )
    out = synthesize(once, resolution=size).whole()
    tiled = synthesize(four, resolution=2 * size).whole()
    for name in ("normal", "tangent", "height", "opacity", "yarn_id", "base_color"):
        # Where a texel lies on the border of two threads, the last bit decides.
        assert agreement(np.tile(out[name], (2, 2, 1)), tiled[name]) > 0.995, name


@every_draft
def test_frames_are_orthonormal_as_stored(path):
    out = synthesize(cloth_of(read_wif(path), even=False), resolution=160).whole()
    for suffix, step in ((".exr", 2.0**-11), (".png", 2.0 / VECTOR_PNG_LEVELS)):
        n, t = (
            encode(CHANNELS[name], suffix, out[name]).astype(float)
            for name in ("normal", "tangent")
        )
        if suffix == ".png":
            n, t = (2 * (q / VECTOR_PNG_LEVELS - 0.5) for q in (n, t))
        # Each component is off by half a step, along n, t and both.
        assert np.abs(np.linalg.norm(n, axis=-1) - 1).max() < step
        assert np.abs(np.linalg.norm(t, axis=-1) - 1).max() < step
        assert np.abs((n * t).sum(-1)).max() < 2 * step


@every_draft
def test_normals_are_the_gradient_of_the_height(path):
    draft = read_wif(path)
    threads = max(draft.ends, draft.picks)
    if threads > 100:
        pytest.skip("its threads would be finer than central differences")
    cloth = cloth_of(draft)
    textures = synthesize(cloth, resolution=24 * threads if threads > 8 else 300)
    dx = textures.repeat_mm[0] / textures.width
    for first in np.linspace(0, textures.height - 3, 9).astype(int):
        out = textures.band(int(first), int(first) + 3)
        z, n = out["height"][..., 0].astype(float), out["normal"][1].astype(float)
        low, here, high = z
        before, after = np.roll(here, 1), np.roll(here, -1)
        near = 0.02 * min(cloth.warp_height_mm.min(), cloth.weft_height_mm.min())
        inside = np.ones(len(here), bool)
        for side in (before, after, low, high):
            inside &= np.abs(side - here) < near
        for ids in (out["yarn_id"][0], out["yarn_id"][2]):
            inside &= ids[:, 0] == out["yarn_id"][1][:, 0]
        g = np.stack([(before - after), (low - high), np.full_like(here, 2 * dx)], -1)
        g /= np.linalg.norm(g, axis=-1, keepdims=True)
        angle = np.degrees(np.arccos(np.clip((g * n).sum(-1), -1, 1)))[inside]
        if angle.size:
            assert np.median(angle) < 0.5


@every_draft
def test_a_cloth_turned_a_quarter_has_its_texture_turned(path):
    draft = read_wif(path)
    one = synthesize(cloth_of(draft), resolution=160).whole()
    other = synthesize(cloth_of(rotate(draft)), resolution=160).whole()
    back = {name: np.rot90(texels, 1) for name, texels in other.items()}
    assert agreement(back["height"], one["height"]) > 0.99
    assert agreement(back["opacity"], one["opacity"]) > 0.99
    for name in ("normal", "tangent"):
        x, y, z = np.moveaxis(back[name], -1, 0)
        unturned, mine = np.stack([y, -x, z], -1), one[name]
        if name == "tangent":  # a fibre has no head
            unturned = unturned * np.where((unturned * mine).sum(-1, keepdims=True) < 0, -1, 1)
        solid = one["opacity"][..., 0] > 0
        assert agreement(unturned[solid], mine[solid], 1e-4) > 0.99, name


@every_draft
def test_a_yarn_is_seen_where_the_drawdown_has_it_on_top(path):
    cloth = cloth_of(read_wif(path))
    cloth = replace(
        cloth, warp_width_mm=np.diff(cloth.warp_edge_mm), weft_width_mm=np.diff(cloth.weft_edge_mm)
    )
    textures = synthesize(cloth, resolution=211)
    seen = textures.whole()["yarn_id"][..., 0].astype(int)
    end, beside_ends = lines_of(cloth.warp_edge_mm, textures.width)
    pick, beside_picks = lines_of(cloth.weft_edge_mm, textures.height)
    top = np.where(
        cloth.warp_up[pick[:, None], end], cloth.warp_yarn[end], cloth.weft_yarn[pick][:, None]
    )
    inside = ~(beside_picks[:, None] | beside_ends)
    np.testing.assert_array_equal(seen[inside], top[inside])
    if max(cloth.ends, cloth.picks) <= 50:
        area = np.diff(cloth.weft_edge_mm)[:, None] * np.diff(cloth.warp_edge_mm)
        on_top = np.where(cloth.warp_up, cloth.warp_yarn, cloth.weft_yarn[:, None])
        for yarn in range(len(cloth.yarns)):
            share = area[on_top == yarn].sum() / area.sum()
            assert np.mean(seen == yarn) == pytest.approx(share, abs=0.02)


@every_draft
def test_jobs_and_bands_change_no_bit(path):
    cloth = cloth_of(read_wif(path), even=False)
    one = synthesize(cloth, resolution=120, seed=4, jobs=1).whole()
    two = synthesize(cloth, resolution=120, seed=4, jobs=2)
    cuts = sorted({0, 1, 9, two.height // 2, two.height})
    bands = [two.band(a, b) for a, b in pairwise(cuts)]
    for name, texels in one.items():
        joined = np.concatenate([band[name] for band in bands])
        np.testing.assert_array_equal(joined, texels, err_msg=name)
