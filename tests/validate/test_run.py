from __future__ import annotations

import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

import weaveusd.validate
from tests.validate.assets import publish
from weaveusd.contract import MANIFEST_FILE
from weaveusd.errors import InputError, StageError
from weaveusd.validate.model import Finding, Report, Status
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.profiles import find_profile
from weaveusd.validate.registry import all_checks
from weaveusd.validate.run import MAX_FINDINGS, run_check, validate
from weaveusd.validate.text import as_text

JUDGED = [
    c.id for c in all_checks() if find_profile("quick").runs(c.id) and c.id != "files/manifest"
]


@pytest.fixture(scope="module")
def entry(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return publish(tmp_path_factory.mktemp("asset") / "v001")


def test_the_package_itself_can_be_called(entry: Path) -> None:
    assert weaveusd.validate(entry).passed


def test_progress_grows_to_one(entry: Path) -> None:
    told: list[float] = []
    validate(entry, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0
    assert len(told) > len(JUDGED)


def test_checks_are_chosen_by_id_or_by_family(entry: Path) -> None:
    report = validate(entry, checks=["path", "texture/tiles"])
    assert [finding.check for finding in report.findings] == ["path/anchored", "texture/tiles"]


def test_a_check_that_does_not_exist_is_refused(entry: Path) -> None:
    with pytest.raises(InputError, match="no check is called 'texture/seams'"):
        validate(entry, checks=["texture/seams"])


def test_what_cannot_be_opened_is_no_report(tmp_path: Path) -> None:
    with pytest.raises(StageError, match="no such file"):
        validate(tmp_path / "absent.usda")


def test_a_moved_asset_still_passes_from_another_working_directory(
    entry: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(entry.parent, tmp_path / "moved")
    monkeypatch.chdir(tmp_path)
    assert validate(os.path.join("moved", entry.name)).passed


def test_judging_an_asset_leaves_its_files_alone(entry: Path) -> None:
    def state() -> dict[Path, tuple[int, bytes]]:
        files = [path for path in entry.parent.rglob("*") if path.is_file()]
        return {path: (path.stat().st_mtime_ns, path.read_bytes()) for path in files}

    before = state()
    validate(entry)
    assert state() == before


def test_an_edited_asset_is_read_anew(entry: Path, tmp_path: Path) -> None:
    folder = tmp_path / "v001"
    shutil.copytree(entry.parent, folder)
    kept = OpenAsset(folder / entry.name)
    look = folder / "look.usda"
    look.write_text(look.read_text().replace("weave:shafts = 4", "weave:shafts = -4"))
    os.utime(look, ns=(0, 10**18))
    report = validate(folder / entry.name, checks=["attribute/cloth"])
    assert kept.material
    assert not report.passed


def test_before_publishing_the_manifest_is_skipped(entry: Path, tmp_path: Path) -> None:
    folder = tmp_path / "v001"
    shutil.copytree(entry.parent, folder)
    (folder / MANIFEST_FILE).unlink()
    (finding,) = validate(folder / entry.name, checks=["files"]).findings
    assert (finding.status, finding.code) == (Status.SKIP, "manifest-none")


def test_a_check_that_raises_is_an_error_and_not_a_crash(entry: Path) -> None:
    def broken(asset: OpenAsset):
        yield from ()
        raise RuntimeError("two\nlines")

    check = replace(all_checks()[0], rule=broken)
    (finding,) = run_check(check, OpenAsset(entry))
    assert finding.status is Status.ERROR
    assert finding.message == "the check broke down: RuntimeError: two lines"


def test_a_check_lists_so_many_findings_and_counts_the_rest(entry: Path) -> None:
    code = all_checks()[0].codes[0]
    check = replace(all_checks()[0], rule=lambda asset: (code("again") for _ in range(50)))
    findings = list(run_check(check, OpenAsset(entry)))
    assert len(findings) == MAX_FINDINGS
    assert findings[-1].message == f"again (and {50 - MAX_FINDINGS} more)"


def test_a_check_is_skipped_with_the_reason_when_what_it_needs_is_absent(
    entry: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "v001"
    shutil.copytree(entry.parent, folder)
    (folder / "textures" / "normal.exr").unlink()
    (finding,) = validate(folder / entry.name, checks=["texture/tiles"]).findings
    assert (finding.status, finding.message) == (Status.SKIP, "not every texture can be read")


def test_a_stage_without_a_cloth_fails_and_breaks_no_check(tmp_path: Path) -> None:
    stage = tmp_path / "empty.usda"
    stage.write_text("#usda 1.0\n")
    report = validate(stage)
    assert report.status is Status.FAIL
    assert {"root-not-scope", "stage-metadata"} <= {finding.code for finding in report.findings}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("uniform int weave:ends = 4", 'uniform string weave:ends = "4"'),
        ("uniform int weave:ends = 4", "uniform int weave:ends = 2147483647"),
        ("uniform int weave:picks = 4", "uniform int weave:picks = -1"),
        ("uniform double weave:repeatWidth = 2", "uniform double weave:repeatWidth = inf"),
        ("uniform double weave:repeatWidth = 2", 'uniform string weave:repeatWidth = "2"'),
        ("uniform double weave:thickness = 0.5", "uniform token[] weave:thickness = []"),
        ('uniform token[] weave:yarns = ["ecru", "indigo"]', "uniform int weave:yarns = 3"),
        (
            'uniform token[] weave:yarns = ["ecru", "indigo"]',
            f"uniform token[] weave:yarns = {json.dumps([f'y{k}' for k in range(400)])}",
        ),
        ("color3f weave:yarn:ecru:color = (0.6, 0.5, 0.4)", "double weave:yarn:ecru:color = 3"),
        ("weave:yarn:ecru:twistAngle = 0.2", "weave:yarn:ecru:twistAngle = nan"),
        ("float2 inputs:uv_scale = (500, 500)", "float3 inputs:uv_scale = (500, 500, 1)"),
        ("float[] inputs:eta = [1.54, 1.54]", "float[] inputs:eta = [nan, inf]"),
        ('token info:id = "weaveusd_cloth"', "token info:id"),
    ],
)
def test_no_nonsense_in_the_look_breaks_a_check(
    entry: Path, tmp_path: Path, old: str, new: str
) -> None:
    folder = tmp_path / "v001"
    shutil.copytree(entry.parent, folder)
    text = (folder / "look.usda").read_text()
    assert old in text
    (folder / "look.usda").write_text(text.replace(old, new))
    report = validate(folder / entry.name, checks=JUDGED)
    assert report.status is Status.FAIL
    assert all(len(finding.message) < 500 for finding in report.findings)


def test_the_report_as_json_holds_every_finding(entry: Path) -> None:
    report = validate(entry)
    data = json.loads(json.dumps(report.as_dict()))
    assert data["passed"] is True
    assert len(data["findings"]) == len(report.findings)


def test_the_text_lists_the_worst_first_and_lines_up() -> None:
    report = Report(
        "cloth.usda",
        (
            Finding("a/b", Status.PASS, "a/b/pass", "All is well."),
            Finding("c/d", Status.FAIL, "torn", "has a hole", "sleeve"),
        ),
    )
    assert as_text(report).splitlines() == [
        "cloth.usda: FAIL (1 failed, 1 passed)",
        "FAIL   torn      sleeve: has a hole",
        "PASS   a/b/pass  All is well.",
    ]


def test_the_text_cannot_steer_a_terminal() -> None:
    report = Report("c.usda", (Finding("a/b", Status.FAIL, "x", "\x1b[2J\nnext"),))
    text = as_text(report)
    assert "\x1b" not in text
    assert len(text.splitlines()) == 2
