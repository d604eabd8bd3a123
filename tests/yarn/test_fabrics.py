"""Presets, examples and pages say what comes out."""

from __future__ import annotations

import re
import runpy
from dataclasses import replace
from pathlib import Path

import pytest

from weaveusd.cloth import measures
from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import preset_names, read_preset, read_recipe
from weaveusd.yarn.textile import diameter_mm

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples" / "recipes").glob("*.toml"))
FABRICS = [name for name in preset_names() if read_preset(name).kind == "fabric"]
# g/m², tables of constructions (docs/fabrics.md says what they are worth).
PUBLISHED = {
    "denim": 394, "drill": 220, "poplin": 128, "oxford": 122, "canvas": 376, "linen_plain": 254,
    "herringbone": 178, "houndstooth": 178, "gabardine": 246, "charmeuse": 88,
    "crepe_de_chine": 70, "chiffon": 33,
}  # fmt: skip


def made(name: str):
    recipe = read_preset(name)
    return recipe, weave(make_draft(recipe.weave), recipe)


def test_the_presets_that_were_promised_are_there():
    assert {"cotton", "linen", "wool", "silk", "polyester"} == set(preset_names()) - set(FABRICS)
    assert {*PUBLISHED, "shot_silk", "satin_lining"} == set(FABRICS)


@pytest.mark.parametrize("name", FABRICS)
def test_a_fabric_names_its_weave_finish_colors_and_certainty(name):
    recipe, cloth = made(name)
    assert recipe.finish
    assert recipe.certainty
    assert all(yarn.color is not None and yarn.count for yarn in recipe.yarns)
    assert cloth.warnings == ()


@pytest.mark.parametrize("name", FABRICS)
def test_a_fabric_suits_any_draft(name):
    recipe = read_preset(name)
    for notation in ("tartan:K4 R24 G12", "satin:8:3", "plain"):
        cloth = weave(make_draft(notation), recipe)
        assert 0 < measures.areal_density_g_m2(cloth) < 500


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_fabric_weighs_what_is_published(name):
    recipe, cloth = made(name)
    assert recipe.weight_g_m2 == PUBLISHED[name]
    assert measures.areal_density_g_m2(cloth) == pytest.approx(PUBLISHED[name], rel=0.15)


@pytest.mark.parametrize("name", FABRICS)
def test_crimp_is_within_what_woven_cloth_shows(name):
    _, cloth = made(name)
    assert all(0.01 < crimp < 0.15 for crimp in measures.crimps(cloth))


@pytest.mark.parametrize("name", FABRICS)
def test_a_section_is_that_of_its_count(name):
    _, cloth = made(name)
    for yarn in cloth.yarns:
        diameter = diameter_mm(yarn.tex, yarn.fibre, yarn.packing)
        assert yarn.width_mm * yarn.height_mm == pytest.approx(diameter**2)


def test_gabardine_is_denser_than_its_yarn_is_wide():
    _, cloth = made("gabardine")
    yarn = cloth.yarns[0]
    pitch = cloth.repeat_mm[0] / cloth.ends
    assert diameter_mm(yarn.tex, yarn.fibre, yarn.packing) > pitch
    assert yarn.width_mm == pytest.approx(pitch)
    assert yarn.height_mm > yarn.width_mm


@pytest.mark.parametrize(("name", "warp"), [("shot_silk", 0.86), ("satin_lining", 0.9)])
def test_warp_and_weft_show_in_the_published_shares(name, warp):
    """Sadeghi et al. 2013, as public ports give the table: shares of the yarn that is seen."""
    _, cloth = made(name)
    seen = synthesize(cloth, resolution=400).whole()["yarn_id"]
    assert (seen == 0).sum() / (seen >= 0).sum() == pytest.approx(warp, abs=0.02)


def test_shot_silk_is_of_two_colors_and_houndstooth_of_two_both_ways():
    _, shot = made("shot_silk")
    assert len({yarn.color for yarn in shot.yarns}) == 2
    _, check = made("houndstooth")
    assert [len(set(threads)) for threads in (check.warp_yarn, check.weft_yarn)] == [2, 2]
    dark, light = check.yarns[0].color, check.yarns[1].color
    assert max(dark) < 0.1 < min(light)


def test_the_table_of_fabrics_is_what_the_presets_give():
    page = runpy.run_path(str(ROOT / "scripts" / "fabric_table.py"))
    assert page["page"]() == (ROOT / "docs" / "fabrics.md").read_text(encoding="utf-8")


def test_the_recipe_in_the_manual_is_one(tmp_path):
    text = (ROOT / "docs" / "recipes.md").read_text(encoding="utf-8")
    block = re.search(r"```toml\n(.*?)```", text, re.S)
    path = tmp_path / "recipe.toml"
    path.write_text(block[1], encoding="utf-8")
    recipe = read_recipe(path)
    cloth = weave(make_draft(recipe.weave), recipe)
    assert (recipe.name, cloth.warnings) == ("my_linen", ())


def test_the_manual_knows_every_key(tmp_path):
    """A recipe with an unknown key is answered with all that are known there."""
    text = (ROOT / "docs" / "recipes.md").read_text(encoding="utf-8")
    block = re.search(r"```toml\n(.*?)```", text, re.S)[1]
    for table in (
        r"\A",
        r"\[weave\]\n",
        r"\[sett\]\n",
        r"\[\[yarn\]\].*\n",
        r"\[yarn\.optics\].*\n",
    ):
        path = tmp_path / "recipe.toml"
        path.write_text(re.sub(f"({table})", r"\1shine = 1\n", block), encoding="utf-8")
        with pytest.raises(Exception, match="unknown key; known here: ") as caught:
            read_recipe(path)
        for key in str(caught.value).partition("known here: ")[2].split(", "):
            assert re.search(rf"\b{key}\b", text), key


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_an_example_recipe_makes_the_cloth_that_it_states(path):
    recipe = read_recipe(path)
    cloth = weave(make_draft(recipe.weave or "plain"), recipe)
    assert recipe.name == path.stem
    assert cloth.warnings == ()


def test_a_finer_count_makes_a_lighter_cloth():
    recipe = read_preset("poplin")
    finer = replace(recipe, yarns=tuple(replace(y, tex=y.tex / 2) for y in recipe.yarns))
    draft = make_draft("plain")
    assert measures.areal_density_g_m2(weave(draft, finer)) < (
        0.55 * measures.areal_density_g_m2(weave(draft, recipe))
    )
