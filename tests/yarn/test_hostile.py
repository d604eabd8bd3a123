"""Whatever a recipe holds, it is read or refused in one line; nothing else happens."""

from __future__ import annotations

import hypothesis.strategies as st
import pytest
from hypothesis import example, given, settings

from weaveusd.errors import RecipeError
from weaveusd.yarn.recipe import PRESETS, read_recipe

LINES = (PRESETS / "houndstooth.toml").read_text(encoding="utf-8").splitlines()
VALUES = st.sampled_from(
    [
        "1", "-1", "0", "1e400", "nan", "-inf", "9" * 400, "true", '""', '"x"', '"\\u0000"', "[]",
        "[[]]", "[{}]", "{}", "{ a = {} }", "[1, 'a']", "1979-05-27", "'''\n\n'''", '"#zzzzzz"',
        '{ lab = [] }', '{ lab = [50, 0, 0], illuminant = "D50" }', '{ reflectance = "../a.csv" }',
        '{ reflectance = "/dev/zero" }', '"2/60 Nm"', '"0/0 Ne"', "0x7fffffffffffffffffff",
    ]
)  # fmt: skip
KEYS = st.sampled_from(
    ["tex", "Ne", "count", "plies", "color", "crimp", "width_mm", "palette", "systems", "weave",
     "irregularity", "optics", "melange", "'a\\nb'", '"a\\nb"', "''", "[sett]", "[[yarn]]", "[[["]
)  # fmt: skip
EDITS = st.lists(
    st.one_of(
        st.tuples(st.just("cut"), st.integers(0, len(LINES) - 1), st.just(""), st.just("")),
        st.tuples(st.just("set"), st.integers(0, len(LINES) - 1), st.just(""), VALUES),
        st.tuples(st.just("add"), st.integers(0, len(LINES) - 1), KEYS, VALUES),
    ),
    min_size=1,
    max_size=4,
)


def edited(edits) -> str:
    lines = list(LINES)
    for kind, at, key, value in edits:
        if kind == "cut":
            lines[at] = ""
        elif kind == "set" and "=" in lines[at]:
            lines[at] = lines[at].partition("=")[0] + "= " + value
        elif kind == "add":
            lines[at] += f"\n{key} = {value}" if not key.startswith("[") else f"\n{key}"
    return "\n".join(lines)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("recipes") / "recipe.toml"


def read_or_refuse(path) -> None:
    try:
        read_recipe(path)
    except RecipeError as error:
        message = str(error)
        assert message.startswith(str(path))
        assert message.isprintable()
        assert len(message) < 1000


@settings(max_examples=300, deadline=None)
@given(EDITS)
def test_a_broken_recipe_is_refused_in_one_line(path, edits):
    path.write_text(edited(edits), encoding="utf-8")
    read_or_refuse(path)


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=300))
@example(b"a = " + b"[" * 100_000)
@example(b"a = " + b"{a=" * 100_000)
@example(b"a." * 100_000 + b"a = 1")
@example(b"[" + b"a." * 100_000 + b"a]")
@example((b"a." * 99 + b"a = 1\n") * 1000)
@example(b"a = " + b"9" * 5000)
@example(b"a = 0x" + b"f" * 50_000)
@example(b'"' + b"a" * 50_000 + b'" = 1')
@example(b"name = 0x" + b"f" * 50_000)
@example(b'name = """' + b"a" * 50_000 + b'"""')
def test_noise_is_refused_in_one_line(path, data):
    path.write_bytes(data)
    read_or_refuse(path)


def test_a_key_of_endless_parts_is_refused_before_it_is_parsed(path):
    path.write_text('name = "x"\n' + "a." * 50_000 + "a = 1")
    with pytest.raises(RecipeError, match=r"recipe\.toml:2: found 50000 dots in a line"):
        read_recipe(path)
