"""A waiver lets a finding pass, for a reason and until a day, and hides nothing."""

from __future__ import annotations

import datetime
from pathlib import Path

import pytest

from weaveusd.errors import InputError
from weaveusd.validate.model import Finding, Report, Status
from weaveusd.validate.text import as_text
from weaveusd.validate.waivers import EXPIRED, UNUSED, apply_waivers, read_waivers

TODAY = datetime.date(2026, 11, 22)
WAIVERS = """\
[[waiver]]
code = "color-disagrees"
where = "textures/base_color.exr"
reason = "The client chose it so."
by = "A. Weaver"
date = 2026-11-01
until = 2026-12-01
"""
COLOR = Finding(
    "agreement/colors", Status.FAIL, "color-disagrees", "is off", "textures/base_color.exr"
)


def waived(tmp_path: Path, text: str, *findings: Finding, today: datetime.date = TODAY) -> Report:
    path = tmp_path / "waivers.toml"
    path.write_text(text)
    return apply_waivers(Report("cloth.usda", findings, "quick"), read_waivers(path), today)


def test_a_waived_failure_passes_and_is_shown_with_its_reason(tmp_path: Path) -> None:
    report = waived(tmp_path, WAIVERS, COLOR)
    assert report.passed
    assert report.status is Status.PASS
    (finding,) = report.findings
    assert finding.status is Status.FAIL, "it stays what it is"
    assert finding.waived == "The client chose it so. (2026-11-01, A. Weaver, until 2026-12-01)"
    assert "1 waived" in as_text(report)
    assert "The client chose it so." in as_text(report)
    assert report.as_dict()["findings"][0]["waived"] == finding.waived


@pytest.mark.parametrize(
    "finding",
    [
        Finding("agreement/colors", Status.FAIL, "color-disagrees", "is off", "textures/other.exr"),
        Finding("agreement/colors", Status.FAIL, "color-misplaced", "is off", COLOR.where),
        Finding("agreement/colors", Status.ERROR, "color-disagrees", "broke", COLOR.where),
    ],
    ids=["another place", "another code", "an error"],
)
def test_a_waiver_covers_its_code_and_place_and_never_an_error(
    tmp_path: Path, finding: Finding
) -> None:
    report = waived(tmp_path, WAIVERS, finding)
    assert not report.passed
    assert [f.code for f in report.findings] == [finding.code, UNUSED]


def test_a_waiver_holds_to_the_end_of_its_last_day(tmp_path: Path) -> None:
    last = datetime.date(2026, 12, 1)
    assert waived(tmp_path, WAIVERS, COLOR, today=last).passed
    report = waived(tmp_path, WAIVERS, COLOR, today=last + datetime.timedelta(days=1))
    assert not report.passed
    assert [f.code for f in report.findings] == ["color-disagrees", EXPIRED]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('reason = "The client chose it so."\n', "", "waiver 1: reason is missing"),
        ("date = 2026-11-01\n", "", "waiver 1: date is missing"),
        ("date = 2026-11-01", 'date = "soon"', "date is 'soon', expected date"),
        ("until = 2026-12-01", "until = 2026-01-01", "until is 2026-01-01, before its date"),
        ('by = "A. Weaver"', 'bye = "A. Weaver"', "unknown key 'bye'"),
        ("[[waiver]]", "[waiver]", "expected a list"),
    ],
)
def test_a_broken_waiver_is_refused_in_one_line(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    path = tmp_path / "waivers.toml"
    path.write_text(WAIVERS.replace(old, new))
    with pytest.raises(InputError, match=message) as error:
        read_waivers(path)
    assert str(error.value).startswith(str(path))
