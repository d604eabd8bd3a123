"""Waivers: findings that somebody answers for, with a reason and a date, shown in the report."""

from __future__ import annotations

import datetime
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from weaveusd.errors import InputError
from weaveusd.validate.model import Finding, Report, Status
from weaveusd.validate.tables import known_keys, read_toml

CHECK = "waivers/kept"
EXPIRED, UNUSED = "waiver-expired", "waiver-unused"

_KEYS: dict[str, type | tuple[type, ...]] = {
    "code": str, "where": str, "reason": str, "by": str,
    "date": datetime.date, "until": datetime.date,
}  # fmt: skip
_NEEDED = ("code", "reason", "date")


@dataclass(frozen=True, slots=True)
class Waiver:
    """Leave to pass with one finding.

    `code` is a finding's, `where` its place or empty for every place. It holds up to and with the
    day `until`, for ever without one.
    """

    code: str
    reason: str
    date: datetime.date
    until: datetime.date | None = None
    where: str = ""
    by: str = ""

    def covers(self, finding: Finding) -> bool:
        """Whether it is about `finding`: a WARN or FAIL of its code and place, never an ERROR."""
        return (
            finding.status in (Status.WARN, Status.FAIL)
            and finding.code == self.code
            and self.where in ("", finding.where)
        )

    def text(self) -> str:
        """Return reason, date and who, as a report shows them."""
        who = f", {self.by}" if self.by else ""
        until = f", until {self.until.isoformat()}" if self.until else ""
        return f"{self.reason} ({self.date.isoformat()}{who}{until})"


def read_waivers(path: str | os.PathLike[str]) -> tuple[Waiver, ...]:
    """Return the waivers of the TOML file `path`, an array of tables `waiver`.

    Raises
    ------
    InputError
        One line that names file and waiver, for a key that is missing, unknown or of another type.
    """
    where = os.fspath(path)
    data = read_toml(Path(path))
    known_keys(where, data, {"waiver": list})
    return tuple(
        _waiver(f"{where}: waiver {number}", table)
        for number, table in enumerate(data.get("waiver", []), start=1)
    )


def apply_waivers(report: Report, waivers: Sequence[Waiver], today: datetime.date) -> Report:
    """Return the report with the findings that `waivers` cover marked as waived.

    A waiver that is over, or covers nothing, is a finding of status WARN itself.
    """
    valid = [waiver for waiver in waivers if waiver.until is None or today <= waiver.until]
    used: set[Waiver] = set()
    findings = []
    for finding in report.findings:
        waiver = next((waiver for waiver in valid if waiver.covers(finding)), None)
        if waiver is not None:
            used.add(waiver)
            finding = replace(finding, waived=waiver.text())
        findings.append(finding)
    for waiver in waivers:
        if waiver not in valid:
            message = f"the waiver of {waiver.code} is over: {waiver.text()}"
            findings.append(Finding(CHECK, Status.WARN, EXPIRED, message, waiver.where))
        elif waiver not in used:
            message = f"nothing is found that the waiver of {waiver.code} covers: {waiver.text()}"
            findings.append(Finding(CHECK, Status.WARN, UNUSED, message, waiver.where))
    return Report(report.asset, tuple(findings), report.profile)


def _waiver(where: str, table: Any) -> Waiver:
    known_keys(where, table, _KEYS)
    for key in _NEEDED:
        if not table.get(key):
            raise InputError(f"{where}: {key} is missing")
    days = {key: _day(table[key]) for key in ("date", "until") if key in table}
    if "until" in days and days["until"] < days["date"]:
        raise InputError(f"{where}: until is {days['until']}, before its date {days['date']}")
    return Waiver(**{**table, **days})


def _day(value: datetime.date) -> datetime.date:
    return value.date() if isinstance(value, datetime.datetime) else value
