"""Hostile names become safe ones, and safe ones stay."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Sdf, Tf

from weaveusd.contract import YARN_ATTRIBUTES
from weaveusd.export.names import MAX_NAME, instance_names, safe_name

HOSTILE = [
    "", " ", "../../etc/passwd", "a/b\\c", "@x@", '"""', "line\nfeed", "CON", "con", "Com1", "LPT9",
    "nul.usda", "\u202egnp.exe", "x" * 300, "½ twill", "織物", "ä" * 200, "-rf", "8 shafts", "a\0b",
    "look", "LOOK", "$HOME", "~root", "%PATH%", "<script>", "com¹", "aux", ".hidden", "_", "__x__",
]  # fmt: skip


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_titles_become_names_that_are_safe_everywhere(text):
    check(safe_name(text))


@given(st.text())
def test_any_text_becomes_a_safe_name_which_stays(text):
    check(safe_name(text))


def check(name: str) -> None:
    assert re.fullmatch(rf"[A-Za-z][A-Za-z0-9_]{{0,{MAX_NAME - 1}}}", name)
    assert Sdf.Path.IsValidIdentifier(name)
    assert Tf.MakeValidIdentifier(name) == name
    assert not re.fullmatch(r"con|prn|aux|nul|clock|com\d|lpt\d|look", name.lower())
    assert safe_name(name) == name


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("Crêpe de Chine", "Crepe_de_Chine"),
        ("2/2 twill", "cloth_2_2_twill"),
        ("plain", "plain"),
        ("con", "cloth_con"),
        ("...", "cloth"),
    ],
)
def test_names_stay_readable(text, name):
    assert safe_name(text) == name


@given(st.lists(st.one_of(st.text(max_size=70), st.just("a"), st.just("tex")), max_size=30))
def test_yarns_get_distinct_instance_names_that_usd_accepts(names):
    instances = instance_names(names)
    assert len(instances) == len(names) == len(set(instances))
    properties = {attribute.name for attribute in YARN_ATTRIBUTES}
    for name in instances:
        assert Sdf.Path.IsValidIdentifier(name)
        assert len(name) <= MAX_NAME
        assert name not in properties


def test_ordinary_yarn_names_are_kept():
    assert instance_names(["warp", "weft", "warp"]) == ("warp", "weft", "warp_2")
