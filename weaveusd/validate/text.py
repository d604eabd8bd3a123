"""A report as plain text."""

from __future__ import annotations

from weaveusd.validate.model import Report, Status

_NAMES = {
    Status.PASS: "passed",
    Status.SKIP: "skipped",
    Status.WARN: "warned",
    Status.FAIL: "failed",
    Status.ERROR: "broke down",
}


def as_text(report: Report) -> str:
    """Return `report` as aligned lines, the worst findings first, without trailing newline."""
    lines = [f"{report.asset}: {report.status.name} ({summary(report)})"]

    findings = sorted(report.findings, key=lambda finding: -finding.status)
    wide = max((len(finding.code) for finding in findings), default=0)
    for finding in findings:
        where = f"{finding.where}: " if finding.where else ""
        waived = f" [waived: {finding.waived}]" if finding.waived else ""
        text = _visible(f"{where}{finding.message}{waived}")
        lines.append(f"{finding.status.name:<5}  {finding.code:<{wide}}  {text}")
    return "\n".join(lines)


def summary(report: Report) -> str:
    """Return how many findings there are of each status, and how many are waived."""
    counts = dict.fromkeys(sorted(Status, reverse=True), 0)
    for finding in report.findings:
        counts[finding.status] += not finding.waived
    told = [f"{n} {_NAMES[status]}" for status, n in counts.items() if n]
    if waived := sum(bool(finding.waived) for finding in report.findings):
        told.append(f"{waived} waived")
    return ", ".join(told) or "nothing checked"


def _visible(text: str) -> str:
    """Return `text` with everything that could steer a terminal escaped."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
