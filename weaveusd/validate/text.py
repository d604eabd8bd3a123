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
    counts = dict.fromkeys(sorted(Status, reverse=True), 0)
    for finding in report.findings:
        counts[finding.status] += 1
    summary = ", ".join(f"{n} {_NAMES[status]}" for status, n in counts.items() if n)
    lines = [f"{report.asset}: {report.status.name} ({summary or 'nothing checked'})"]

    findings = sorted(report.findings, key=lambda finding: -finding.status)
    wide = max((len(finding.code) for finding in findings), default=0)
    for finding in findings:
        where = f"{finding.where}: " if finding.where else ""
        text = _visible(f"{where}{finding.message}")
        lines.append(f"{finding.status.name:<5}  {finding.code:<{wide}}  {text}")
    return "\n".join(lines)


def _visible(text: str) -> str:
    """Return `text` with everything that could steer a terminal escaped."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
