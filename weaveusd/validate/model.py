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
    """One thing a check found: permanent check id, status, unique code, message, place.

    `waived` is the reason for which it is let pass, empty where it is not.
    """

    check: str
    status: Status
    code: str
    message: str
    where: str = ""
    waived: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Return the finding as JSON types."""
        return {
            "check": self.check,
            "status": self.status.name,
            "code": self.code,
            "message": self.message,
            "where": self.where,
            "waived": self.waived,
        }


@dataclass(frozen=True, slots=True)
class Report:
    """All findings on one asset, at least one for each check that ran, under a profile."""

    asset: str
    findings: tuple[Finding, ...]
    profile: str = ""

    @property
    def status(self) -> Status:
        """The worst status found and not waived; PASS when there is none."""
        return max((f.status for f in self.findings if not f.waived), default=Status.PASS)

    @property
    def passed(self) -> bool:
        """Whether nothing failed that is not waived; warnings and skips fail no asset."""
        return self.status < Status.FAIL

    def as_dict(self) -> dict[str, Any]:
        """Return the report as JSON types."""
        return {
            "asset": self.asset,
            "profile": self.profile,
            "status": self.status.name,
            "passed": self.passed,
            "findings": [f.as_dict() for f in self.findings],
        }
