"""The report that is archived: one page without neighbours, JSON and JUnit XML."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from tests.validate.assets import publish
from tests.validate.faults import FAULTS
from weaveusd.errors import InputError
from weaveusd.pipeline import validate
from weaveusd.validate.model import Finding, Report, Status
from weaveusd.validate.report.junit import as_junit
from weaveusd.validate.report.page import as_page
from weaveusd.validate.report.write import write_report

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report without renders on a faulty asset, one of whose findings is waived."""
    root = tmp_path_factory.mktemp("report")
    fault = next(f for f in FAULTS if f.name == "colors_shifted_by_three_rows")
    waivers = root / "waivers.toml"
    waivers.write_text('[[waiver]]\ncode = "color-misplaced"\nreason = "So."\ndate = 2026-01-01\n')
    validate(fault.plant(root / "v001"), waivers=waivers, report=root / "report")
    return root / "report"


def test_the_page_shows_verdict_findings_channels_draft_yarns_and_hashes(folder: Path) -> None:
    page = (folder / "report.html").read_text(encoding="utf-8")
    for wanted in (
        "not passed", "color-disagrees", "WAIVED", "Waived: So.", "base_color.exr", "normal.exr",
        "Drawdown", "Lobes", "twistAngle [rad]", "draftSha256", "look.usda",
        "Losses and use", "profile quick",
    ):  # fmt: skip
        assert wanted in page


def test_the_page_loads_nothing_and_runs_nothing(folder: Path) -> None:
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "<script" not in page
    assert not re.search(r"""(?:src|href)=["'](?!data:)""", page)
    assert "default-src 'none'" in page


def test_nothing_in_a_finding_becomes_markup() -> None:
    evil = "<img src=x onerror=alert(1)>\"'&"
    report = Report(evil, (Finding("a/b", Status.FAIL, evil, evil, evil, evil),), evil)
    shown = {"name": evil, "yarns": [[evil, evil]], "readme": evil, "absent": {evil: evil}}
    page = as_page(report, shown, version="0", made=evil)
    assert "<img src=x" not in page


def test_json_and_junit_say_the_same_as_the_page(folder: Path) -> None:
    data = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    suite = ET.fromstring((folder / "report.xml").read_text(encoding="utf-8"))
    assert data["passed"] is False
    assert data["profile"] == "quick"
    checks = {finding["check"] for finding in data["findings"]}
    assert suite.get("tests") == str(len(checks))
    failed = {
        case.get("name") for case in suite.iter("testcase") if case.find("failure") is not None
    }
    assert failed == {"agreement/colors"}


def test_junit_never_counts_a_skip_as_a_pass() -> None:
    findings = (
        Finding("a/skip", Status.SKIP, "unread", "too coarse"),
        Finding("a/warn", Status.WARN, "odd", "is odd\x00"),
        Finding("a/error", Status.ERROR, "broke", "broke down"),
        Finding("a/waived", Status.FAIL, "torn", "has a hole", waived="So."),
    )
    suite = ET.fromstring(as_junit(Report("c.usda", findings)))
    counts = {name: suite.get(name) for name in ("tests", "failures", "errors", "skipped")}
    assert counts == {"tests": "4", "failures": "0", "errors": "1", "skipped": "1"}
    told = [case.findtext("system-out") for case in suite.iter("testcase")]
    assert told[1] == "WARN odd: is odd�"
    assert "waived: So." in str(told[3])


def test_a_stage_that_crashes_the_judge_has_a_report_too(tmp_path: Path) -> None:
    stage = tmp_path / "deep.usda"
    stage.write_text("#usda 1.0\n" + 'def "a" {\n' * 100_000 + "}\n" * 100_000)
    validate(stage, report=tmp_path / "report")
    assert "process-crashed" in (tmp_path / "report" / "report.html").read_text(encoding="utf-8")


def test_a_broken_asset_has_a_page_that_says_what_it_cannot_show(tmp_path: Path) -> None:
    entry = publish(tmp_path / "v001")
    for name in ("draft.wif", "manifest.json", "README.md"):
        (entry.parent / name).unlink(missing_ok=True)
    (entry.parent / "textures" / "normal.exr").write_bytes(b"nothing")
    validate(entry, report=tmp_path / "report")
    page = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    assert "Not shown" in page
    assert "base_color.exr, 64 × 64" in page


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="the report cannot be written"):
        write_report(Report("c.usda", ()), None, tmp_path / "file" / "report", made="today")


@pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium on this machine")
def test_the_page_opens_in_chromium_without_an_error_on_its_console(
    folder: Path, tmp_path: Path
) -> None:
    assert CHROMIUM is not None
    picture = tmp_path / "page.png"
    done = subprocess.run(
        [
            CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr",
            f"--user-data-dir={tmp_path / 'profile'}", "--window-size=1200,2000",
            f"--screenshot={picture}", (folder / "report.html").as_uri(),
        ],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    assert picture.stat().st_size > 20_000
    assert "CONSOLE" not in done.stderr
