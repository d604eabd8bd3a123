"""The drafts in examples come from their notation, byte for byte."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from weaveusd.draft.make import make_draft
from weaveusd.draft.wif import read_wif
from weaveusd.draft.write import write_wif

FOLDER = Path(__file__).parents[2] / "examples" / "drafts"
DRAFTS = runpy.run_path(str(FOLDER / "regenerate.py"))["DRAFTS"]


@pytest.mark.parametrize("name", DRAFTS)
def test_an_example_is_what_its_notation_makes(name: str) -> None:
    made = make_draft(DRAFTS[name])
    assert (FOLDER / name).read_bytes() == write_wif(made)
    assert read_wif(FOLDER / name) == made
    assert read_wif(FOLDER / name).warnings == ()


def test_no_example_is_without_a_notation() -> None:
    assert {path.name for path in FOLDER.glob("*.wif")} == set(DRAFTS)
