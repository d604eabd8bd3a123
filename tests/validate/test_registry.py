from __future__ import annotations

import re
from pathlib import Path

import pytest

import weaveusd.validate.checks as package
from weaveusd.validate.manual import manual
from weaveusd.validate.model import Status
from weaveusd.validate.registry import Code, all_checks, check

ROOT = Path(__file__).parents[2]


def test_every_finding_code_is_unique() -> None:
    codes = [code.name for known in all_checks() for code in known.codes]
    assert len(codes) == len(set(codes))


def test_ids_and_codes_are_spelled_alike() -> None:
    for known in all_checks():
        assert re.fullmatch(r"[a-z]+/[a-z-]+", known.id)
        for code in known.codes:
            assert re.fullmatch(r"[a-z]+(-[a-z]+)*", code.name)


def test_every_check_says_what_it_holds_and_why() -> None:
    for known in all_checks():
        assert known.title.endswith(".")
        assert known.why.endswith(".")
        assert all(code.meaning.endswith(".") for code in known.codes)


def test_every_file_of_checks_holds_one_check() -> None:
    folder = Path(package.__file__).parent
    files = {path.stem for path in folder.glob("[!_]*.py")}
    assert {known.rule.__module__.rpartition(".")[2] for known in all_checks()} == files
    assert len(all_checks()) == len(files)


def test_an_id_or_a_code_that_is_taken_is_refused() -> None:
    taken = all_checks()[0]
    register = check(id="new/check", why="", codes=(taken.codes[0],))
    with pytest.raises(ValueError, match="is taken"):
        register(taken.rule)
    register = check(id=taken.id, why="", codes=(Code("brand-new", Status.FAIL, ""),))
    with pytest.raises(ValueError, match="is taken"):
        register(taken.rule)


def test_the_manual_is_up_to_date() -> None:
    page = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    assert page == manual(), "write it anew as weaveusd/validate/manual.py says"
