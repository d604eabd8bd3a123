from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from tests.validate.assets import PLAIN, PROVENANCE, SATIN, TWILL, cloth, drawn, publish
from tests.validate.faults import FAULTS, Fault
from tests.weaves import plain, satin, twill, woven
from weaveusd.errors import RendererUnavailableError
from weaveusd.render import variant
from weaveusd.shading.shade import shade
from weaveusd.synth.textures import synthesize
from weaveusd.validate.model import Status
from weaveusd.validate.profiles import find_profile
from weaveusd.validate.registry import all_checks
from weaveusd.validate.run import validate

UNPLANTED = {
    "usd-warning",
    "pdf-not-one",
    "sampling-off",
    "distance-color",
    "noise-biased",
    "noise-none",
    "render-not-finite",
}
"""Codes of faults that no file can have; test_renders.py has the renderer commit them."""

try:
    variant.prepare()
    _NO_RENDERER = ""
except RendererUnavailableError as error:
    _NO_RENDERER = str(error)


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(
            fault,
            id=fault.name,
            marks=[] if fault.profile == "quick" else [pytest.mark.slow],
        )
        for fault in FAULTS
    ],
)
def test_a_planted_fault_is_found_under_its_code_and_no_other(fault: Fault, tmp_path: Path) -> None:
    if fault.profile != "quick" and _NO_RENDERER:
        pytest.skip(_NO_RENDERER)
    report = validate(fault.plant(tmp_path / "v001"), profile=fault.judged())
    found = {finding.code for finding in report.findings if finding.status > Status.SKIP}
    assert found == fault.codes


@pytest.mark.parametrize("warp_up", [PLAIN, TWILL, SATIN], ids=["plain", "twill", "satin"])
def test_a_good_asset_passes_every_check(warp_up, tmp_path: Path) -> None:
    report = validate(publish(tmp_path / "v001", cloth(warp_up)))
    assert {finding.status for finding in report.findings} == {Status.PASS}
    expected = [check.id for check in all_checks() if find_profile("quick").runs(check.id)]
    assert [finding.check for finding in report.findings] == expected


@pytest.mark.parametrize("preset", ["linen", "charmeuse", "denim"])
@pytest.mark.parametrize("warp_up", [plain(), twill(1, 3), satin(8, 3)])
def test_what_the_makers_make_passes(warp_up, preset: str, tmp_path: Path) -> None:
    cloth = woven(warp_up, preset)
    source = replace(PROVENANCE, draft_wif=drawn(cloth.warp_up))
    material = shade("cloth", cloth, synthesize(cloth, resolution=160, seed=5), source)
    report = validate(publish(tmp_path / "v001", material))
    assert report.passed
    assert all(finding.code.endswith(("/pass", "-unread")) for finding in report.findings)


def test_every_code_that_fails_or_warns_has_a_fault_planted_for_it() -> None:
    planted = frozenset().union(*(fault.codes for fault in FAULTS))
    codes = {
        code.name
        for check in all_checks()
        for code in check.codes
        if code.status > Status.SKIP and code.name not in UNPLANTED
    }
    assert codes - planted == set()


def test_a_finding_says_where_what_and_what_was_expected(tmp_path: Path) -> None:
    fault = next(fault for fault in FAULTS if fault.name == "packing_above_one")
    report = validate(fault.plant(tmp_path / "v001"))
    (finding,) = (f for f in report.findings if f.status > Status.SKIP)
    assert finding.check == "attribute/yarns"
    assert finding.where == "/shot_twill/Material.weave:yarn:ecru:packing"
    assert finding.message == "is 60.0, expected 0 to 1"
