"""An asset's README.md says what the cloth is, and no text of others breaks it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.export.cloths import FITS, cloth
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


def dyed(color, **fits):
    """The cloth in another color, all of which its fibres reach."""
    material = cloth()
    yarns = tuple(replace(y, color=color) for y in material.weave.yarns)
    return replace(
        material,
        weave=replace(material.weave, yarns=yarns),
        measured=tuple(m._replace(reached=color) for m in material.measured),
        fits=replace(material.fits, **fits),
    )


def test_every_colorway_is_listed_with_its_colors_its_losses_and_its_picture():
    errors = replace(FITS.errors, openpbr=0.4321)
    together = replace(FITS.together, base=0.6)
    looks = {
        "natural": cloth(),
        "blue": dyed((0.0, 0.0, 1.0), errors=errors, together=together),
        "late": cloth(),
    }
    pictures = {"natural": ("draped.png", "swatch.png"), "blue": ("draped.blue.png",)}
    text = readme_text(looks["natural"], 1.0, looks, pictures)
    assert "`natural`, `blue`, `late`; `natural` is the default" in text
    assert "![The cloth, draped](previews/draped.png)" in text
    (found,) = (table for table in tables(text) if table[0][0] == "colorway")
    head, _, natural, blue, late = found
    assert head[3:] == ["openpbr", "standard_surface", "preview"]
    assert natural[0] == "[`natural`](previews/draped.png)"
    assert natural[2].startswith("warp `#958963` → `#")
    assert blue[0] == "[`blue`](previews/draped.blue.png)"
    assert blue[2:4] == ["warp `#0000ff`, weft `#0000ff`", "43.2% off"]
    assert late[0] == "`late`"
    assert late[1:] == natural[1:]
    assert "Pictures are made of the first 2 colorways only." in text
    assert "- `blue`, standard_surface: color of every yarn: nearly, 60% of it in" in text
    assert "- `late`" not in text


def test_a_colorway_of_many_yarns_lists_the_first_and_counts_the_rest():
    material = cloth()
    many = 20
    weave = replace(material.weave, yarns=material.weave.yarns[:1] * many)
    crowd = replace(
        material, weave=weave, measured=material.measured[:1] * many,
        normalization=material.normalization[:1] * many,
    )  # fmt: skip
    assert " and 12 more |" in readme_text(crowd, 1.0, {"crowd": crowd})


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
