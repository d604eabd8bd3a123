"""Drafts that real programs wrote: each valid one matches its drawdown, each faulty one fails."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from weaveusd.draft.model import drawdown_sha256
from weaveusd.draft.wif import parse_wif, read_wif
from weaveusd.draft.write import write_wif
from weaveusd.errors import DraftError

CORPUS = Path(__file__).parents[3] / "shared" / "corpus"
pytestmark = pytest.mark.skipif(
    not CORPUS.is_dir(), reason="the corpus of real drafts, ../shared/corpus, is not here"
)


def _listed(kind: str) -> list[dict[str, str]]:
    if not CORPUS.is_dir():
        return []
    with (CORPUS / "drawdowns.tsv").open() as file:
        return [row for row in csv.DictReader(file, delimiter="\t") if row["kind"] == kind]


@pytest.mark.parametrize("row", _listed("valid"), ids=lambda row: row["file"])
def test_a_valid_draft_has_its_drawdown_and_comes_back_when_written(row: dict[str, str]) -> None:
    draft = read_wif(CORPUS / row["file"])
    assert (draft.ends, draft.picks) == (int(row["ends"]), int(row["picks"]))
    assert drawdown_sha256(draft) == row["drawdown_sha256"]
    again = parse_wif(write_wif(draft), "again.wif")
    assert again == draft
    np.testing.assert_array_equal(again.threading, draft.threading)


@pytest.mark.parametrize("row", _listed("faulty"), ids=lambda row: row["file"])
def test_a_faulty_draft_is_refused_with_file_section_and_fault(row: dict[str, str]) -> None:
    with pytest.raises(DraftError, match=r"\[[A-Z ]+\] .*; expected ") as caught:
        read_wif(CORPUS / row["file"])
    assert row["file"] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_corpus_has_38_valid_and_19_faulty_drafts() -> None:
    assert (len(_listed("valid")), len(_listed("faulty"))) == (38, 19)
