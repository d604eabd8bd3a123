"""Finding and Report: what a judge says about an asset."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any


class Status(IntEnum):
    """Outcome of a check, from best to worst."""

    PASS = 0
    SKIP = 1
    WARN = 2
    FAIL = 3
    ERROR = 4


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing a check found: permanent check id, status, unique code, message, place."""

    check: str
    status: Status
    code: str
    message: str
    where: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Return the finding as JSON types."""
        return {
            "check": self.check,
            "status": self.status.name,
            "code": self.code,
            "message": self.message,
            "where": self.where,
        }


@dataclass(frozen=True, slots=True)
class Report:
    """All findings on one asset, at least one for each check that ran."""

    asset: str
    findings: tuple[Finding, ...]

    @property
    def status(self) -> Status:
        """The worst status found; PASS when there is no finding."""
        return max((f.status for f in self.findings), default=Status.PASS)

    @property
    def passed(self) -> bool:
        """Whether nothing failed; warnings and skips do not fail an asset."""
        return self.status < Status.FAIL

    def as_dict(self) -> dict[str, Any]:
        """Return the report as JSON types."""
        return {
            "asset": self.asset,
            "status": self.status.name,
            "passed": self.passed,
            "findings": [f.as_dict() for f in self.findings],
        }
