"""Whatever a stage does to the process that judges it, the caller gets a report."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.validate.assets import publish
from tests.validate.faults import FAULTS
from weaveusd.errors import InputError, StageError
from weaveusd.pipeline import validate as validate_from_pipeline
from weaveusd.validate.apart import validate_apart
from weaveusd.validate.model import Status
from weaveusd.validate.run import validate

DEEP = 100_000  # nested prims, on which the parser of USD runs out of stack


@pytest.fixture(scope="module")
def entry(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return publish(tmp_path_factory.mktemp("asset") / "v001")


def test_a_child_finds_what_is_found_here(entry: Path, tmp_path: Path) -> None:
    shares: list[float] = []
    assert validate_apart(entry, progress=shares.append) == validate(entry)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    faulty = next(f for f in FAULTS if f.name == "gamma_encoded_normals").plant(tmp_path / "v001")
    checks = ["texture", "path/anchored"]
    assert validate_apart(faulty, checks=checks, jobs=1) == validate(faulty, checks=checks)


def test_a_stage_that_crashes_usd_is_an_error_and_not_a_crash(tmp_path: Path) -> None:
    stage = tmp_path / "deep.usda"
    stage.write_text("#usda 1.0\n" + 'def "a" {\n' * DEEP + "}\n" * DEEP)
    report = validate_from_pipeline(stage)
    (finding,) = report.findings
    assert (finding.status, finding.code) == (Status.ERROR, "process-crashed")
    assert finding.message == "the process that judges the stage was ended by SIGSEGV"
    assert not report.passed


def test_a_stage_that_takes_too_long_is_an_error(entry: Path) -> None:
    (finding,) = validate_apart(entry, seconds=0.05).findings
    assert (finding.status, finding.code) == (Status.ERROR, "process-late")
    assert finding.message == "judging the stage took more than 0.05 s"


def test_a_stage_that_takes_too_much_memory_is_an_error(entry: Path) -> None:
    report = validate_apart(entry, memory_bytes=30 << 20)
    assert report.status is Status.ERROR


def test_a_broken_stage_is_told_as_if_it_were_opened_here(tmp_path: Path) -> None:
    stage = tmp_path / "broken.usda"
    stage.write_text("#usda 1.0\ndef {")
    with pytest.raises(StageError) as here:
        validate(stage)
    with pytest.raises(StageError) as apart:
        validate_apart(stage)
    assert str(apart.value) == str(here.value)
    with pytest.raises(InputError, match="no check is called 'texture/seams'"):
        validate_apart(stage, checks=["texture/seams"])


def test_no_module_of_the_working_directory_is_run(
    entry: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("json", "numpy", "weaveusd"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit(9)")
    monkeypatch.chdir(tmp_path)
    assert validate_apart(entry, checks=["path"]).passed
