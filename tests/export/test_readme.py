"""An asset's README.md says what the cloth is, and no text of others breaks it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.export.cloths import cloth
from weaveusd.export.readme import escaped, readme_text


def tables(text):
    """Return the cells of every table, a list of rows each."""
    found, rows = [], []
    for line in [*text.splitlines(), ""]:
        if line.startswith("|"):
            rows.append([cell.strip() for cell in line.strip("|").split(" | ")])
        elif rows:
            found.append(rows)
            rows = []
    return found


def test_it_has_size_yarns_networks_and_origin():
    text = readme_text(cloth(), 0.975)
    assert text.startswith("# plain\n")
    assert [line for line in text.splitlines() if line.startswith("## ")] == [
        "## Use", "## Size", "## Yarns", "## Networks", "## Origin",
    ]  # fmt: skip
    assert "references = @./plain.usda@" in text
    assert "| one texture | 0.8 × 1 mm, 32 × 48 texels, 1 × 1 repeats |" in text
    assert "97.5%" in text
    assert "colorway" not in text
    assert "previews" not in text


def test_colorways_and_previews_are_told_where_there_are_some():
    text = readme_text(cloth(), 1.0, ("natural", "blue"), previews=True)
    assert "`natural`, `blue`; `natural` is the default" in text
    assert "(previews/draped.png)" in text


def test_every_table_has_as_many_cells_in_each_row():
    found = tables(readme_text(cloth(), 1.0, also=("exact", "glslfx", "gltf", "u3m")))
    assert len(found) == 5
    for rows in found:
        assert len({len(row) for row in rows}) == 1


@pytest.mark.parametrize(
    "text",
    ["a | b", "# head", "```\nrm", "<script>", "![x](http://y)", "*b*", "\u202e rtl", "a\n\n# b"],
)
def test_hostile_text_stays_text(text):
    material = cloth(title=text)
    source = replace(material.provenance, recipe=text, recipe_source=text)
    plain = readme_text(cloth(), 1.0)
    written = readme_text(replace(material, provenance=source), 1.0)
    assert len(written.splitlines()) == len(plain.splitlines())
    for rows in tables(written):
        assert len({len(row) for row in rows}) == 1
    assert "<script>" not in written
    assert "![x](" not in written


def test_what_markdown_would_take_for_its_own_is_escaped():
    assert escaped("k_d [a](b) | `c` <d> & *e*") == (
        "k\\_d \\[a\\](b) \\| \\`c\\` \\<d\\> \\& \\*e\\*"
    )
