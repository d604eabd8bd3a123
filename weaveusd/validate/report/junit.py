"""A report as JUnit XML, which build servers show."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence

from weaveusd.validate.model import Finding, Report, Status

_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def as_junit(report: Report) -> str:
    """Return the report as XML: a test case for each check.

    Findings that fail are failures, those of a check that broke down errors; warnings and what is
    waived are told in the output of a case that passes. A check that was skipped is skipped.
    """
    cases: dict[str, list[Finding]] = {}
    for finding in report.findings:
        cases.setdefault(finding.check, []).append(finding)
    suite = ET.Element("testsuite", name="weaveusd validate")
    counts = dict.fromkeys(("failures", "errors", "skipped"), 0)
    for check, findings in cases.items():
        case = ET.SubElement(
            suite, "testcase", classname=check.partition("/")[0], name=_text(check)
        )
        kind = _add_outcome(case, findings)
        if kind:
            counts[kind] += 1
    suite.set("tests", str(len(cases)))
    for name, count in counts.items():
        suite.set(name, str(count))
    properties = ET.Element("properties")
    for name, value in (("asset", report.asset), ("profile", report.profile)):
        ET.SubElement(properties, "property", name=name, value=_text(value))
    suite.insert(0, properties)
    ET.indent(suite)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(suite, "unicode") + "\n"


def _add_outcome(case: ET.Element, findings: Sequence[Finding]) -> str:
    """Add what the findings of one check mean; return what the suite counts it as."""
    worst = max((f.status for f in findings if not f.waived), default=Status.PASS)
    names = {
        Status.ERROR: ("error", "errors"),
        Status.FAIL: ("failure", "failures"),
        Status.SKIP: ("skipped", "skipped"),
    }
    told = [f for f in findings if f.status > Status.PASS and (f.status < worst or f.waived)]
    element, counted = names.get(worst, ("", ""))
    if element:
        outcome = ET.SubElement(case, element)
        lines = [_line(f) for f in findings if f.status == worst and not f.waived]
        outcome.set("message", lines[0])
        outcome.text = "\n".join(lines)
    elif worst is Status.WARN:
        told = [f for f in findings if f.status > Status.PASS]
    if told:
        ET.SubElement(case, "system-out").text = "\n".join(map(_line, told))
    return counted


def _line(finding: Finding) -> str:
    where = f"{finding.where}: " if finding.where else ""
    waived = f" [waived: {finding.waived}]" if finding.waived else ""
    return _text(f"{finding.status.name} {finding.code}: {where}{finding.message}{waived}")


def _text(text: str) -> str:
    """Return `text` without what XML cannot hold."""
    return _NOT_IN_XML.sub("�", text)
